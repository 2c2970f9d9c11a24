"""What keeps an agent at its simulator, without any I/O: what happened goes in, what to do comes out.

    phase     what happens                                 then       what to do
    SEEKING   start, retry time, simulator present         ASKING     Ask
    ASKING    Joined                                       JOINED     a fresh mind (not if run and session are the old)
    ASKING    Refused no-body, no-token; nobody answers    SEEKING    retry in a second
    ASKING    Refused otherwise                            OVER       End 1, with the simulator's words
    JOINED    Measures of a tick                           JOINED     Put the mind's answer
    JOINED    Measures of the tick just answered           JOINED     Put the same bytes again
    JOINED    Measures of a new run                        JOINED     a fresh mind, and its answer
    JOINED    Error not-joined or session                  SEEKING    retry, at most once a second
    JOINED    the simulator is gone, and present again     ASKING     Ask
    any       the mind leaves, or stop                     OVER       Depart, End 0

A session, once had, is answered for while a new one is sought: the simulator may know us still.
Measures that overtake the reply to a join are kept until it comes. Times are seconds of one monotonic clock.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum, auto
from typing import Final, TypeAlias

import msgspec

from intellwheels_agents.mind import Bridge, Context, Make, Mind
from intellwheels_agents.options import Options
from intellwheels_schemas.codec import Encoding, decode, encode
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import (
    TEXT_PATTERN,
    Actions,
    Error,
    Joined,
    Leave,
    Map,
    Measures,
    Pose,
    PowerInForce,
    Refused,
    Robot,
)
from intellwheels_schemas.rules import joins_barrier

RETRY: Final = 1.0
"""Seconds between tries to join."""
TOKEN_RETRY: Final = 0.1
"""Seconds until the next try when the simulator has not seen our token yet: it is on its way."""

_NOTHING = Actions()
_TEXT = re.compile(TEXT_PATTERN)


class Phase(Enum):
    """Where an agent stands with its simulator."""

    SEEKING = auto()
    ASKING = auto()
    JOINED = auto()
    OVER = auto()


@dataclass(frozen=True, slots=True)
class Ask:
    """Query `join/<agent>` with this `Robot`."""

    payload: bytes


@dataclass(frozen=True, slots=True)
class Put:
    """Put this on the agent's `actions`, or a body's `pose`."""

    payload: bytes


@dataclass(frozen=True, slots=True)
class Depart:
    """Query `leave/<agent>` with this `Leave`."""

    payload: bytes


@dataclass(frozen=True, slots=True)
class Tell:
    """A line for the script that waits for it."""

    line: str


@dataclass(frozen=True, slots=True)
class Note:
    """A line for the log."""

    line: str


@dataclass(frozen=True, slots=True)
class End:
    """Nothing further: the exit code, and words for people when it is not 0."""

    code: int
    text: str = ""


Output: TypeAlias = Ask | Put | Depart | Tell | Note | End
Payload: TypeAlias = tuple[bytes, Encoding]


NAME_TAKEN = 4
PLACE_TAKEN = 5
"""What a run ends with, instead of 1, when another had the name, or stood at the place, before it was ever here."""
_TAKEN = {"already-here": NAME_TAKEN, "overlaps": PLACE_TAKEN}


class Harness:
    """One agent's side of the contract.

    Attributes:
        phase: Where it stands.
        deadline: When `wake` must be called, or None.
        missed: Ticks that never came, or came behind a newer one.
        repeated: Ticks answered twice, because they were put twice.
        errors: `Error`s and unreadable messages received.
    """

    def __init__(
        self,
        robot: Robot,
        make: Make,
        *,
        options: Mapping[str, str] | None = None,
        encoding: Encoding = Encoding.JSON,
        fetch_map: Callable[[], Map] | None = None,
        simulator: str = "the simulator",
        retry_for: float = math.inf,
    ) -> None:
        """Prepare to join with `robot`, as `equipment.joining` makes it.

        Args:
            robot: The document to join with; it has a name.
            make: Makes a mind at each run.
            options: The mind's.
            encoding: Of what is written, and by that of what the simulator writes back.
            fetch_map: Asks the simulator for its map.
            simulator: Where it is looked for, in words.
            retry_for: Seconds to look for it before giving up.
        """
        self.phase = Phase.SEEKING
        self.deadline: float | None = None
        self.missed = 0
        self.repeated = 0
        self.errors = 0
        self._agent = robot.name or ""
        self._acts = robot.role != "body"
        self._awaited = joins_barrier(robot)
        self._request = encode(robot, encoding)
        self._make = make
        self._options = dict(options or {})
        self._encoding = encoding
        self._fetch_map = fetch_map or _no_map
        self._simulator = simulator
        self._retry_for = retry_for
        self._erred: dict[str, int] = {}
        self._since = 0.0
        self._asked = -math.inf
        self._gone = False
        self._joined: Joined | None = None
        self._run = ""
        self._session = ""
        self._past_runs: set[str] = set()
        self._mind: Mind | Bridge | None = None
        self._early: Payload | None = None
        self._tick = -1
        self._seq = 0
        self._payload = b""
        self._answer = b""

    # ------------------------------------------------------------ joining

    def start(self, now: float) -> list[Output]:
        """Begin."""
        self._since = now
        return self._ask(now)

    def wake(self, now: float) -> list[Output]:
        """Do what was put off until `deadline`."""
        if self.deadline is None or now < self.deadline:
            return []
        if self.phase is Phase.SEEKING:
            return self._ask(now)
        return self._over(1, f"no simulator at {self._simulator}, or not allowed")

    def accepted(self, payload: Payload) -> list[Output]:
        """Take the reply to a join."""
        if self.phase is not Phase.ASKING:
            return []
        try:
            joined = decode(Joined, *payload, strict=False)
        except WireError as error:
            return self._over(1, f"the reply to join cannot be read: {error.text}")
        self.phase = Phase.JOINED
        self._gone = False
        same = joined.run == self._run and joined.session == self._session
        self._joined = joined
        self._session = joined.session
        outputs: list[Output] = [Tell(f"joined agent={self._agent} run={joined.run} tick={joined.tick}")]
        if not same:
            self._begin(joined.run)
        early, self._early = self._early, None
        return outputs + (self.measured([early]) if early else [])

    def refused(self, payload: Payload, now: float) -> list[Output]:
        """Take the error reply to a join."""
        if self.phase is not Phase.ASKING:
            return []
        try:
            refused = decode(Refused, *payload, strict=False)
        except WireError as error:
            return self._over(1, f"the refusal of join cannot be read: {error.text}")
        if refused.code not in ("no-body", "no-token"):
            never_here = self._joined is None
            code = _TAKEN.get(refused.code, 1) if never_here else 1
            return self._over(code, f"refused ({refused.code}): {refused.text}")
        soon = refused.code == "no-token"
        return self._later(now, TOKEN_RETRY if soon else RETRY, f"refused ({refused.code}): {refused.text}")

    def unanswered(self, now: float) -> list[Output]:
        """Learn that nobody answered a join."""
        if self.phase is not Phase.ASKING:
            return []
        return self._later(now, RETRY, f"no simulator at {self._simulator}, or not allowed")

    def present(self, now: float) -> list[Output]:
        """Learn that a simulator is there."""
        if self.phase is Phase.SEEKING:
            return self._ask(now)
        if self.phase is Phase.JOINED and self._gone:
            self._since = now
            return self._ask(now)
        return []

    def absent(self, now: float) -> list[Output]:
        """Learn that the simulator is gone, or cannot be seen."""
        if self._gone or self.phase is Phase.OVER:
            return []
        self._gone = True
        if self.phase is Phase.JOINED and math.isfinite(self._retry_for):
            self.deadline = now + self._retry_for
        return [Note(f"lost simulator={self._simulator}")]

    def _ask(self, now: float) -> list[Output]:
        self.phase = Phase.ASKING
        self.deadline = None
        self._asked = now
        return [Ask(self._request)]

    def _later(self, now: float, pause: float, why: str) -> list[Output]:
        if now + pause - self._since > self._retry_for:
            return self._over(1, why)
        first = self._asked <= self._since
        self.phase = Phase.SEEKING
        self.deadline = now + pause
        return [Note(f"waiting why={why!r}")] if first else []

    # ------------------------------------------------------------ each tick

    def measured(self, payloads: Sequence[Payload]) -> list[Output]:
        """Take `Measures`, oldest first, and answer the newest; what was heard in the others is kept."""
        if self._mind is None:
            if payloads:
                self._early = payloads[-1]
            return []
        if len(payloads) == 1 and payloads[0][0] == self._payload:
            return self._again()
        outputs: list[Output] = []
        came: list[Measures] = []
        for payload in payloads:
            try:
                came.append(decode(Measures, *payload, strict=False))
            except WireError as error:
                self.errors += 1
                outputs.append(Note(f"dropped message=Measures why={error.text!r}"))
        came = [measures for measures in came if measures.run not in self._past_runs]
        if not came:
            return outputs
        newest = came[-1]
        if newest.run != self._run and self.phase is Phase.ASKING:
            # The simulator is another; our session with it is on its way.
            self._early = payloads[-1]
            return outputs
        if newest.run != self._run:
            outputs.append(Tell(f"run agent={self._agent} run={newest.run}"))
            self._begin(newest.run)
        if newest.tick <= self._tick:
            return outputs + (self._again() if newest.tick == self._tick else [])
        if len(came) > 1:
            newest = self._merged(came)
        if newest.tick > self._tick + 1 and self._tick >= 0:
            self.missed += newest.tick - self._tick - 1
        self._tick = newest.tick
        self._payload = payloads[-1][0]
        return outputs + self._decided(newest)

    def _decided(self, measures: Measures) -> list[Output]:
        assert self._mind is not None  # noqa: S101 - a bug of ours, no input leads here
        answer = self._mind.decide(measures)
        seq = self._seq
        self._seq += 1
        if isinstance(answer, Pose):
            pose = msgspec.structs.replace(answer, run=self._run, session=self._session, tick=measures.tick, seq=seq)
            self._answer = encode(pose, self._encoding)
            return [Put(self._answer)]
        if answer is None or not self._acts:
            # Of a simulated body the mind is somebody else's, and its actions are awaited.
            return []
        if answer == _NOTHING and not self._awaited:
            # Would only come late to a tick that waits for others.
            return []
        left, right, say = answer.left_motor, answer.right_motor, answer.say
        self._answer = encode(
            Actions(
                run=self._run,
                session=self._session,
                tick=measures.tick,
                seq=seq,
                left_motor=left if left is None or -1.0 <= left <= 1.0 else _clamped(left),
                right_motor=right if right is None or -1.0 <= right <= 1.0 else _clamped(right),
                mode=answer.mode,
                leave=answer.leave,
                goal=answer.goal,
                say=say if say is None else self._sayable(say),
            ),
            self._encoding,
        )
        if answer.leave:
            return [Put(self._answer), *self.stop()]
        return [Put(self._answer)]

    def _again(self) -> list[Output]:
        self.repeated += 1
        return [Put(self._answer)] if self._answer else []

    def _merged(self, came: Sequence[Measures]) -> Measures:
        newest = came[-1]
        heard = tuple(
            message
            for measures in came
            if measures.run == newest.run and measures.tick > self._tick
            for message in measures.message
        )
        return msgspec.structs.replace(newest, message=heard)

    def _sayable(self, text: str) -> str:
        if _TEXT.match(text) is None:
            raise ValueError(f"say: expected text without control characters, got {text!r}")
        limit = self._joined.parameters.say_limit if self._joined else len(text)
        return text[:limit]

    def _begin(self, run: str) -> None:
        assert self._joined is not None  # noqa: S101 - a bug of ours, no input leads here
        if self._run and self._run != run:
            self._past_runs.add(self._run)
        self._run = run
        self._tick = -1
        self._seq = 0
        self._payload = self._answer = b""
        options = Options(self._options)
        joined = self._joined
        self._mind = self._make(
            Context(self._agent, joined.robot, joined.position, joined.parameters, options, self._fetch_map, run)
        )
        options.check_all_read()

    # ------------------------------------------------------------ the rest

    def erred(self, payload: Payload, now: float) -> list[Output]:
        """Take an `Error`."""
        self.errors += 1
        try:
            error = decode(Error, *payload, strict=False)
        except WireError as wrong:
            return [Note(f"dropped message=Error why={wrong.text!r}")]
        if error.code in ("not-joined", "session") and self.phase is Phase.JOINED:
            self._since = now
            self.phase = Phase.SEEKING
            # An error that was on its way while we joined must not make us ask without end.
            self.deadline = max(now, self._asked + RETRY)
        count = self._erred[error.code] = self._erred.get(error.code, 0) + 1
        # The first, the tenth, the hundredth: what goes wrong each tick must not fill the log.
        if str(count).strip("0") != "1":
            return []
        return [Note(f"erred code={error.code} count={count} tick={error.tick} text={error.text!r}")]

    def powered(self, payload: Payload) -> list[Output]:
        """Take the `Power` a real chair must give."""
        obey = getattr(self._mind, "obey", None)
        if obey is not None:
            try:
                obey(decode(PowerInForce, *payload, strict=False))
            except WireError as error:
                self.errors += 1
                return [Note(f"dropped message=Power why={error.text!r}")]
        return []

    def stop(self) -> list[Output]:
        """End, because the agent was told to or wants to."""
        if self.phase is Phase.OVER:
            return []
        if not self._session:
            return self._over(0, "")
        leave = Depart(encode(Leave(run=self._run, session=self._session), self._encoding))
        counts = Note(f"counted missed={self.missed} repeated={self.repeated} errors={self.errors}")
        return [leave, counts, Tell(f"left agent={self._agent}"), *self._over(0, "")]

    def _over(self, code: int, text: str) -> list[Output]:
        self.phase = Phase.OVER
        self.deadline = None
        return [End(code, text)]


def _clamped(power: float) -> float:
    if math.isnan(power):
        raise ValueError("a mind's power: expected a number, got nan")
    return 1.0 if power > 0.0 else -1.0


def _no_map() -> Map:
    raise RuntimeError("this harness was given no way to fetch a map")
