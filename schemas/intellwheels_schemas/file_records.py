"""The lines of `input.jsonl` and `trace.jsonl`, which the simulator writes and experiments read.

Both files are JSON Lines: a header, then one line per tick. `input.jsonl` is the input log: a run is a function of its
header and its ticks, so running it again gives the same hashes. `trace.jsonl` holds what was true at each tick of such
a run. Numbers are written in full. The headers carry a version; a file of another version is refused.

Units and frames are those of `messages`. The string below a field says what the field is for.
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
)

FORMAT: Final = "iw.v1"
"""Version of the contract that the messages within a file follow."""
VERSION: Final = 1
"""Version of the lines themselves; to be raised when a reader of this one could no longer understand them."""

RunId = Annotated[str, Meta(description="Id of the run.")]
AgentName = Annotated[str, Meta(description="Name of the agent that this concerns.")]
SlotName = Annotated[str, Meta(description="Name of the saved state.")]
Version = Annotated[int, Meta(description="Version of the lines of this file; a header without one means version 1.")]


class FileRecord(msgspec.Struct, rename="pascal", frozen=True, omit_defaults=True):
    """Base of every line and every part of one. Readers ignore fields that they do not know."""


# ---------------------------------------------------------------- what acts on a tick


class Join(FileRecord, frozen=True, kw_only=True, tag="Join", tag_field="Do"):
    """An agent joins with a body, or with role `mind` as the mind of a body that is there.

    The service has checked name, token and session; the world checks the robot and finds the place.
    """

    agent: AgentName
    robot: Robot
    """Robot that the agent asked for."""


class Depart(FileRecord, frozen=True, kw_only=True, tag="Depart", tag_field="Do"):
    """An agent gives up a role: it left, or its token was lost for longer than the grace time."""

    agent: AgentName
    role: Literal["both", "body", "mind"] = "both"
    """Role that ends."""
    lost: bool = False
    """Whether the token was lost; false means that it left."""


class SpawnBody(FileRecord, frozen=True, kw_only=True, tag="Spawn", tag_field="Do"):
    """An operator adds a body without a mind."""

    robot: Robot
    """Body to add; its Name is the new agent's."""
    position: Position | None = None
    """Pose to put it at; absent means the robot's Place or Position, or the first free place of its Kind."""


class DeleteBody(FileRecord, frozen=True, kw_only=True, tag="Delete", tag_field="Do"):
    """An operator removes a body."""

    agent: AgentName


class TeleportBody(FileRecord, frozen=True, kw_only=True, tag="Teleport", tag_field="Do"):
    """An operator moves a body to another pose."""

    agent: AgentName
    position: Position
    """Pose to move it to."""
    force: bool = False
    """Whether it is put there even where it overlaps something."""


class TakeBody(FileRecord, frozen=True, kw_only=True, tag="Take", tag_field="Do"):
    """An operator takes control of a body or gives it back."""

    agent: AgentName
    on: bool = True
    """Whether the user's input moves the body from now on; false means its mind does."""


class Speech(FileRecord, frozen=True, kw_only=True, tag="Speech", tag_field="Do"):
    """A message from an operator, heard at the next tick."""

    text: str
    """What is said."""
    to: str | None = None
    """Agent that hears it; absent means all agents."""


class Note(FileRecord, frozen=True, kw_only=True, tag="Note", tag_field="Do"):
    """An event that changes no body: paused, resumed, speed, lost, returned."""

    code: EventCode
    """What happened."""
    agent: str | None = None
    """Agent that it happened to, if any."""
    speed: float | None = None
    """Of speed: the new ratio of simulated time to wall time."""
    text: str | None = None
    """Details for people, if there are any."""


class Restart(FileRecord, frozen=True, kw_only=True, tag="Restart", tag_field="Do"):
    """A reset, or with a map a load: a new run from tick 0 with the same bodies at their starts."""

    run: Annotated[str, Meta(description="Id of the new run.")]
    seed: str
    """Seed of the new run's noise."""
    map: Map | None = None
    """Map of the new run; absent keeps the current one."""
    end: End | None = None
    """End condition of the new run; absent keeps the current one."""


class SaveState(FileRecord, frozen=True, kw_only=True, tag="Save", tag_field="Do"):
    """Save the state as the changes before this one left it."""

    slot: SlotName


class RestoreState(FileRecord, frozen=True, kw_only=True, tag="Restore", tag_field="Do"):
    """Return to a saved state, at its tick, as a new run."""

    slot: SlotName
    run: Annotated[str, Meta(description="Id of the new run.")]


class GoOn(FileRecord, frozen=True, kw_only=True, tag="GoOn", tag_field="Do"):
    """Continue after the end: the end condition no longer counts."""


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
    """A message that an agent sent as a `Say`, apart from its `Actions`."""

    agent: AgentName
    text: str
    """What was said."""
    seq: int | None = None
    """Seq that the sender gave it, if any."""


class Verdict(FileRecord, frozen=True, kw_only=True):
    """What the service, which has a clock, found out about an agent.

    `late`: no answer by the deadline. `rested`: its body rests until `back`. `silent`: no user input for 0.3 s.
    `stale`: no pose of a real body for too long, until `fresh`. `halt`: the motors of a real body get power 0, because
    of a pause or a speed other than 1, until `unhalt`.
    """

    agent: AgentName
    code: VerdictCode
    """What was found."""


class Inputs(FileRecord, frozen=True, kw_only=True):
    """Everything that acts on one step.

    Changes act at a tick before its measures are taken, in the order given; actions, poses, user input and verdicts act
    on the step from that tick to the next.
    """

    changes: tuple[Change, ...] = ()
    """Joins, leaves and what operators did, in order."""
    actions: dict[str, Actions] = {}
    """Commands of the minds, by the name of their agent."""
    says: tuple[Said, ...] = ()
    """Messages sent apart from commands, in order."""
    poses: dict[str, Pose] = {}
    """Poses of real bodies from their bridges, by agent."""
    user_input: dict[str, UserInput] = {}
    """Inputs of people, by the agent that they steer."""
    verdicts: tuple[Verdict, ...] = ()
    """Findings of the service about deadlines, in order."""


# ---------------------------------------------------------------- input.jsonl


class WorldRules(FileRecord, frozen=True, kw_only=True, omit_defaults=False):
    """Settings of the world besides map, seed and period. The bounds are those of the options of `iw-server`."""

    say_limit: Annotated[int, Meta(ge=1, le=1000)]
    """Longest message that an agent may say, in Unicode code points."""
    say_range: Annotated[float, Meta(gt=0.0)]
    """Distance from the speaker up to which a message is heard, in metres."""
    command_timeout: Annotated[float, Meta(gt=0.0)]
    """Simulated seconds without a motor command after which both powers become 0."""
    truth: bool
    """Whether agents may have truth sensors."""
    strict: bool
    """Whether a missed deadline in lockstep ends the run."""
    end: End | None = None
    """End condition of the first run; null means none."""
    say_walls: bool = defaults.SAY_WALLS
    """Whether walls and closed doors block messages."""
    say_loss: Annotated[float, Meta(ge=0.0, le=1.0)] = defaults.SAY_LOSS
    """Share of messages between agents that a listener misses."""
    say_delay: Annotated[float, Meta(ge=0.0, le=3600.0)] = defaults.SAY_DELAY
    """Simulated seconds by which a message arrives after the next tick."""


class InputHeader(FileRecord, frozen=True, kw_only=True, omit_defaults=False):
    """The first line of an input log: what the world was made of."""

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


class InputTick(FileRecord, frozen=True, kw_only=True):
    """A line of an input log after the header: what acted on a step, or what changed the world without one."""

    tick: int
    """Tick at which the inputs acted; the step leads to the next one."""
    inputs: Inputs
    """What acted."""
    hash: str
    """Hash of the state after the step, or without a step of the state at the tick: 16 hex digits."""
    stepped: bool = True
    """Whether a step was made; false for a reset, and for what changed after the last step."""


# ---------------------------------------------------------------- trace.jsonl


class TraceHeader(FileRecord, frozen=True, kw_only=True, omit_defaults=False):
    """The first line of a run's trace: which run it is."""

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
    """Whether the body could not move as commanded in the step to this tick because something was in the way."""
    touching: bool = False
    """Whether the body touches a wall or another body."""
    contacts: int = 0
    """Number of contact episodes since the run began."""
    mode: str | None = None
    """What the mind says it is doing, from its Actions."""
    wheels: tuple[int, int] | None = None
    """Counts of the left and the right wheel since joining, by the first encoders, forward positive."""
    odometry: tuple[float, float, float] | None = None
    """X, Y and heading by the first odometry sensor, in metres and radians, in the body frame at joining."""
    user: tuple[float, float] | None = None
    """Forward and Turn of the user's latest input, in [-1, 1]; Turn is positive to the left."""


class TraceTick(FileRecord, frozen=True, kw_only=True):
    """A line of a trace after the header: the world at a tick."""

    tick: int
    """Number of steps made since the run began."""
    body: dict[str, TraceBody]
    """Every body that was there, by the name of its agent."""
    event: tuple[Event, ...] = ()
    """What happened in the step to this tick."""
    hash: str
    """Hash of the state at this tick: 16 hex digits."""


LINES: Final[tuple[type[FileRecord], ...]] = (InputHeader, InputTick, TraceHeader, TraceTick)
"""The records that are a line of a file."""

_H = TypeVar("_H", bound=InputHeader | TraceHeader)
_FILES: Final[dict[type[FileRecord], str]] = {InputHeader: "an input log", TraceHeader: "a trace"}


class _Versions(msgspec.Struct, rename="pascal"):
    log: str | None = None
    trace: str | None = None
    version: int = VERSION


def read_header(cls: type[_H], line: bytes, where: str) -> _H:
    """Return the header of a file.

    Args:
        cls: Which header it should be.
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
        if found.version != VERSION:
            text = f"{where}: expected {file} of version {VERSION}, got version {found.version}"
            raise WireError("version", f"{text}; this release reads no other", where)
        return msgspec.json.decode(line, type=cls)
    except (msgspec.MsgspecError, UnicodeDecodeError) as error:
        raise WireError("malformed", f"{where}: expected the header of {file}, got {error}", where) from None
