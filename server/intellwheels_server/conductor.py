"""The service without its network: arrivals go in, messages come out, and the world moves when it may.

Nothing here waits, reads a clock or knows zenoh: time is passed in, and `due` says when to come back. One thread
calls it. The order at a tick: what arrived is latched; when the pace allows, one step is made; then the
changes asked for (joins, leaves, verbs) act, before the measures of the new tick go out.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, Final, Protocol

import msgspec

from intellwheels_schemas.channels import VERB_CLASSES
from intellwheels_schemas.codec import Encoding, decode, encoding_of
from intellwheels_schemas.errors import RequestRefusedError, WireError
from intellwheels_schemas.keys import OutKind
from intellwheels_schemas.messages import (
    Actions,
    Body,
    Clock,
    ClockState,
    Delete,
    Error,
    ErrorCode,
    Event,
    Joined,
    Leave,
    Load,
    Map,
    MapInfo,
    OperatorSay,
    Pace,
    Parameters,
    Pose,
    Position,
    PowerInForce,
    Record,
    Refused,
    RefusedCode,
    Reset,
    Result,
    ResultCode,
    Robot,
    Role,
    Say,
    Spawn,
    Speed,
    Step,
    Take,
    Teleport,
    UserInput,
    WorldState,
)
from intellwheels_schemas.rules import has_motors
from intellwheels_server import world
from intellwheels_server.admission import OPERATOR, Roster, Seat, check_session, new_hex, same_body
from intellwheels_server.arrival import Arrival, Ask, Put, Token
from intellwheels_server.barrier import Answer, AnswerKind, Barrier
from intellwheels_server.cadence import Cadence
from intellwheels_server.complaint import Complaints, Fault, Gate
from intellwheels_server.inputs import (
    Change,
    DeleteBody,
    Depart,
    GoOn,
    Inputs,
    Join,
    Note,
    Restart,
    SpawnBody,
    Speech,
    TakeBody,
    TeleportBody,
    Verdict,
)
from intellwheels_server.kernels.rows import HEADING, X, Y
from intellwheels_server.lease import Leases
from intellwheels_server.pace import Metronome, Tachometer
from intellwheels_server.parts import cut
from intellwheels_server.ring import Ring
from intellwheels_server.tray import Tray, check_time
from intellwheels_server.world import Outcome, Setup, State

STALE_AFTER: Final = 0.3
"""Seconds without a pose, or three cycles if they are longer, after which a real body is stale."""
TOKEN_WAIT: Final = 0.3
"""Seconds a join waits for its token, which travels apart from it."""


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


@dataclass(slots=True)
class _Steps:
    """Steps asked for while paused."""

    left: int
    ask: Ask


@dataclass(slots=True)
class _Waiting:
    """A join whose token has not been seen yet."""

    ask: Ask
    robot: Robot
    encoding: Encoding
    until: float


@dataclass(slots=True)
class _Bridge:
    """A real body's reports."""

    at: float
    stale: bool = False
    halted: bool = False


class Conductor:
    """The service's decisions.

    Attributes:
        exit: The process's exit code once the service is over, else None.
        state: The world.
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
        self._out = outlet
        self._floor_of = floor_of
        self._wall = wall
        self._record = record
        self._lockstep = options.pace == "lockstep"
        self._strict = options.setup.strict
        self.roster = Roster()
        self._barrier = Barrier(strict=self._strict, deadline=options.deadline)
        self._metronome = Metronome(options.setup.period, options.speed)
        self._tachometer = Tachometer(options.setup.period)
        self._cadence = Cadence()
        self._complaints = Complaints()
        self._gate = Gate()
        self._leases = Leases()
        self._ring = Ring()
        self._tray = Tray()
        self._pending: list[Callable[[float], None]] = []
        self._changes: list[Change] = []
        self._waiting: list[_Waiting] = []
        self._bridges: dict[str, _Bridge] = {}
        self._members: tuple[Answer, ...] = ()
        self._encodings: dict[str, Encoding] = {}
        self._answers: frozenset[Answer] = frozenset()
        self._paused = False
        self._held = True
        self._open = False
        self._steps: _Steps | None = None
        self._hashed: tuple[State, str] | None = None
        self._idle_power_at = 0.0

    # ------------------------------------------------------------ in

    def begin(self) -> None:
        """Publish what there is to know before anything happens."""
        self._publish_map()

    def take(self, arrival: Arrival, now: float) -> None:
        """Take in what arrived. The world does not move."""
        if isinstance(arrival, Put):
            self._take_put(arrival, now)
        elif isinstance(arrival, Token):
            self._take_token(arrival, now)
        else:
            self._take_ask(arrival, now)

    def work(self, now: float) -> None:
        """Do all that is due; at most one step is made."""
        if self.exit is not None:
            return
        self._expire(now)
        if self._pending and self._may_change():
            self._change(now)
        if self._held and self._may_begin():
            self._begin_run(now)
        self._move(now)
        if self._cadence.ready(now):
            self._publish(now)
        self._rest_real(now)

    def due(self, now: float) -> float:
        """Return when `work` must be called next if nothing arrives; `now` or less: at once."""
        times = [self._cadence.due(), self._leases.due(), self.roster.due(self.options.grace)]
        times += [waiting.until for waiting in self._waiting]
        if self._bridges and self._stands():
            times.append(self._idle_power_at)
        if (self._pending and self._may_change()) or (self._held and self._may_begin()):
            return now
        if not self._stands():
            if not self._lockstep:
                times.append(self._metronome.due() if self.options.pace == "realtime" else now)
            elif self._open:
                if self._barrier.complete(now):
                    return now
                times.append(self._barrier.due())
            elif self._members or self._steps:
                return now
        return min(times)

    def finish(self, now: float) -> None:
        """Publish and record what is left before the service ends."""
        self._close_steps("failed", "the simulator ends")
        for waiting in self._waiting:
            waiting.ask.close()
        self._waiting.clear()
        self._publish(now)
        for agent in self._bridges:
            self._put_power(
                agent,
                PowerInForce(run=self.state.run, tick=self.state.tick, left_motor=0.0, right_motor=0.0, state="paused"),
            )
        if self._changes and self._record is not None:
            self._record(self.state.tick, Inputs(changes=tuple(self._changes)), self.digest(), stepped=False)
            self._changes.clear()

    def digest(self) -> str:
        """Return the hash of the state."""
        if self._hashed is None or self._hashed[0] is not self.state:
            self._hashed = (self.state, world.digest(self.state))
        return self._hashed[1]

    # ------------------------------------------------------------ puts

    def _take_put(self, put: Put, now: float) -> None:
        agent = put.agent
        kind = put.kind
        if kind in ("actions", "pose") and self._open and self._barrier.repeats(agent, kind, put.data):
            return
        # A user who floods must not use up what the agent itself may send; no agent's name has a slash.
        sender = agent if kind != "user" else f"user/{agent}"
        if not self._gate.admit(sender, self.state.tick, now):
            self._complain(agent, Fault("too-many", f"{kind}: expected fewer messages a second"), now)
            return
        if put.size > len(put.data):
            self._complain(agent, Fault("too-long", f"{kind}: expected fewer bytes, got {put.size}"), now)
            return
        try:
            encoding = encoding_of(put.encoding, put.data)
            if kind == "actions":
                fault = self._take_actions(agent, decode(Actions, put.data, encoding), put.data, now)
            elif kind == "pose":
                fault = self._take_pose(agent, decode(Pose, put.data, encoding), put.data, now)
            elif kind == "say":
                fault = self._take_say(agent, decode(Say, put.data, encoding))
            else:
                fault = self._take_user(agent, decode(UserInput, put.data, encoding), now)
        except WireError as error:
            fault = Fault(error.code, error.text, error.where or None)
        if fault is not None:
            self._complain(agent, fault, now)

    def _take_actions(self, agent: str, actions: Actions, data: bytes, now: float) -> Fault | None:
        seat = self.roster.mind(agent)
        fault = check_session(seat, self.roster.seats(agent), actions.session, "Actions")
        if fault is None:
            fault = check_time(actions.run, actions.tick, self.state.run, self.state.tick, "Actions")
            if fault is not None and fault.code == "late" and actions.run in (None, self.state.run):
                self._barrier.revive(agent)
        if fault is not None or seat is None:
            return fault._replace(seq=actions.seq) if fault else None
        fault = self._answered(agent, "actions", data, "Actions")
        if fault is not None:
            return None if fault.text == "" else fault._replace(seq=actions.seq)
        if actions.say is not None and len(actions.say) > self.state.setup.say_limit:
            self._complain(agent, self._too_long("Actions.Say", actions.say, actions.seq), now)
            actions = msgspec.structs.replace(actions, say=None)
        self._tray.act(agent, actions)
        if actions.leave:
            self._let_go(seat, None)
        return None

    def _take_pose(self, agent: str, pose: Pose, data: bytes, now: float) -> Fault | None:
        seat = self.roster.body(agent)
        fault = check_session(seat, self.roster.seats(agent), pose.session, "Pose")
        if fault is None and seat is not None and not seat.real:
            fault = Fault("role", "Pose: expected a robot of Type real, got a simulated one", "Pose")
        if fault is None:
            fault = check_time(pose.run, pose.tick, self.state.run, self.state.tick, "Pose")
            if fault is not None and fault.code == "late" and pose.run in (None, self.state.run):
                self._barrier.revive(agent)
                # A bridge that is a cycle behind still says where its chair is.
                if not self._lockstep and pose.tick is not None and self.state.tick - pose.tick <= 1:
                    fault = None
        if fault is not None:
            return fault._replace(seq=pose.seq)
        fault = self._answered(agent, "pose", data, "Pose")
        if fault is not None:
            return None if fault.text == "" else fault._replace(seq=pose.seq)
        self._tray.report(agent, pose)
        bridge = self._bridges.get(agent)
        if bridge is not None:
            bridge.at = now
        return None

    def _answered(self, agent: str, kind: AnswerKind, data: bytes, where: str) -> Fault | None:
        """Take a member's answer and return what is wrong with all but the first; the same bytes give no text."""
        if (agent, kind) not in self._answers:
            return None
        if not self._open:
            # Measures are not out yet, or those of a tick that was answered still stand: nothing is awaited.
            return None
        reception = self._barrier.answer(agent, kind, data)
        if reception == "first":
            return None
        if reception == "same":
            return Fault("answered", "")
        return Fault("answered", f"{where}: tick {self.state.tick} is answered already", where)

    def _take_say(self, agent: str, say: Say) -> Fault | None:
        seats = self.roster.seats(agent)
        fault: Fault | None = None
        if not seats:
            fault = Fault("not-joined", "Say: expected an agent that has joined, got one that has not", "Say")
        elif say.session is not None and all(say.session != seat.session for seat in seats):
            fault = Fault("session", "Say.Session: expected the session of the last join, got another", "Say.Session")
        elif say.run is not None and say.run != self.state.run:
            fault = Fault("late", f"Say.Run: expected {self.state.run}, got {say.run}", "Say.Run")
        elif say.tick is not None and say.tick > self.state.tick:
            fault = Fault("early", f"Say.Tick: expected {self.state.tick}, got {say.tick}", "Say.Tick")
        elif len(say.text) > self.state.setup.say_limit:
            fault = self._too_long("Say", say.text, say.seq)
        if fault is not None:
            return fault._replace(seq=say.seq)
        return self._tray.say(agent, say)

    def _too_long(self, where: str, text: str, seq: int | None) -> Fault:
        limit = self.state.setup.say_limit
        return Fault("too-long", f"{where}: expected at most {limit} characters, got {len(text)}", where, seq)

    def _take_user(self, agent: str, user: UserInput, now: float) -> Fault | None:
        figure = self.state.fleet.figures.get(agent)
        if figure is None:
            return None  # nobody to steer, and nobody to tell
        judged = self._leases.judge(agent, user, now)
        if isinstance(judged, Fault):
            return judged._replace(seq=user.seq)
        if judged:
            self._tray.use(agent, user)
        return None

    def _complain(self, agent: str, fault: Fault, now: float) -> None:
        known = agent in self.roster
        kept_back = self._complaints.admit(agent, known, now)
        if kept_back is None:
            return
        seat = self.roster.mind(agent) or self.roster.body(agent)
        error = Error(
            run=self.state.run,
            tick=self.state.tick,
            code=fault.code,
            where=fault.where[:200] if fault.where else None,
            seq=fault.seq,
            suppressed=kept_back,
            text=fault.text[:1000],
        )
        self._out.agent(agent, "error", error, seat.encoding if seat else Encoding.JSON)

    # ------------------------------------------------------------ presence

    def _take_token(self, token: Token, now: float) -> None:
        seat = self.roster.token(token.agent, token.role, token.instance, token.present, now)
        if seat is not None:
            code = "returned" if token.present else "lost"
            self._out.note(f"{code} agent={seat.agent} role={seat.role}")
            self._later(partial(self._note_presence, seat, token.present))
        if token.present and self._waiting:
            self._recheck_waiting()

    def _note_presence(self, seat: Seat, present: bool, now: float) -> None:
        if seat in self.roster.seats(seat.agent):
            text = None if seat.role == "both" else seat.role
            self._apply(Note(code="returned" if present else "lost", agent=seat.agent, text=text), now)

    def _recheck_waiting(self) -> None:
        still: list[_Waiting] = []
        for waiting in self._waiting:
            if self._has_token(waiting.ask.name, waiting.robot):
                self._later(partial(self._join, waiting.ask, waiting.robot, waiting.encoding))
            else:
                still.append(waiting)
        self._waiting = still

    def _expire(self, now: float) -> None:
        for waiting in [w for w in self._waiting if w.until <= now]:
            self._waiting.remove(waiting)
            self._later(partial(self._join, waiting.ask, waiting.robot, waiting.encoding))
        for seat in self.roster.lost(now, self.options.grace):
            seat.absent_since = None  # once is enough
            if self._strict and self._lockstep and seat.answers() and not self._stands():
                self._miss(seat.agent)
            self._let_go(seat, None)
        for agent in self._leases.expired(now):
            self._later(partial(self._release, agent))

    def _release(self, agent: str, now: float) -> None:
        if agent in self.state.fleet.figures and self._leases.holder(agent) is None:
            self._apply(TakeBody(agent=agent, on=False), now)

    # ------------------------------------------------------------ asks

    def _take_ask(self, ask: Ask, now: float) -> None:
        match ask.topic:
            case "join":
                self._ask_join(ask, now)
            case "leave":
                self._ask_leave(ask)
            case "ctl":
                self._ask_ctl(ask, now)
            case "map":
                ask.reply(self.state.setup.floor)
            case "clock":
                ask.reply(self._clock(now))
            case "event":
                self._ask_events(ask)
            case "body":
                bodies = {name: self._body(name) for name in self.state.names if ask.matches(name)}
                ask.replies(bodies)
            case "state":
                parts = self._parts()
                ask.replies({str(part.part): part for part in parts if ask.matches(str(part.part))})

    def _ask_events(self, ask: Ask) -> None:
        since = ask.parameters.get("since", "0")
        if not (since.isascii() and since.isdigit() and len(since) <= 16):
            ask.refuse(self._result("failed", f"event?since: expected a number, got {since[:40]!r}"))
            return
        ask.reply(self._ring.since(int(since), self.state.run))

    def _ask_join(self, ask: Ask, now: float) -> None:
        if not ask.name:
            if not ask.wild:
                ask.refuse(
                    Refused(code="name", text="join/<agent>: expected a name: a-z, then a-z 0-9 _ -, at most 32")
                )
            ask.close()
            return
        try:
            encoding = encoding_of(ask.encoding, ask.data)
            robot = decode(Robot, ask.data, encoding)
        except WireError as error:
            ask.refuse(Refused(code=_REFUSED.get(error.code, "value"), text=error.text[:1000]))
            return
        if not self._has_token(ask.name, robot):
            self._waiting.append(_Waiting(ask, robot, encoding, now + TOKEN_WAIT))
            return
        self._later(partial(self._join, ask, robot, encoding))

    def _has_token(self, agent: str, robot: Robot) -> bool:
        instance = robot.instance or self.roster.only_instance(agent, robot.role)
        return instance is not None and self.roster.has_token(agent, robot.role, instance)

    def _join(self, ask: Ask, robot: Robot, encoding: Encoding, now: float) -> None:
        try:
            joined = self._admit(ask.name, robot, encoding, ask.parameters.get("session"), now)
        except RequestRefusedError as refusal:
            self._out.note(f"refused agent={ask.name} role={robot.role} code={refusal.code}")
            ask.refuse(Refused(code=refusal.code, text=refusal.text[:1000]))
            return
        ask.reply(joined)

    def _admit(self, agent: str, robot: Robot, encoding: Encoding, shown: str | None, now: float) -> Joined:
        if robot.format is not None:
            raise RequestRefusedError("field", "Robot.Format: expected none in a join, as it is of files")
        if robot.crew is not None:
            raise RequestRefusedError("value", "Robot.Crew: crews are not supported; join each body by itself")
        if robot.instance is None:
            robot = msgspec.structs.replace(robot, instance=self.roster.only_instance(agent, robot.role))
        held = self.roster.holder(agent, robot, shown)
        figure = self.state.fleet.figures.get(agent)
        kept = held is not None and figure is not None and same_body(held.robot, robot)
        if robot.role == "mind":
            if figure is None:
                raise RequestRefusedError("no-body", f"agent '{agent}' has no body here yet; join again when it has")
            body = figure.robot
        else:
            body = robot
        barrier = robot.barrier if robot.barrier is not None else has_motors(body)
        real = body.type == "real"
        if robot.role != "mind":
            self._check_real(robot)
        if barrier and self.options.pace == "free" and not self.options.open_loop:
            raise RequestRefusedError(
                "value",
                "Robot.Barrier: expected false, as this run is free and waits for nobody (--open-loop allows it)",
            )
        seat = Seat(
            agent=agent,
            role=robot.role,
            instance=robot.instance or "",
            session=held.session if held is not None and held.instance == robot.instance else new_hex(),
            encoding=encoding,
            robot=robot,
            real=real,
            simulated_hardware=body.hardware == "simulated",
            barrier=barrier,
        )
        position = self._embody(seat, held, kept, now)
        self.roster.sit(seat)
        self._barrier.forget(agent)
        if real and seat.embodies:
            self._bridges[agent] = _Bridge(at=now)
        self._reseat(agent)
        self._out.note(f"joined agent={agent} role={seat.role} tick={self.state.tick}")
        if self._open and self._lockstep:
            self._barrier.join(seat.answers())
        if not self._held and (self._open or not self._lockstep):
            self._put_measures(agent)
        return self._joined(seat, position)

    def _check_real(self, robot: Robot) -> None:
        if robot.type != "real" or robot.hardware == "simulated":
            return
        if self._lockstep or self.options.pace == "free" or self._metronome.speed != 1.0:
            raise RequestRefusedError(
                "real-in-lockstep",
                "Robot.Type: expected simulated, as real hardware takes part in real time at speed 1 only, got real",
            )

    def _embody(self, seat: Seat, held: Seat | None, kept: bool, now: float) -> Position:
        """Give a seat its body: the one that is here, if it may be kept, else a new one. Return where it is."""
        agent = seat.agent
        if held is not None and kept:
            if held.absent_since is not None or held.instance != seat.instance:
                self._apply(Note(code="returned", agent=agent, text=None if seat.role == "both" else seat.role), now)
            return self._position(agent)
        others = [seat for seat in self.roster.seats(agent) if seat.role == "mind" and seat is not held]
        if held is not None and agent in self.state.fleet.figures:
            self._apply(Depart(agent=agent, role=held.role, lost=held.absent_since is not None), now)
            self._tray.forget(agent)
        outcome = self._apply(Join(agent=agent, robot=_as_joined(seat.robot, agent)), now)
        if outcome.code != "ok":
            if held is not None:
                self._dismiss(held)
            raise RequestRefusedError(outcome.refused or "value", outcome.text)
        for mind in others:  # of a body that was changed
            self._apply(Join(agent=agent, robot=_as_joined(mind.robot, agent)), now)
        return outcome.position or self._position(agent)

    def _position(self, agent: str) -> Position:
        x, y, heading = self.state.numbers[[X, Y, HEADING], self.state.fleet.index[agent]].tolist()
        return Position(x=x, y=y, heading=heading)

    def _joined(self, seat: Seat, position: Position) -> Joined:
        setup = self.state.setup
        return Joined(
            run=self.state.run,
            tick=self.state.tick,
            session=seat.session,
            parameters=Parameters(
                world=self.options.world,
                period=setup.period,
                pace=self.options.pace,
                say_limit=setup.say_limit,
                say_range=setup.say_range,
                command_timeout=setup.command_timeout,
                grace=self.options.grace,
            ),
            position=position,
            robot=self.state.fleet.figures[seat.agent].robot,
        )

    # ------------------------------------------------------------ leaving

    def _ask_leave(self, ask: Ask) -> None:
        if not ask.name:
            ask.close()
            return
        try:
            leave = decode(Leave, ask.data, encoding_of(ask.encoding, ask.data)) if ask.data else Leave()
        except WireError as error:
            ask.refuse(self._result("failed", error.text))
            return
        seats = self.roster.seats(ask.name)
        leaving = [seat for seat in seats if leave.session in (None, seat.session)]
        if not leaving:
            why = "no such agent here" if not seats else "expected the session of the last join, got another"
            ask.reply(self._result("not-found", f"agent '{ask.name}': {why}"))
            return
        # The body last: without it its mind is gone too.
        for seat in sorted(leaving, key=lambda seat: seat.embodies):
            self._let_go(seat, ask if seat is leaving[-1] else None)

    def _let_go(self, seat: Seat, ask: Ask | None) -> None:
        """Let a seat's agent leave at the next barrier; it is awaited no more."""
        for agent, kind in seat.answers():
            self._barrier.excuse(agent, kind)
        self._later(partial(self._leave, seat, ask))

    def _leave(self, seat: Seat, ask: Ask | None, now: float) -> None:
        if seat in self.roster.seats(seat.agent):
            self._apply(Depart(agent=seat.agent, role=seat.role), now)
            self._dismiss(seat)
        if ask is not None:
            ask.reply(self._result("ok"))

    def _dismiss(self, seat: Seat) -> None:
        """Take a seat away, and with a body all that hangs on it."""
        agent = seat.agent
        self._out.note(f"left agent={agent} role={seat.role} tick={self.state.tick}")
        gone = self.roster.seats(agent) if agent not in self.state.fleet.figures else (seat,)
        for each in gone:
            for name, kind in each.answers():
                self._barrier.excuse(name, kind)
            self.roster.rise(each)
        if agent not in self.state.fleet.figures:
            self._forget_body(agent)
        self._reseat(agent)

    def _forget_body(self, agent: str) -> None:
        self._barrier.forget(agent)
        self._tray.forget(agent)
        self._leases.forget(agent)
        self._bridges.pop(agent, None)

    def _reseat(self, agent: str) -> None:
        """Draw the conclusions from a change of seats."""
        members = [answer for seat in self.roster.every_seat() for answer in seat.answers()]
        self._members = tuple(members) if self._lockstep else ()
        self._answers = frozenset(self._members)
        mind, body = self.roster.mind(agent), self.roster.body(agent)
        listener = mind or body
        if listener is None:
            self._encodings.pop(agent, None)
            self._complaints.forget(agent)
            self._out.farewell(agent)
        else:
            self._encodings[agent] = listener.encoding
            self._out.welcome(agent, listener.encoding, (body or listener).encoding)
        if agent in self.state.fleet.figures:
            self._out.body(agent, self._body(agent))

    # ------------------------------------------------------------ verbs

    def _ask_ctl(self, ask: Ask, now: float) -> None:
        cls = VERB_CLASSES.get(ask.name)
        if cls is None:
            ask.refuse(self._result("unsupported", "no such verb"))
            return
        try:
            # A verb without fields needs no bytes.
            data = ask.data or b"{}"
            message = decode(cls, data, encoding_of(ask.encoding, data) if ask.data else Encoding.JSON)
        except WireError as error:
            ask.refuse(self._result("failed", error.text))
            return
        self._out.note(f"asked verb={ask.name} tick={self.state.tick}")
        match ask.name:
            case "save" | "restore" | "seek":
                ask.reply(self._result("unsupported", f"{ask.name} is not supported"))
            case "pause":
                self._pause(ask, now)
            case "resume":
                self._resume(ask, now)
            case "step":
                self._step_on(ask, message, now)
            case "quit":
                ask.reply(self._result("ok"))
                self._out.note(f"quit tick={self.state.tick}")
                self.exit = 0
            case _:
                self._later(partial(self._VERBS[ask.name], self, ask, message))

    def _pause(self, ask: Ask, now: float) -> None:
        if not self._paused:
            self._paused = True
            self._tachometer.stop()
            self._change(now)
            self._apply(Note(code="paused"), now)
            self._publish(now)
            self._idle_power_at = now
        ask.reply(self._result("ok"))

    def _resume(self, ask: Ask, now: float) -> None:
        self._close_steps("incorrect-state", "resumed before all steps were made")
        self._change_if(now)
        if self.state.ended:
            self._apply(GoOn(), now)
        if self._paused:
            self._apply(Note(code="resumed"), now)
            self._paused = False
        self._metronome.start(now)
        self._barrier.rearm(now)
        self._tachometer.stop()
        self._cadence.note()
        ask.reply(self._result("ok"))

    def _change_if(self, now: float) -> None:
        if self._may_change():
            self._change(now)

    def _step_on(self, ask: Ask, message: Any, now: float) -> None:
        step: Step = message
        if not self._paused:
            ask.reply(self._result("incorrect-state", "expected a paused run"))
        elif self.state.ended:
            ask.reply(self._result("incorrect-state", "the run has ended; resume to go on"))
        elif self._steps is not None:
            ask.reply(self._result("incorrect-state", "steps are being made"))
        elif self._held:
            ask.reply(self._result("incorrect-state", f"waiting for {', '.join(self._missing())}"))
        else:
            self._steps = _Steps(step.count, ask)
            self._metronome.start(now)
            self._barrier.rearm(now)

    def _close_steps(self, code: ResultCode, text: str | None) -> None:
        if self._steps is not None:
            steps, self._steps = self._steps, None
            steps.ask.reply(self._result(code, text))

    def _do_reset(self, ask: Ask, message: Any, now: float) -> None:
        reset: Reset = message
        seed = reset.seed if reset.seed is not None else self.state.setup.seed
        self._restart(ask, Restart(run=new_hex(), seed=seed, end=reset.end), now)

    def _do_load(self, ask: Ask, message: Any, now: float) -> None:
        load: Load = message
        seed = load.seed if load.seed is not None else self.state.setup.seed
        try:
            floor = self._floor_of(load)
        except WireError as error:
            ask.reply(self._result("not-found" if load.map is None else "failed", error.text))
            return
        self._restart(ask, Restart(run=new_hex(), seed=seed, map=floor, end=load.end), now)

    def _restart(self, ask: Ask, restart: Restart, now: float) -> None:
        before, tick = self.state, self.state.tick
        try:
            outcome = self._apply(restart, now)
        except ValueError as error:  # a floor that only the world finds wrong
            if restart.map is None:
                raise
            ask.reply(self._result("failed", f"Load.Map: {error}"))
            return
        if outcome.code != "ok":
            ask.reply(self._result(outcome.code, outcome.text))
            return
        if self._record is not None:
            self._record(tick, Inputs(changes=tuple(self._changes)), self.digest(), stepped=False)
        self._changes.clear()
        self._close_steps("failed", "the run was begun anew")
        self._tray.clear()
        self._barrier.begin_anew()
        for agent in before.names:
            self._leases.free(agent)
        for bridge in self._bridges.values():
            bridge.at, bridge.stale = now, False
        self._held, self._open = True, False
        self._metronome.late = 0
        self._tachometer.stop()
        self._publish_map()
        for name in self.state.names:
            self._out.body(name, self._body(name))
        self._publish(now)
        self._out.note(f"began run={self.state.run} before={before.run} seed={self.state.setup.seed!r}")
        ask.reply(self._result("ok"))

    def _do_speed(self, ask: Ask, message: Any, now: float) -> None:
        speed: Speed = message
        if self.options.pace != "realtime":
            ask.reply(self._result("incorrect-state", f"the pace is {self.options.pace}: only real time has a speed"))
            return
        self._metronome.change_speed(speed.factor, now)
        self._tachometer.stop()
        self._apply(Note(code="speed", speed=min(speed.factor, 100.0)), now)
        ask.reply(self._result("ok"))

    def _do_spawn(self, ask: Ask, message: Any, now: float) -> None:
        spawn: Spawn = message
        if spawn.robot.name == OPERATOR:
            ask.reply(self._result("failed", f"Spawn.Robot.Name: the name '{OPERATOR}' is reserved for people"))
            return
        outcome = self._apply(SpawnBody(robot=spawn.robot, position=spawn.position), now)
        if outcome.code == "ok" and spawn.robot.name is not None:
            self._out.body(spawn.robot.name, self._body(spawn.robot.name))
        self._reply_outcome(ask, outcome)

    def _do_delete(self, ask: Ask, message: Any, now: float) -> None:
        delete: Delete = message
        outcome = self._apply(DeleteBody(agent=delete.agent), now)
        if outcome.code == "ok":
            seats = self.roster.seats(delete.agent)
            self._forget_body(delete.agent)
            if seats:
                self._dismiss(seats[0])
        self._reply_outcome(ask, outcome)

    def _do_teleport(self, ask: Ask, message: Any, now: float) -> None:
        teleport: Teleport = message
        force = bool(getattr(teleport, "force", False))
        change = TeleportBody(agent=teleport.agent, position=teleport.position, force=force)
        self._reply_outcome(ask, self._apply(change, now))

    def _do_take(self, ask: Ask, message: Any, now: float) -> None:
        take: Take = message
        agent, holder = take.agent, self._leases.holder(take.agent)
        if agent not in self.state.fleet.figures:
            ask.reply(self._result("not-found", f"no agent '{agent}' here"))
        elif holder is not None and take.lease != holder:
            ask.reply(self._result("incorrect-state", f"agent '{agent}' is taken by somebody else"))
        elif holder is None and take.lease is not None and take.seconds > 0.0:
            ask.reply(self._result("incorrect-state", f"agent '{agent}': this lease is over; take it anew"))
        elif take.seconds == 0.0:
            self._leases.free(agent)
            if holder is not None:
                self._apply(TakeBody(agent=agent, on=False), now)
            ask.reply(self._result("ok"))
        else:
            lease = holder or new_hex()
            self._leases.grant(agent, lease, take.seconds, now)
            if holder is None:
                self._apply(TakeBody(agent=agent, on=True), now)
            ask.reply(msgspec.structs.replace(self._result("ok"), lease=lease))

    def _do_say(self, ask: Ask, message: Any, now: float) -> None:
        say: OperatorSay = message
        limit = self.state.setup.say_limit
        if len(say.text) > limit:
            ask.reply(self._result("failed", f"Say: expected at most {limit} characters, got {len(say.text)}"))
            return
        self._reply_outcome(ask, self._apply(Speech(text=say.text, to=say.to), now))

    _VERBS: Final[Mapping[str, Callable[..., None]]] = {
        "reset": _do_reset,
        "load": _do_load,
        "speed": _do_speed,
        "spawn": _do_spawn,
        "delete": _do_delete,
        "teleport": _do_teleport,
        "take": _do_take,
        "say": _do_say,
    }

    def _reply_outcome(self, ask: Ask, outcome: Outcome) -> None:
        ask.reply(self._result(outcome.code, outcome.text or None))

    def _result(self, code: ResultCode, text: str | None = None) -> Result:
        words = text[:1000] if text else None
        return Result(code=code, run=self.state.run, tick=self.state.tick, hash=self.digest(), text=words)

    # ------------------------------------------------------------ changes

    def _later(self, request: Callable[[float], None]) -> None:
        self._pending.append(request)

    def _may_change(self) -> bool:
        """Return whether changes may act at this tick: not while its barrier is open and the run goes on."""
        return not self._lockstep or not self._open or self._stands()

    def _change(self, now: float) -> None:
        while self._pending:
            pending, self._pending = self._pending, []
            for request in pending:
                request(now)

    def _apply(self, change: Change, _now: float) -> Outcome:
        state, outputs = world.apply(self.state, (change,))
        self.state = state
        self._changes.append(change)
        self._cadence.note()
        for event in outputs.events:
            self._put_event(event)
        return outputs.outcomes[0]

    # ------------------------------------------------------------ moving

    def _stands(self) -> bool:
        """Return whether no step may be made now, whatever arrives."""
        return self._held or self.state.ended or (self._paused and self._steps is None)

    def _missing(self) -> list[str]:
        return [name for name in self.options.expect if self.roster.mind(name) is None]

    def _may_begin(self) -> bool:
        return not self._missing()

    def _begin_run(self, now: float) -> None:
        self._held = False
        self._metronome.start(now)
        self._cadence.note()
        self._out.tell(f"running tick={self.state.tick}")
        if not self._lockstep:
            self._put_all_measures()

    def _move(self, now: float) -> None:
        if self._stands():
            return
        if self._lockstep:
            self._move_in_lockstep(now)
        elif self.options.pace == "free":
            self._step(now)
        elif now >= self._metronome.due():
            self._metronome.began(now)
            self._step(now)

    def _move_in_lockstep(self, now: float) -> None:
        barrier = self._barrier
        if not self._open:
            if self._members:
                self._open_barrier(now)
            elif self._steps is not None:
                self._step(now)
            return
        if not barrier.complete(now):
            missed = barrier.missed(now)
            if missed and self._strict:
                self._miss(missed[0][0])
                return
            for agent, kind in missed:
                self._out.note(f"late agent={agent} tick={self.state.tick}")
                if kind == "pose" and agent in self._bridges:
                    self._bridges[agent].at = float("-inf")
            for agent in barrier.to_repeat(now):
                self._put_measures(agent)
        if barrier.complete(now):
            self._step(now)

    def _miss(self, agent: str) -> None:
        self._out.tell(f"miss agent={agent} tick={self.state.tick}")
        self.exit = 1

    def _open_barrier(self, now: float) -> None:
        self._open = True
        self._put_all_measures()
        self._barrier.open(self._members, now)

    def _step(self, now: float) -> None:
        closed = self.state.tick
        inputs = self._tray.collect((), self._verdicts(now))
        state, outputs = world.advance(self.state, inputs)
        self.state = state
        if self._record is not None:
            if self._changes:
                inputs = msgspec.structs.replace(inputs, changes=tuple(self._changes))
            self._record(closed, inputs, self.digest(), stepped=True)
        self._changes.clear()
        self._open = False
        self._tachometer.ticked(now)
        self._cadence.note()
        if self._bridges:
            self._put_powers(closed)
        for event in outputs.events:
            self._put_event(event)
        if self._pending:
            self._change(now)
        if state.ended and self.state.ended:
            self._end(now)
        elif self._steps is not None:
            self._steps.left -= 1
            if self._steps.left <= 0:
                self._close_steps("ok", None)
                self._publish(now)
        if self._held or self.exit is not None:
            return
        if not self._lockstep:
            self._put_all_measures()
        elif self._members:
            self._open_barrier(now)

    def _end(self, now: float) -> None:
        self._close_steps("ok", "the run has ended")
        self._publish(now)
        self._out.tell(f"ended tick={self.state.tick} hash={self.digest()}")
        if self.options.quit_at_end:
            self.exit = 0

    def _verdicts(self, now: float) -> list[Verdict]:
        verdicts = self._barrier.verdicts() if self._lockstep else []
        if not self._strict:
            verdicts += [Verdict(agent=agent, code="silent") for agent in self._leases.silent(now)]
        for agent, bridge in self._bridges.items():
            verdicts += self._judge_bridge(agent, bridge, now)
        here = self.state.fleet.figures
        return [verdict for verdict in verdicts if verdict.agent in here]

    def _judge_bridge(self, agent: str, bridge: _Bridge, now: float) -> list[Verdict]:
        found: list[Verdict] = []
        if not self._strict:
            realtime = self.options.pace == "realtime"
            limit = max(3.0 * self._metronome.interval if realtime else 0.0, STALE_AFTER)
            # In lockstep a pose is awaited: only a missed one is old.
            stale = bridge.at == float("-inf") if self._lockstep else now - bridge.at > limit
            if stale != bridge.stale:
                bridge.stale = stale
                found.append(Verdict(agent=agent, code="stale" if stale else "fresh"))
        halted = self._is_hardware(agent) and (self.options.pace != "realtime" or self._metronome.speed != 1.0)
        if halted != bridge.halted:
            bridge.halted = halted
            found.append(Verdict(agent=agent, code="halt" if halted else "unhalt"))
        return found

    def _is_hardware(self, agent: str) -> bool:
        seat = self.roster.body(agent)
        return seat is not None and seat.real and not seat.simulated_hardware

    # ------------------------------------------------------------ out

    def _put_measures(self, agent: str) -> None:
        encoding = self._encodings.get(agent)
        if encoding is not None:
            self._out.agent(agent, "measures", world.measures(self.state, agent), encoding)

    def _put_all_measures(self) -> None:
        state, put = self.state, self._out.agent
        for agent, encoding in self._encodings.items():
            put(agent, "measures", world.measures(state, agent), encoding)

    def _put_powers(self, closed: int) -> None:
        for agent in self._bridges:
            power = world.power_in_force(self.state, agent)
            self._put_power(agent, msgspec.structs.replace(power, tick=closed))

    def _put_power(self, agent: str, power: PowerInForce) -> None:
        seat = self.roster.body(agent)
        if seat is not None:
            self._out.agent(agent, "power", power, seat.encoding)

    def _rest_real(self, now: float) -> None:
        """While nothing moves, real chairs are told so ten times a second."""
        if not self._bridges or not self._stands() or now < self._idle_power_at:
            return
        self._idle_power_at = now + 0.1
        run, tick = self.state.run, self.state.tick
        for agent in self._bridges:
            if self._is_hardware(agent):
                power = PowerInForce(run=run, tick=tick, left_motor=0.0, right_motor=0.0, state="paused")
                self._put_power(agent, power)

    def _put_event(self, event: Event) -> None:
        self._ring.add(event)
        self._out.event(event)

    def _publish(self, now: float) -> None:
        self._cadence.done(now)
        for part in self._parts():
            self._out.state(part)
        self._out.clock(self._clock(now))

    def _parts(self) -> list[WorldState]:
        state = self.state
        return cut(state.run, state.tick, state.time, world.entities(state))

    def _publish_map(self) -> None:
        state = self.state
        floor = state.setup.floor
        info = MapInfo(
            run=state.run, tick=state.tick, name=floor.name, revision=state.revision, hash=world.map_hash(floor)
        )
        self._out.map(info)

    def _body(self, agent: str) -> Body:
        seat = self.roster.body(agent)
        roles: tuple[Role, ...] = tuple(each.role for each in self.roster.seats(agent))
        return Body(
            run=self.state.run,
            tick=self.state.tick,
            owner=seat.instance if seat and seat.instance else None,
            roles=roles,
            robot=self.state.fleet.figures[agent].robot,
        )

    def _clock(self, now: float) -> Clock:
        state = self.state
        return Clock(
            run=state.run,
            tick=state.tick,
            time=state.time,
            state=self._clock_state(now),
            pace=self.options.pace,
            speed=self._metronome.speed,
            factor=self._tachometer.factor(now),
            late=self._metronome.late,
            hash=self.digest(),
            stamp=self._wall(),
            waiting=self._awaited(now),
        )

    def _clock_state(self, now: float) -> ClockState:
        if self.state.ended:
            return "ended"
        if self._held:
            return "waiting"
        if self._paused and self._steps is None:
            return "paused"
        if self._lockstep and (not self._members or self._barrier.stalled(now)):
            return "waiting"
        return "running"

    def _awaited(self, now: float) -> tuple[str, ...]:
        if self._held:
            return tuple(self._missing())
        if self._lockstep and self._open and self._barrier.stalled(now):
            return self._barrier.awaited
        return ()


_REFUSED: Final[dict[ErrorCode, RefusedCode]] = {
    "field": "field",
    "value": "value",
    "malformed": "value",
    "encoding": "version",
    "version": "version",
    "too-long": "limit",
    "too-many": "limit",
}
"""How a robot that cannot be read is refused."""


def _as_joined(robot: Robot, agent: str) -> Robot:
    return robot if robot.name is not None else msgspec.structs.replace(robot, name=agent)
