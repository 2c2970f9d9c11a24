"""What every part of the service works on: the world, who has joined, what waits, where messages go.

It decides little. `inbound` takes puts, `joining` handles joins and leaves, `control` handles what operators ask,
`outbound` publishes, and `live_run` moves the world.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from intellwheels_schemas.codec import Encoding
from intellwheels_schemas.keys import OutKind
from intellwheels_schemas.messages import (
    Body,
    Clock,
    Event,
    Load,
    Map,
    MapInfo,
    Pace,
    Pose,
    Record,
    Result,
    ResultCode,
    Robot,
    WorldState,
)
from intellwheels_server import world
from intellwheels_server.log.branch import Branch
from intellwheels_server.service.arrival import Ask
from intellwheels_server.service.barrier import Answer, Barrier
from intellwheels_server.service.error_replies import ErrorReplies, Gate
from intellwheels_server.service.event_buffer import EventBuffer
from intellwheels_server.service.input_latch import InputLatch
from intellwheels_server.service.lease import Leases
from intellwheels_server.service.pace import Metronome, Tachometer
from intellwheels_server.service.publish_schedule import Cadence
from intellwheels_server.service.roster import Roster, new_hex
from intellwheels_server.service.truth_filter import placeless
from intellwheels_server.world import Outcome, Setup, State
from intellwheels_server.world.inputs import (
    Change,
    Inputs,
)


class Outlet(Protocol):
    """Where messages go."""

    def agent(self, agent: str, kind: OutKind, message: Record, encoding: Encoding) -> None:
        """Put `out/<agent>/<kind>`."""

    def welcome(self, agent: str, mind: Encoding, body: Encoding) -> None:
        """Be ready to put much to this agent: measures in the one encoding, power in the other."""

    def farewell(self, agent: str) -> None:
        """Be ready no more."""

    def body(self, agent: str, body: Body) -> None:
        """Put `body/<agent>`."""

    def pose(self, agent: str, pose: Pose) -> None:
        """Put `in/<agent>/pose`, as its bridge did when the log that is played was written."""

    def state(self, state: WorldState) -> None:
        """Put `state/<part>`."""

    def event(self, event: Event) -> None:
        """Put `event`."""

    def clock(self, clock: Clock) -> None:
        """Put `clock`."""

    def map(self, info: MapInfo) -> None:
        """Put `map`."""

    def tell(self, line: str) -> None:
        """Write a line that scripts wait for."""

    def note(self, line: str) -> None:
        """Write a line for people."""


class Recorder(Protocol):
    """Where the input log goes."""

    def __call__(self, tick: int, inputs: Inputs, digest: str, *, stepped: bool) -> None:
        """Record a line."""


@dataclass(frozen=True, kw_only=True)
class Options:
    """How the service runs.

    Attributes:
        world: Its name.
        setup: What the world is made of.
        pace: What makes a tick begin.
        speed: Simulated time over wall time, in real time.
        expect: Whose minds must be there before tick 0 is left.
        open_loop: Whether agents of the barrier are allowed where there is none, running free.
        grace: Seconds a lost token is waited for.
        deadline: Seconds a lockstep answer is waited for.
        quit_at_end: Whether the end of the run is the end of the service.
        branch: The run that this one begins as, if any.
        hide_truth: Whether true poses stay in the log: the world is a laboratory (`hiding`).
    """

    world: str
    setup: Setup
    pace: Pace = "realtime"
    speed: float = 1.0
    expect: tuple[str, ...] = ()
    open_loop: bool = False
    grace: float = 3.0
    deadline: float = 1.0
    quit_at_end: bool = False
    branch: Branch | None = None
    hide_truth: bool = False


@dataclass(slots=True)
class Steps:
    """Steps asked for while paused."""

    left: int
    ask: Ask


@dataclass(slots=True)
class Waiting:
    """A join whose token has not been seen yet."""

    ask: Ask
    robot: Robot
    encoding: Encoding
    until: float


@dataclass(slots=True)
class Bridge:
    """A real body's reports."""

    at: float
    stale: bool = False
    halted: bool = False


@dataclass(slots=True)
class Played:
    """A log that is played: the last tick of the run that is shown, and whether the log is at its end."""

    last: int
    over: bool = False


class ServiceState:
    """What the service holds.

    Attributes:
        exit: The process's exit code once the service is over, else None.
        state: The world.
        open: Whether the barrier of this tick is open.
        held: Whether the run waits for those it expects.
        played: The log that is played; None in a live run.
        witness: Is told each event as it is, hidden or not, if there is one.
    """

    def __init__(
        self,
        options: Options,
        outlet: Outlet,
        floor_of: Callable[[Load], Map],
        wall: Callable[[], float],
        record: Recorder | None = None,
        run: str | None = None,
    ) -> None:
        """Begin a run.

        Args:
            options: How.
            outlet: Where messages go.
            floor_of: Gives the floor a `load` asks for, or raises `WireError`.
            wall: Gives Unix time, for stamps.
            record: Where the input log goes, if anywhere.
            run: The run's name; random if not given.
        """
        self.options = options
        self.exit: int | None = None
        self.state = world.begin(options.setup, run or new_hex())
        self.out = outlet
        self.floor_of = floor_of
        self.wall = wall
        self.record = record
        self.lockstep = options.pace == "lockstep"
        self.strict = options.setup.strict
        self.roster = Roster()
        self.barrier = Barrier(strict=self.strict, deadline=options.deadline)
        self.metronome = Metronome(options.setup.period, options.speed)
        self.tachometer = Tachometer(options.setup.period)
        self.cadence = Cadence()
        self.complaints = ErrorReplies()
        self.gate = Gate()
        self.leases = Leases()
        self.ring = EventBuffer()
        self.latch = InputLatch()
        self.pending: list[Callable[[float], None]] = []
        self.changes: list[Change] = []
        self.waiting: list[Waiting] = []
        self.bridges: dict[str, Bridge] = {}
        self.members: tuple[Answer, ...] = ()
        self.encodings: dict[str, Encoding] = {}
        self.answers: frozenset[Answer] = frozenset()
        self.paused = False
        self.held = True
        self.open = False
        self.steps: Steps | None = None
        self.played: Played | None = None
        self.hashed: tuple[State, str] | None = None
        self.idle_power_at = 0.0
        self.witness: Callable[[Event], None] | None = None

    def digest(self) -> str:
        """Return the hash of the state."""
        if self.hashed is None or self.hashed[0] is not self.state:
            self.hashed = (self.state, world.digest(self.state))
        return self.hashed[1]

    def result(self, code: ResultCode, text: str | None = None) -> Result:
        """Return a reply to a verb or a leave, as things stand now."""
        words = text[:1000] if text else None
        return Result(code=code, run=self.state.run, tick=self.state.tick, hash=self.digest(), text=words)

    def later(self, request: Callable[[float], None]) -> None:
        """Have a change made at the next tick at which changes may act."""
        self.pending.append(request)

    def may_change(self) -> bool:
        """Return whether changes may act at this tick: not while its barrier is open and the run goes on."""
        return not self.lockstep or not self.open or self.stands()

    def change(self, now: float) -> None:
        """Make the changes that wait."""
        while self.pending:
            pending, self.pending = self.pending, []
            for request in pending:
                request(now)

    def change_if(self, now: float) -> None:
        """Make the changes that wait, if they may act now."""
        if self.may_change():
            self.change(now)

    def apply(self, change: Change, _now: float) -> Outcome:
        """Make a change of the world, remember it for the log and tell what happened; return what became of it."""
        state, outputs = world.apply(self.state, (change,))
        self.state = state
        self.changes.append(change)
        self.cadence.note()
        for event in outputs.events:
            self.put_event(event)
        return outputs.outcomes[0]

    def close_steps(self, code: ResultCode, text: str | None) -> None:
        """Answer whoever asked for steps."""
        if self.steps is not None:
            steps, self.steps = self.steps, None
            steps.ask.reply(self.result(code, text))

    def stands(self) -> bool:
        """Return whether no step may be made now, whatever arrives."""
        return self.held or self.state.ended or (self.paused and self.steps is None)

    def missing(self) -> list[str]:
        """Return whom the run waits for before it begins."""
        return [name for name in self.options.expect if self.roster.mind(name) is None]

    def put_event(self, event: Event) -> None:
        """Keep an event and put it."""
        if self.witness is not None:
            self.witness(event)
        if self.options.hide_truth:
            event = placeless(event)
        self.ring.add(event)
        self.out.event(event)

    def miss(self, agent: str) -> None:
        """End a strict run in which an answer is missing."""
        self.out.tell(f"miss agent={agent} tick={self.state.tick}")
        self.exit = 1
