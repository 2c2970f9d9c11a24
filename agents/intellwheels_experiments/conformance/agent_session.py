"""The check's conversation with one program: grants its join, sends Measures, reads Actions. Pure: it uses a `Probe`.

A point of the contract is a function of an `AgentSession`. It returns what it observed, or raises `PointError` with
what was expected and what happened.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

import msgspec

from intellwheels_experiments.conformance.plausible_readings import readings
from intellwheels_experiments.conformance.probe import (
    NO_CREWS,
    ActionsPut,
    CrewRequest,
    JoinRequest,
    Probe,
    ProgramEvent,
    ProgramExit,
    TokenChange,
)
from intellwheels_schemas.codec import Encoding, decode, encode, encoding_of
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import (
    Actions,
    Error,
    Heard,
    Joined,
    Measures,
    Parameters,
    Position,
    Refused,
    Robot,
    Scene,
    UserInput,
)
from intellwheels_schemas.names import new_hex
from intellwheels_schemas.rules import joins_barrier

REPEAT: Final = 0.25
"""Seconds after which unanswered Measures are put again, as a put may be lost."""
TOKEN_WITHIN: Final = 1.0
"""Seconds that a token may arrive after its join: Zenoh keeps no order between the two."""
QUIET: Final = 0.5
"""Seconds to wait for a message that must not come. An answer takes milliseconds."""
SAY_LIMIT: Final = 100
"""Characters of a message that the check's world allows."""
SHOWN: Final = 240
"""Bytes of a payload that a finding shows."""

_SCENE: Final = Scene(format="iw.v1", name="check", map="room")
"""The check's world has the period and the hearing range of a scene that sets none."""


class PointError(Exception):
    """A point of the contract that the program does not keep.

    Attributes:
        expected: What was expected, in words.
        got: What happened, in words or as a payload.
    """

    def __init__(self, expected: str, got: str) -> None:
        super().__init__(f"expected {expected}, got {got}")
        self.expected = expected
        self.got = got


@dataclass(frozen=True, slots=True)
class Patience:
    """How long the program may take, in seconds.

    Attributes:
        start: From its start, or from the return of the simulator, to a valid join.
        answer: From Measures to Actions.
        leave: From SIGTERM to its leaving.
    """

    start: float = 60.0
    answer: float = 2.0
    leave: float = 5.0


_Wanted: TypeAlias = tuple[type[ProgramEvent], ...]


class AgentSession:
    """One program under test, and what the check knows about it.

    Args:
        probe: The program and the network.
        world: The world's name, for `Parameters`.
        agent: The name under which the program must join.
        body: The body that a program of role `mind` gets.
        patience: How long the program may take.

    Attributes:
        run: The present run.
        session: The session that the program's Actions must name, once it has joined.
        tick: The next tick.
        encoding: The program's encoding.
        robot: The program's body.
        tokens: Its liveliness tokens: role and instance.
        pending: Its join that is not answered yet, or None.
        exit_code: The exit code of its process; None while it runs.
        last_measures: The Measures that were answered last.
        last_answer: The answer to them.
        last_put: That answer as it was put.
    """

    def __init__(self, probe: Probe, world: str, agent: str, body: Robot, patience: Patience) -> None:
        self.probe = probe
        self.agent = agent
        self.patience = patience
        self.tokens: set[tuple[str, str]] = set()
        self._world = world
        self._body = body
        self._reset()

    def _reset(self) -> None:
        self.run = new_hex()
        self.session = new_hex()
        self.tick = 0
        self.encoding = Encoding.JSON
        self.robot = self._body
        self.pending: JoinRequest | None = None
        self.exit_code: int | None = None
        self.last_measures = self.last_answer = b""
        self.last_put = ActionsPut(b"", "")
        self.tokens.clear()
        self._joined: Joined | None = None

    # ------------------------------------------------------------ join

    def require_joined(self) -> None:
        """Make sure that a program has joined and answers. Starts a new one unless the present one has joined."""
        if self._joined is not None:
            return
        self.close()
        self.probe.start_program()
        self.grant(self.await_join())
        self.exchange()

    def close(self) -> None:
        """Kill the program and forget it."""
        self.probe.kill_program()
        # A point may have failed while the simulator was away.
        self.probe.start_simulator()
        self._reset()

    def await_join(self) -> JoinRequest:
        """Wait until the program asks to join, and check its Robot and its token.

        Raises:
            PointError: It did not ask in time, or the simulator would refuse it.
        """
        expected = f"a query to join/{self.agent}"
        request = self.next_event((JoinRequest, CrewRequest), self.patience.start, expected)
        if isinstance(request, CrewRequest):
            raise PointError(expected, f"a query to crew/{request.crew}/join; {NO_CREWS}")
        if not isinstance(request, JoinRequest):
            raise PointError(f"{expected} within {self.patience.start:g} s", "none")
        try:
            self.encoding = encoding_of(request.encoding, request.data)
            robot = decode(Robot, request.data, self.encoding)
        except WireError as error:
            self.refuse(request, Refused(code="value", text=error.text))
            raise PointError("a valid Robot", f"{error.text}: {shown(request.data)}") from None
        wrong = self._fault_of(robot)
        if wrong is not None:
            self.refuse(request, Refused(code="value", text=str(wrong)))
            raise wrong
        self.robot = robot if robot.role == "both" else self._body
        return request

    def _fault_of(self, robot: Robot) -> PointError | None:
        """Return why a simulator would refuse the join, or why the check cannot judge the program; None if neither."""
        if robot.name not in (None, self.agent):
            return PointError(f"Robot.Name absent or {self.agent!r}", repr(robot.name))
        if robot.role == "body":
            return PointError("Robot.Role both or mind: a program that answers Measures with Actions", "body")
        if not joins_barrier(robot):
            return PointError(
                "a Robot that lockstep waits for (TopSpeed above 0, or Barrier true)",
                "a Robot that lockstep does not wait for, so that its answers cannot be checked",
            )
        if robot.instance is None:
            return PointError("Robot.Instance, 16 hex digits", "none")
        token = (robot.role, robot.instance)
        deadline = self.probe.now() + TOKEN_WITHIN
        while token not in self.tokens and (left := deadline - self.probe.now()) > 0.0:
            self.next_event((TokenChange,), left)
        if token not in self.tokens:
            others = ", ".join(f"{role}/{instance}" for role, instance in sorted(self.tokens)) or "none"
            return PointError(f"the token in/{self.agent}/alive/{robot.role}/{robot.instance} before the join", others)
        return None

    def refuse(self, request: JoinRequest, refused: Refused) -> None:
        """Refuse a join."""
        request.answer(encode(refused, self.encoding), self.encoding, False)

    def grant(self, request: JoinRequest) -> None:
        """Grant a join: a new run and a new session begin."""
        self.begin_run()
        self.session = new_hex()
        self._joined = Joined(
            run=self.run,
            tick=0,
            session=self.session,
            parameters=Parameters(
                world=self._world, period=_SCENE.period, pace="lockstep", say_limit=SAY_LIMIT,
                say_range=_SCENE.say_range, command_timeout=0.5, grace=3.0,
            ),
            position=Position(x=2.0, y=2.0, heading=0.0),
            robot=msgspec.structs.replace(self.robot, name=self.agent, role="both", format=None),
        )  # fmt: skip
        request.answer(encode(self._joined, self.encoding), self.encoding, True)

    def begin_run(self) -> None:
        """Begin a new run at tick 0."""
        self.run = new_hex()
        self.tick = 0

    def stop_simulator(self) -> None:
        """Make the simulator disappear. It forgets the program."""
        self.probe.stop_simulator()
        self._joined = None
        self.tokens.clear()

    # ------------------------------------------------------------ ticks

    def measures(self, heard: str = "") -> bytes:
        """Return the encoded Measures of the present tick, with a message from a stranger if `heard` is not empty."""
        message = Heard(sender="stranger", tick=max(self.tick - 1, 0), seq=1, distance=2.5, text=heard)
        measures = Measures(
            run=self.run,
            tick=self.tick,
            time=self.tick * _SCENE.period,
            sensors=readings(self.robot, self.tick),
            message=(message,) if heard else (),
            user_input=UserInput(forward=0.3, turn=0.1) if self.robot.user_input else None,
        )
        return encode(measures, self.encoding)

    def put_measures(self, payload: bytes) -> None:
        """Publish Measures for the program."""
        self.probe.put("measures", payload, self.encoding)

    def put_next_measures(self) -> None:
        """Publish the Measures of the present tick and go to the next, whether there is an answer or not."""
        self.put_measures(self.measures())
        self.tick += 1

    def put_error(self, code: Literal["late", "value"], text: str) -> None:
        """Publish an Error for the program."""
        error = Error(run=self.run, tick=self.tick, code=code, text=text)
        self.probe.put("error", encode(error, self.encoding), self.encoding)

    def exchange(self, change: Callable[[bytes, Encoding], bytes] | None = None, heard: str = "") -> float:
        """Publish the Measures of the present tick until they are answered, and go to the next tick.

        Args:
            change: Changes the encoded Measures.
            heard: A message from a stranger in them.

        Returns:
            The seconds that the answer took.

        Raises:
            PointError: There was no answer in time, or a wrong one.
        """
        payload = self.measures(heard)
        if change is not None:
            payload = change(payload, self.encoding)
        self.last_measures = payload
        expected = f"Actions with Tick {self.tick}, Run {self.run}, Session {self.session}"
        got = "nothing"
        began = self.probe.now()
        while (waited := self.probe.now() - began) < self.patience.answer:
            self.put_measures(payload)
            event = self.next_event((ActionsPut,), min(REPEAT, self.patience.answer - waited), expected)
            # Measures that were put twice are answered twice.
            while isinstance(event, ActionsPut) and event.data == self.last_answer:
                got = f"{shown(event.data)} again"
                event = self.next_event((ActionsPut,), REPEAT, expected)
            if isinstance(event, ActionsPut):
                actions = self.read(event)
                named = (actions.tick, actions.run, actions.session)
                right = (self.tick, self.run, self.session)
                if any(name not in (None, value) for name, value in zip(named, right, strict=True)) or actions.leave:
                    raise PointError(expected, shown(event.data))
                self.last_answer, self.last_put = event.data, event
                self.tick += 1
                return self.probe.now() - began
        raise PointError(f"{expected} within {self.patience.answer:g} s", f"{got} in answer to {shown(payload)}")

    def read(self, put: ActionsPut) -> Actions:
        """Return decoded Actions, by their first byte: their encoding is a point of its own, and so is their Session.

        Raises:
            PointError: They are not valid.
        """
        try:
            return decode(Actions, put.data, encoding_of("", put.data))
        except WireError as error:
            fault = error
        if (fault.code, fault.where) == ("field", "Actions.Session"):
            named = _with_session(put.data, self.session)
            try:
                return msgspec.structs.replace(decode(Actions, named, encoding_of("", named)), session=None)
            except WireError as error:
                fault = error
        raise PointError("valid Actions", f"{fault.text}: {shown(put.data)}") from None

    # ------------------------------------------------------------ events

    def settle(self) -> None:
        """Wait for messages that are still on their way, and ignore them."""
        deadline = self.probe.now() + REPEAT
        while (left := deadline - self.probe.now()) > 0.0:
            self.next_event((ActionsPut,), left)

    def expect_silence(self, seconds: float, expected: str) -> None:
        """Check that no Actions come for some seconds, other than a repetition of the last answer.

        Raises:
            PointError: Some came, or the program ended.
        """
        deadline = self.probe.now() + seconds
        while (left := deadline - self.probe.now()) > 0.0:
            event = self.next_event((ActionsPut,), left, expected)
            if isinstance(event, ActionsPut) and event.data != self.last_answer:
                raise PointError(expected, shown(event.data))

    def next_event(self, wanted: _Wanted, within: float, expected: str = "") -> ProgramEvent | None:
        """Return the next event of some classes, or None if none comes in time.

        Of the other events, changes of tokens and the end of the program are noted, and a repeated join is answered.

        Args:
            wanted: The classes.
            within: Seconds.
            expected: What is expected of the program. If it is given, the end of the program is an error.

        Raises:
            PointError: The program ended.
        """
        deadline = self.probe.now() + within
        while (left := deadline - self.probe.now()) > 0.0:
            event = self.probe.next_event(left)
            if isinstance(event, TokenChange):
                (self.tokens.add if event.alive else self.tokens.discard)((event.role, event.instance))
            elif isinstance(event, ProgramExit):
                self.exit_code = event.code
            if isinstance(event, wanted):
                return event
            if isinstance(event, JoinRequest) and self._joined is not None:
                # The same instance asks again, so its place is still its own.
                event.answer(encode(self._joined, self.encoding), self.encoding, True)
            if self.exit_code is not None and expected:
                raise PointError(expected, f"the end of the program, exit code {self.exit_code}")
        return None


def _with_session(data: bytes, session: str) -> bytes:
    """Return Actions that have no Session with one."""
    if data.startswith(b"<"):
        return data.replace(b"<Actions", f'<Actions Session="{session}"'.encode(), 1)
    rest = data.strip()[1:]
    return f'{{"Session":"{session}"'.encode() + (b"" if rest.lstrip() == b"}" else b",") + rest


def shown(data: bytes) -> str:
    """Return the beginning of a payload as text."""
    text = data[:SHOWN].decode("utf-8", "backslashreplace")
    return text + (f"... ({len(data)} bytes)" if len(data) > SHOWN else "")
