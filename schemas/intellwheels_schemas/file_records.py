"""The lines of `input.jsonl` and `trace.jsonl`, which the simulator writes and experiments read.

Both files are JSON Lines: a header, then one line per tick. `input.jsonl` is the input log: a run is a function of its
header and its ticks, so a second run from the log gives the same hashes. `trace.jsonl` has the true state at each tick
of such a run. Numbers have full precision. The headers have a version; a file of another version is refused.
`log_chain` says how the checksums of an input log are made, and `input_reader` reads one.

Units and frames are those of `messages`. The string below a field describes the field.
"""

from __future__ import annotations

from typing import Annotated, Final, Literal, TypeVar

import msgspec
from msgspec import Meta

from intellwheels_schemas import defaults
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import (
    Actions,
    End,
    Event,
    EventCode,
    Hex,
    Map,
    Pose,
    Position,
    Robot,
    UserInput,
    Word,
)

FORMAT: Final = "iw.v1"
"""Version of the contract that the messages within a file follow."""
VERSION: Final = 1
"""Version of the lines themselves. Raise it when a reader of this version could not understand the new lines."""
CHAINED: Final = 2
"""Version of an input log whose lines have checksums and which ends with an `InputEnd`; version 1 has neither."""

RunId = Annotated[str, Meta(description="Id of the run.")]
AgentName = Annotated[str, Meta(description="Name of the agent that this concerns.")]
SlotName = Annotated[str, Meta(description="Name of the saved state.")]
Version = Annotated[int, Meta(description="Version of the lines of this file; a header without one means version 1.")]
Checksum = Annotated[
    str,
    Meta(
        description="The last field of its line: 16 hex digits of BLAKE2b-64 over the Chain of the line before, if "
        "there is one, and the bytes of this line before the comma that precedes `Chain`. Absent in version 1."
    ),
]


class FileRecord(msgspec.Struct, rename="pascal", frozen=True, omit_defaults=True):
    """Base of every line and every part of a line. Readers ignore fields that they do not know."""


# ---------------------------------------------------------------- inputs of a tick


class Join(FileRecord, frozen=True, kw_only=True, tag="Join", tag_field="Do"):
    """An agent joins with a body, or with role `mind` as the mind of an existing body.

    The service has checked name, token and session. The world checks the robot and finds the place.
    """

    agent: AgentName
    robot: Robot
    """Robot that the agent requested."""
    reserved: tuple[Word, ...] = ()
    """Places of the map that are kept for other agents."""


class Depart(FileRecord, frozen=True, kw_only=True, tag="Depart", tag_field="Do"):
    """An agent gives up a role: it left, or its token was lost for longer than the grace time."""

    agent: AgentName
    role: Literal["both", "body", "mind"] = "both"
    """Role that ends."""
    lost: bool = False
    """Whether the token was lost; false means that the agent left."""


class SpawnBody(FileRecord, frozen=True, kw_only=True, tag="Spawn", tag_field="Do"):
    """An operator adds a body without a mind."""

    robot: Robot
    """Body to add; its Name is the name of the new agent."""
    position: Position | None = None
    """Start pose; absent means the robot's Place or Position, or the first free place for its Kind."""
    reserved: tuple[Word, ...] = ()
    """Places of the map that are kept for agents."""


class DeleteBody(FileRecord, frozen=True, kw_only=True, tag="Delete", tag_field="Do"):
    """An operator removes a body."""

    agent: AgentName


class TeleportBody(FileRecord, frozen=True, kw_only=True, tag="Teleport", tag_field="Do"):
    """An operator moves a body to another pose."""

    agent: AgentName
    position: Position
    """New pose of the body."""
    force: bool = False
    """Whether the body is moved even if it then overlaps something."""


class TakeBody(FileRecord, frozen=True, kw_only=True, tag="Take", tag_field="Do"):
    """An operator takes control of a body or returns it."""

    agent: AgentName
    on: bool = True
    """Whether the user's input controls the body from now on; false means that the mind does."""


class Speech(FileRecord, frozen=True, kw_only=True, tag="Speech", tag_field="Do"):
    """A message from an operator, received at the next tick."""

    text: str
    """Text of the message."""
    to: str | None = None
    """Agent that receives the message; absent means all agents."""


class Note(FileRecord, frozen=True, kw_only=True, tag="Note", tag_field="Do"):
    """An event that changes no body: paused, resumed, speed, lost, returned."""

    code: EventCode
    """What happened."""
    agent: str | None = None
    """Agent that the event is about, if any."""
    speed: float | None = None
    """In an event speed, the new ratio of simulated time to wall time."""
    text: str | None = None
    """Details for people, if there are any."""


class Restart(FileRecord, frozen=True, kw_only=True, tag="Restart", tag_field="Do"):
    """A reset or, if `Map` is present, a load: a new run from tick 0 with the same bodies at their start poses."""

    run: Annotated[str, Meta(description="Id of the new run.")]
    seed: str
    """Seed of the new run's noise."""
    map: Map | None = None
    """Map of the new run; absent keeps the current one."""
    end: End | None = None
    """End condition of the new run; absent keeps the current one."""


class SaveState(FileRecord, frozen=True, kw_only=True, tag="Save", tag_field="Do"):
    """Save the state after the changes before this one."""

    slot: SlotName


class RestoreState(FileRecord, frozen=True, kw_only=True, tag="Restore", tag_field="Do"):
    """Return to a saved state, at its tick, as a new run."""

    slot: SlotName
    run: Annotated[str, Meta(description="Id of the new run.")]


class GoOn(FileRecord, frozen=True, kw_only=True, tag="GoOn", tag_field="Do"):
    """Continue after the end of the run: the end condition no longer applies."""


Change = (
    Join
    | Depart
    | SpawnBody
    | DeleteBody
    | TeleportBody
    | TakeBody
    | Speech
    | Note
    | Restart
    | SaveState
    | RestoreState
    | GoOn
)

VerdictCode = Literal["late", "rested", "back", "silent", "stale", "fresh", "halt", "unhalt"]


class Said(FileRecord, frozen=True, kw_only=True):
    """A message that an agent sent as a `Say`, separately from its `Actions`."""

    agent: AgentName
    text: str
    """Text of the message."""
    seq: int | None = None
    """Seq of the sender's message, if it had one."""


class Verdict(FileRecord, frozen=True, kw_only=True):
    """A finding of the service about an agent. It depends on wall time, which the world does not know.

    `late`: no answer before the deadline. `rested`: the motors get power 0 after three missed deadlines, until `back`.
    `silent`: no user input for 0.3 s. `stale`: no new pose of a real body, until `fresh`. `halt`: the motors of a real
    body get power 0 because of a pause or a speed other than 1, until `unhalt`.
    """

    agent: AgentName
    code: VerdictCode
    """The finding."""


class Inputs(FileRecord, frozen=True, kw_only=True):
    """All inputs of one step.

    Changes apply at a tick, in the given order, before its measures are taken. Actions, poses, user input and verdicts
    apply to the step from that tick to the next.
    """

    changes: tuple[Change, ...] = ()
    """Joins, leaves and the changes by operators, in order."""
    actions: dict[str, Actions] = {}
    """Commands of the minds, by the name of the agent."""
    says: tuple[Said, ...] = ()
    """Messages that were sent separately from commands, in order."""
    poses: dict[str, Pose] = {}
    """Poses of real bodies from their bridges, by the name of the agent."""
    user_input: dict[str, UserInput] = {}
    """Inputs of people, by the name of the agent that they steer."""
    verdicts: tuple[Verdict, ...] = ()
    """Findings of the service about deadlines, in order."""


# ---------------------------------------------------------------- input.jsonl


class WorldRules(FileRecord, frozen=True, kw_only=True, omit_defaults=False):
    """Settings of the world other than map, seed and period. Their bounds are those of the options of `iw-server`."""

    say_limit: Annotated[int, Meta(ge=1, le=1000)]
    """Longest message that an agent may send to others, in Unicode code points."""
    say_range: Annotated[float, Meta(gt=0.0, le=20_000.0)]
    """Largest distance between the sender and a receiver of a message, in metres."""
    command_timeout: Annotated[float, Meta(gt=0.0, le=1e9)]
    """Simulated seconds without a motor command after which both powers become 0."""
    truth: bool
    """Whether agents may have truth sensors."""
    strict: bool
    """Whether a missed deadline in lockstep ends the run."""
    end: End | None = None
    """End condition of the first run; null, which is allowed here, or absent means none."""
    say_walls: bool = defaults.SAY_WALLS
    """Whether walls and closed doors block messages."""
    say_loss: Annotated[float, Meta(ge=0.0, le=1.0)] = defaults.SAY_LOSS
    """Share of messages between agents that a receiver misses."""
    say_delay: Annotated[float, Meta(ge=0.0, le=3600.0)] = defaults.SAY_DELAY
    """Simulated seconds by which a message is delayed, in addition to one tick."""


class InputHeader(FileRecord, frozen=True, kw_only=True, omit_defaults=False):
    """The first line of an input log: the setup of the world."""

    log: str
    """Version of the contract that the messages in the file follow."""
    version: Version = VERSION
    run: Annotated[Hex, Meta(description="Id of the first run in the file.")]
    map: Map
    """Map of the first run."""
    seed: str
    """Seed of all noise in the first run."""
    period: Annotated[float, Meta(ge=0.001, le=1.0)]
    """Simulated seconds from one tick to the next."""
    setup: WorldRules
    """Further settings of the world."""
    world: str = defaults.WORLD
    """Name of the world, as in its keys."""
    versions: dict[str, str] = {}
    """Versions of Python and of the packages that wrote the file."""
    cpu: str = ""
    """Processor that the kernels were compiled for."""
    chain: Checksum = ""


class InputTick(FileRecord, frozen=True, kw_only=True):
    """A line of an input log after the header: the inputs of a step, or changes without a step."""

    tick: int
    """Tick at which the inputs apply; the step leads to the next tick."""
    inputs: Inputs
    """Inputs at this tick."""
    hash: str
    """Hash of the state after the step, 16 hex digits; without a step, the hash of the state at the tick."""
    stepped: bool = True
    """Whether a step was made; false for a reset, and for changes after the last step."""
    chain: Checksum = ""


class InputEnd(FileRecord, frozen=True, kw_only=True):
    """The last line of an input log of version 2 that was closed in order. A log without it was truncated."""

    end: Literal["closed"]
    """What ended the log."""
    lines: int
    """Number of lines before this one, with the header."""
    chain: Checksum = ""


# ---------------------------------------------------------------- trace.jsonl


class TraceHeader(FileRecord, frozen=True, kw_only=True, omit_defaults=False):
    """The first line of a trace: the run that it belongs to."""

    trace: str = FORMAT
    """Version of the contract that the events in the file follow."""
    version: Version = VERSION
    run: RunId
    seed: str
    """Seed of all noise in the run."""
    period: float
    """Simulated seconds from one tick to the next."""
    floor: str
    """Name of the map."""


class TraceBody(FileRecord, frozen=True, kw_only=True):
    """The true state of a body at a tick."""

    pose: tuple[float, float, float]
    """X and Y in metres and heading in radians, in the map frame; heading positive anticlockwise, in (-pi, pi]."""
    speed: float = 0.0
    """Speed of the centre of movement in m/s, forward positive."""
    turn_rate: float = 0.0
    """Rate of turn in rad/s, positive anticlockwise."""
    power: tuple[float, float] = (0.0, 0.0)
    """Power of the left and the right motor in the step to this tick, in [-1, 1], positive forward."""
    collision: bool = False
    """Whether an obstacle prevented the commanded motion in the step to this tick."""
    touching: bool = False
    """Whether the body touches a wall or another body."""
    contacts: int = 0
    """Number of contact episodes since the start of the run."""
    mode: str | None = None
    """What the mind says it is doing, from its Actions."""
    wheels: tuple[int, int] | None = None
    """Counts of the left and the right wheel since joining, from the first encoders, forward positive."""
    odometry: tuple[float, float, float] | None = None
    """X, Y and heading from the first odometry sensor, in metres and radians, in the body frame at joining."""
    user: tuple[float, float] | None = None
    """Forward and Turn of the user's latest input, in [-1, 1]; Turn is positive to the left."""


class TraceTick(FileRecord, frozen=True, kw_only=True):
    """A line of a trace after the header: the true state of the world at a tick."""

    tick: int
    """Number of steps since the start of the run."""
    body: dict[str, TraceBody]
    """All bodies, by the names of their agents."""
    event: tuple[Event, ...] = ()
    """Events in the step to this tick."""
    hash: str
    """Hash of the state at this tick: 16 hex digits."""


LINES: Final[tuple[type[FileRecord], ...]] = (InputHeader, InputTick, InputEnd, TraceHeader, TraceTick)
"""The records that are a complete line of a file."""

_H = TypeVar("_H", bound=InputHeader | TraceHeader)
_FILES: Final[dict[type[FileRecord], str]] = {InputHeader: "an input log", TraceHeader: "a trace"}
_VERSIONS: Final[dict[type[FileRecord], tuple[int, ...]]] = {InputHeader: (VERSION, CHAINED), TraceHeader: (VERSION,)}


class _Versions(msgspec.Struct, rename="pascal"):
    log: str | None = None
    trace: str | None = None
    version: int = VERSION


def read_header(cls: type[_H], line: bytes, where: str) -> _H:
    """Return the header of a file.

    Args:
        cls: Class of the header.
        line: The first line of the file.
        where: File and line, for errors.

    Raises:
        WireError: `version` for a version that this release cannot read, else `malformed`.
    """
    file = _FILES[cls]
    try:
        found = msgspec.json.decode(line, type=_Versions)
        form = found.log if cls is InputHeader else found.trace
        if form is not None and form != FORMAT:
            raise WireError("version", f"{where}: expected {file} of format {FORMAT}, got {form[:40]!r}", where)
        if found.version not in _VERSIONS[cls]:
            known = " or ".join(map(str, _VERSIONS[cls]))
            raise WireError("version", f"{where}: expected {file} of version {known}, got {found.version}", where)
        return msgspec.json.decode(line, type=cls)
    except (msgspec.MsgspecError, UnicodeDecodeError) as error:
        raise WireError("malformed", f"{where}: expected the header of {file}, got {error}", where) from None
