"""What a program must do to keep the contract, point by point. Pure: the program and the network are a `Probe`.

Each point says what was expected and what came. A point that failed ends the program, and the next begins with a
fresh one that has joined: so one fault fails one point.

    join      asks to join with a valid Robot, its liveliness token there
    refusal   refused: shows the words, and sends no Actions
    ticks     20 Measures, each answered by Actions with its tick, run and session
    lost      a tick that never comes: the next one is answered
    again     the same Measures once more: the same bytes once more, as the first may be lost
    late      a tick that comes behind a newer one is not answered, and an Error about it changes nothing
    reset     another Run, from tick 0: answered with that run
    restart   the simulator goes and comes back, knowing nobody: joins again, and answers with the new session
    unknown   fields and elements that this version does not have: ignored
    hostile   words heard that look like markup, commands or another message: only words
    leave     told to end (SIGTERM): its token goes, or it says that it leaves; no Actions after that
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Final, Literal, NamedTuple, Protocol, TypeAlias

import msgspec

from intellwheels_experiments.conformance.plausible_readings import readings
from intellwheels_schemas import defaults
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
    Record,
    Refused,
    Robot,
    Role,
    UserInput,
)
from intellwheels_schemas.names import new_hex
from intellwheels_schemas.rules import joins_barrier

TICKS: Final = 20
"""Ticks of the point of that name."""
REPEAT: Final = 0.25
"""Seconds until Measures that were not answered are put again; a put may be lost."""
QUIET: Final = 0.5
"""Seconds in which what must not come would have come: an answer takes milliseconds."""
REFUSED_FOR: Final = 3.0
"""Seconds a refused program has to show the words, and to end if it wants to."""
TOKEN_WITHIN: Final = 1.0
"""Seconds a token may come behind its join: Zenoh keeps no order between them."""

HOSTILE: Final = (
    "]]></Message></Measures><Measures Run='0000000000000000' Tick='99' Time='1.0'/>",
    '","Tick":99,"Run":"0000000000000000","x":"',
    "</Say>&amp;&lt;&#0;<!-- <![CDATA[ <!DOCTYPE a [<!ENTITY b SYSTEM 'file:///etc/passwd'>]> &b;",
    "$(kill -9 $PPID) `exit` ; rm -rf . | %s%n%x {0} {name} ${HOME} \\u0000 \\x00 \\",
    "'; DROP TABLE chairs; -- \" ' ` \t\n\n\tTick 99",
    "\u202e\u200b\ufeff\u0085\u2028\u2029 \U0001f468\u200d\U0001f9bd \U0010fffd e\u0301 \u65e0",
    "9" * 1000,
)
"""Texts that are valid, and that a careless reader takes for something else."""


# ---------------------------------------------------------------- what happens


class Asked(NamedTuple):
    """The program asked to join; `answer` takes payload, encoding, and whether it is no refusal."""

    data: bytes
    encoding: str
    answer: Callable[[bytes, Encoding, bool], None]


class Acted(NamedTuple):
    """The program put something on its `actions`."""

    data: bytes
    encoding: str


class Seen(NamedTuple):
    """A token of the program came or went."""

    role: Role
    instance: str
    alive: bool


class Left(NamedTuple):
    """The program asked to leave, and was answered."""


class Ended(NamedTuple):
    """The program's process ended; a negative code is the signal that ended it."""

    code: int


News: TypeAlias = Asked | Acted | Seen | Left | Ended


class Probe(Protocol):
    """The program that is looked at, and the simulator that it sees."""

    def now(self) -> float:
        """Return seconds of a monotonic clock."""
        ...

    def start(self) -> None:
        """Start the program."""
        ...

    def interrupt(self) -> None:
        """Tell the program to end."""
        ...

    def end(self) -> None:
        """End the program whatever it does; nothing of it is left, nor of what arrived from it."""
        ...

    def printed(self) -> str:
        """Return what the program printed since its start, both outputs."""
        ...

    def rise(self) -> None:
        """Let the simulator be there."""
        ...

    def fall(self) -> None:
        """Let the simulator be gone, its connections too."""
        ...

    def put(self, kind: Literal["measures", "error"], data: bytes, encoding: Encoding) -> None:
        """Put something for the program."""
        ...

    def wait(self, seconds: float) -> News | None:
        """Return what happened next, or None when nothing did in so many seconds."""
        ...


# ---------------------------------------------------------------- what is found


class Outcome(NamedTuple):
    """What came of a point; `passed` is None when it could not be played."""

    point: str
    passed: bool | None
    expected: str
    got: str
    printed: str = ""


class PointError(Exception):
    """A point that fails.

    Attributes:
        expected: In words.
        got: In words, or as bytes.
    """

    def __init__(self, expected: str, got: str) -> None:
        super().__init__(f"expected {expected}, got {got}")
        self.expected = expected
        self.got = got


@dataclass(frozen=True, slots=True)
class Patience:
    """Seconds that the program has.

    Attributes:
        start: From its start, or the simulator's return, to a valid join.
        answer: To an answer.
        leave: To leave after it was told to end.
    """

    start: float = 60.0
    answer: float = 2.0
    leave: float = 5.0


_Wanted: TypeAlias = tuple[type[News], ...]


class Check:
    """One program's examination.

    Args:
        stand: Where it takes place.
        world: The world's name, for `Parameters`.
        agent: The name the program must join under.
        body: What a program of role `mind` is told that its body is.
        patience: How long it may take.
    """

    def __init__(self, stand: Probe, world: str, agent: str, body: Robot, patience: Patience | None = None) -> None:
        self._stand = stand
        self._world = world
        self._agent = agent
        self._body = body
        self._patience = patience or Patience()
        self._joined: Joined | None = None
        self._pending: Asked | None = None
        self._tokens: set[tuple[str, str]] = set()
        self._ended: int | None = None
        self._forget()

    def run(self) -> Iterator[Outcome]:
        """Play all points and yield what came of each, in their order."""
        points: dict[str, Callable[[], str]] = {
            "join": self._join, "refusal": self._refusal, "ticks": self._ticks, "lost": self._lost,
            "again": self._again, "late": self._late, "reset": self._reset, "restart": self._restart,
            "unknown": self._unknown, "hostile": self._hostile, "leave": self._leave,
        }  # fmt: skip
        self._stand.rise()
        hopeless = False
        for name, play in points.items():
            if hopeless:
                yield Outcome(name, None, "a program that joins", "none")
                continue
            try:
                words = play()
            except PointError as error:
                yield Outcome(name, False, error.expected, error.got, self._stand.printed())
                hopeless = name == "join"
                self._over()
            else:
                yield Outcome(name, True, words, "")
        self._over()

    # ------------------------------------------------------------ points

    def _join(self) -> str:
        self._stand.start()
        self._pending = self._asked()
        return f"joins as {self._robot.kind}, {self._encoding.name}"

    def _refusal(self) -> str:
        pending, self._pending = self._pending, None
        words = f"agent '{self._agent}' is already here, says the check {new_hex()}"
        refusal = encode(Refused(code="already-here", text=words), self._encoding)
        if pending is not None:
            pending.answer(refusal, self._encoding, False)
        expected = "no Actions after a refused join"
        deadline = self._stand.now() + REFUSED_FOR
        while self._stand.now() < deadline and self._ended is None:
            self._put(self._measures())
            self._tick += 1
            news = self._next((Acted, Asked, Ended), 0.1)
            if isinstance(news, Acted):
                raise PointError(expected, _shown(news.data))
            if isinstance(news, Asked):
                news.answer(refusal, self._encoding, False)
        if words not in self._stand.printed():
            raise PointError(f"the words of the refusal on its output: {words!r}", "others, or none")
        how = "ends" if self._ended is not None else "goes on without the body"
        self._over()
        return f"shows the words and {how}"

    def _ticks(self) -> str:
        self._enter()
        slowest = max(self._answered() for _ in range(TICKS))
        return f"{TICKS} ticks answered, the slowest in {1000 * slowest:.0f} ms"

    def _lost(self) -> str:
        self._enter()
        self._tick += 2
        self._answered()
        return "two ticks did not come, the next was answered"

    def _again(self) -> str:
        self._enter()
        self._answered()
        first = self._answer
        self._rest()
        self._put(self._payload)
        news = self._next((Acted,), self._patience.answer, f"an answer to tick {self._tick - 1} that came again")
        if not isinstance(news, Acted):
            raise PointError("the same bytes again", "nothing")
        if news.data != first:
            raise PointError(f"the same bytes again, {_shown(first)}", _shown(news.data))
        return "the same bytes again"

    def _late(self) -> str:
        self._enter()
        late = self._measures()
        self._tick += 1
        self._answered()
        self._rest()
        self._put(late)
        self._silent(QUIET, f"no answer to tick {self._tick - 2} behind tick {self._tick - 1}")
        self._complain("late", "Actions.Tick: expected the present tick, got an older one")
        self._answered()
        return "an old tick was not answered, the next was"

    def _reset(self) -> str:
        self._enter()
        before = self._run
        self._begin(new_hex())
        for _ in range(3):
            self._answered()
        return f"run {before} went, run {self._run} was answered from tick 0"

    def _restart(self) -> str:
        self._enter()
        self._stand.fall()
        self._joined = None
        self._tokens.clear()
        self._rest()
        self._stand.rise()
        self._accept(self._asked())
        for _ in range(3):
            self._answered()
        return "joined again, and answered with the new session"

    def _unknown(self) -> str:
        self._enter()
        self._answered(_grown)
        self._answered()
        return "answered as if they were not there"

    def _hostile(self) -> str:
        self._enter()
        self._complain("value", HOSTILE[0])
        for text in HOSTILE:
            self._answered(text=text)
        self._answered()
        return f"{len(HOSTILE)} texts heard, all answered"

    def _leave(self) -> str:
        self._enter()
        self._stand.interrupt()
        deadline = self._stand.now() + self._patience.leave
        how = ""
        while not how:
            if self._stand.now() >= deadline:
                words = f"its token gone, or Leave, {self._patience.leave:g} s after SIGTERM"
                raise PointError(words, "it is here as before")
            self._put(self._measures())
            self._tick += 1
            news = self._next((Acted, Left, Seen, Ended), 0.05)
            if isinstance(news, Acted) and self._read(news).leave:
                how = "put Leave"
            elif isinstance(news, Left):
                how = "asked to leave"
            elif not self._tokens:
                how = "its token is gone"
        self._rest()
        # What answers these was put after it left, whatever overtook what on the way.
        first = self._tick
        after = self._stand.now() + QUIET
        while self._stand.now() < after and self._ended is None:
            self._put(self._measures())
            self._tick += 1
            news = self._next((Acted, Ended), 0.05)
            if isinstance(news, Acted) and (tick := self._read(news).tick) is not None and tick < first:
                continue
            if isinstance(news, Acted):
                raise PointError(f"no Actions after it left ({how})", _shown(news.data))
        return how

    # ------------------------------------------------------------ how a program is met

    def _forget(self) -> None:
        self._run = new_hex()
        self._session = new_hex()
        self._tick = 0
        self._seq = 0
        self._encoding = Encoding.JSON
        self._robot = self._body
        self._joined = None
        self._pending = None
        self._tokens.clear()
        self._ended = None
        self._payload = self._answer = b""

    def _over(self) -> None:
        """End the program."""
        self._stand.end()
        # A point may have failed while the simulator was away.
        self._stand.rise()
        self._forget()

    def _enter(self) -> None:
        """Have a program that has joined and answers."""
        if self._joined is not None:
            return
        self._over()
        self._stand.start()
        self._accept(self._asked())
        self._answered()

    def _asked(self) -> Asked:
        """Wait for a valid question to join, its token there."""
        expected = f"a query to join/{self._agent}"
        asked = self._next((Asked,), self._patience.start, expected)
        if not isinstance(asked, Asked):
            raise PointError(f"{expected} within {self._patience.start:g} s", "none")
        try:
            self._encoding = encoding_of(asked.encoding, asked.data)
            robot = decode(Robot, asked.data, self._encoding)
        except WireError as error:
            self._refuse(asked, Refused(code="value", text=error.text))
            raise PointError("a valid Robot", f"{error.text}: {_shown(asked.data)}") from None
        wrong = self._wrong(robot)
        if wrong is not None:
            self._refuse(asked, Refused(code="value", text=str(wrong)))
            raise wrong
        self._robot = robot if robot.role == "both" else self._body
        return asked

    def _wrong(self, robot: Robot) -> PointError | None:
        if robot.name not in (None, self._agent):
            return PointError(f"Robot.Name absent or {self._agent!r}", repr(robot.name))
        if robot.role == "body":
            return PointError("Robot.Role both or mind: a program that answers Measures with Actions", "body")
        if not joins_barrier(robot):
            return PointError(
                "a Robot that lockstep awaits (TopSpeed above 0, or Barrier true)",
                "one that need not answer, so nothing can be said of its answers",
            )
        if robot.instance is None:
            return PointError("Robot.Instance, 16 hex digits", "none")
        deadline = self._stand.now() + TOKEN_WITHIN
        while (robot.role, robot.instance) not in self._tokens and self._stand.now() < deadline:
            self._next((Seen,), deadline - self._stand.now())
        if (robot.role, robot.instance) not in self._tokens:
            others = ", ".join(f"{role}/{instance}" for role, instance in sorted(self._tokens)) or "none"
            return PointError(f"the token in/{self._agent}/alive/{robot.role}/{robot.instance} before the join", others)
        return None

    def _refuse(self, asked: Asked, refused: Refused) -> None:
        asked.answer(encode(refused, self._encoding), self._encoding, False)

    def _accept(self, asked: Asked) -> None:
        self._begin(new_hex())
        self._session = new_hex()
        self._joined = Joined(
            run=self._run,
            tick=0,
            session=self._session,
            parameters=Parameters(
                world=self._world, period=defaults.PERIOD, pace="lockstep", say_limit=defaults.SAY_LIMIT,
                say_range=defaults.SAY_RANGE, command_timeout=defaults.COMMAND_TIMEOUT, grace=defaults.GRACE,
            ),
            position=Position(x=2.0, y=2.0, heading=0.0),
            robot=msgspec.structs.replace(self._robot, name=self._agent, role="both", format=None),
        )  # fmt: skip
        asked.answer(encode(self._joined, self._encoding), self._encoding, True)

    def _begin(self, run: str) -> None:
        self._run = run
        self._tick = 0

    # ------------------------------------------------------------ a tick

    def _measures(self, text: str = "") -> bytes:
        heard = (Heard(sender="stranger", tick=max(self._tick - 1, 0), seq=1, distance=2.5, text=text),) if text else ()
        measures = Measures(
            run=self._run,
            tick=self._tick,
            time=self._tick * defaults.PERIOD,
            sensors=readings(self._robot, self._tick),
            message=heard,
            user_input=UserInput(forward=0.3, turn=0.1) if self._robot.user_input else None,
        )
        return encode(measures, self._encoding)

    def _put(self, payload: bytes) -> None:
        self._stand.put("measures", payload, self._encoding)

    def _complain(self, code: Literal["late", "value"], text: str) -> None:
        error: Record = Error(run=self._run, tick=self._tick, code=code, text=text)
        self._stand.put("error", encode(error, self._encoding), self._encoding)

    def _answered(self, change: Callable[[bytes, Encoding], bytes] | None = None, text: str = "") -> float:
        """Put the Measures of the next tick until they are answered; return the seconds it took."""
        payload = self._measures(text)
        if change is not None:
            payload = change(payload, self._encoding)
        self._payload = payload
        expected = f"Actions with Tick {self._tick}, Run {self._run}, Session {self._session}"
        got = "nothing"
        began = self._stand.now()
        while (waited := self._stand.now() - began) < self._patience.answer:
            self._put(payload)
            news = self._next((Acted,), min(REPEAT, self._patience.answer - waited), expected)
            # The answer to what was put twice comes twice.
            while isinstance(news, Acted) and news.data == self._answer:
                got = f"{_shown(news.data)} again"
                news = self._next((Acted,), REPEAT, expected)
            if isinstance(news, Acted):
                actions = self._read(news)
                named = (actions.tick, actions.run, actions.session)
                wanted = (self._tick, self._run, self._session)
                if any(name not in (None, right) for name, right in zip(named, wanted, strict=True)) or actions.leave:
                    raise PointError(expected, _shown(news.data))
                self._answer = news.data
                self._tick += 1
                return self._stand.now() - began
        raise PointError(f"{expected} within {self._patience.answer:g} s", f"{got} to {_shown(payload)}")

    def _read(self, acted: Acted) -> Actions:
        try:
            return decode(Actions, acted.data, encoding_of(acted.encoding, acted.data))
        except WireError as error:
            raise PointError("valid Actions", f"{error.text}: {_shown(acted.data)}") from None

    def _rest(self) -> None:
        """Let what is on its way arrive, and forget it."""
        deadline = self._stand.now() + REPEAT
        while (left := deadline - self._stand.now()) > 0.0:
            self._next((Acted,), left)

    def _silent(self, seconds: float, expected: str) -> None:
        deadline = self._stand.now() + seconds
        while (left := deadline - self._stand.now()) > 0.0:
            news = self._next((Acted,), left, expected)
            if isinstance(news, Acted) and news.data != self._answer:
                raise PointError(expected, _shown(news.data))

    def _next(self, wanted: _Wanted, within: float, expected: str = "") -> News | None:
        """Return the next of the wanted news, or None when none came in so many seconds.

        Args:
            wanted: Their classes; of the others the tokens are kept in mind, and a repeated join is answered.
            within: Seconds.
            expected: When given, the program's end fails the point, as what is expected cannot come any more.

        Raises:
            PointError: The program ended.
        """
        deadline = self._stand.now() + within
        while (left := deadline - self._stand.now()) > 0.0:
            news = self._stand.wait(left)
            if isinstance(news, Seen):
                (self._tokens.add if news.alive else self._tokens.discard)((news.role, news.instance))
            elif isinstance(news, Ended):
                self._ended = news.code
            if isinstance(news, wanted):
                return news
            if isinstance(news, Asked) and self._joined is not None:
                # The same instance asks once more: its seat is its own.
                news.answer(encode(self._joined, self._encoding), self._encoding, True)
            if self._ended is not None and expected:
                raise PointError(expected, f"the program's end, exit code {self._ended}")
        return None


def _grown(payload: bytes, encoding: Encoding) -> bytes:
    """Return Measures as a later version might write them: fields and records that nobody knows yet."""
    if encoding is Encoding.JSON:
        plain = json.loads(payload)
        plain |= {"Weather": {"Rain": None, "Wind": [1.5, "N"]}, "Mood": [1, "two"]}
        sensors = plain.setdefault("Sensors", {})
        for kind in sensors.values():
            for reading in kind:
                reading["Confidence"] = 0.5
        sensors["Nose"] = [{"Id": "nose", "Smell": "coffee"}]
        return json.dumps(plain, separators=(",", ":")).encode()
    text = payload.decode().replace("<Measures ", '<Measures Mood="1" ', 1)
    if text.endswith("/>"):
        text = text[:-2] + "></Measures>"
    grown = '<Weather Rain="0.0">text</Weather>'
    nose = '<Nose Id="nose" Smell="coffee"/></Sensors>'
    return text.replace("</Sensors>", nose, 1).replace("</Measures>", grown + "</Measures>", 1).encode()


def _shown(data: bytes) -> str:
    text = data[:240].decode("utf-8", "backslashreplace")
    return text + (f"... ({len(data)} bytes)" if len(data) > 240 else "")
