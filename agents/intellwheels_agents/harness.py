"""Keeps an agent joined to its simulator. No I/O: events go in, and what the caller must do comes out.

    phase     event                                        next       output
    SEEKING   start, retry time, simulator appears         ASKING     RequestJoin
    ASKING    Joined                                       JOINED     new mind (unless run and session are unchanged)
    ASKING    Joined without a key for a real body         ASKING     Reappear, RequestJoin
    ASKING    Refused no-body or no-token; no answer       SEEKING    retry after a second, or 0.1 s for no-token
    ASKING    Refused for another reason                   OVER       Exit 1 with the simulator's text
    JOINED    Measures of a new tick                       JOINED     Publish the mind's answer
    JOINED    Measures of the last answered tick           JOINED     Publish the same bytes again
    JOINED    Measures of a new run, or far ahead          JOINED     AskClock
    JOINED    the clock is in that run, at that tick       JOINED     new mind if the run is new, and its answer
    JOINED    Error not-joined or session                  SEEKING    retry, at most once a second
    JOINED    simulator disappears and comes back          ASKING     RequestJoin
    JOINED    Error deleted, of this run                   JOINED     AskBody
    JOINED    there is no such body                        REMOVED    Print; nothing more until stop
    any       the mind leaves, or stop                     OVER       RequestLeave, Exit 0

While the agent asks for a new session it keeps answering with the old one, because the simulator may still know it.
Measures that arrive before the reply to a join are kept until it comes. Times are seconds of one monotonic clock.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from enum import Enum, auto
from typing import Final

from intellwheels_agents.harness_outputs import (
    AskBody,
    AskClock,
    Exit,
    Log,
    Output,
    Payload,
    Print,
    Publish,
    RequestLeave,
)
from intellwheels_agents.join_request import JoinRequest
from intellwheels_agents.mind import Context, Make
from intellwheels_agents.mind_error import USER_ERRORS, failed
from intellwheels_agents.mind_run import MindRun
from intellwheels_agents.options import Options
from intellwheels_agents.power_gate import PowerGate
from intellwheels_agents.tick_guard import TickGuard
from intellwheels_schemas.codec import Encoding, decode, encode
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Error, Joined, Leave, Map, Measures, Refused, Robot
from intellwheels_schemas.rules import joins_barrier

RETRY: Final = 1.0
"""Seconds between two attempts to join."""
TOKEN_RETRY: Final = 0.1
"""Seconds until the next attempt when our liveliness token has not reached the simulator yet."""

NAME_TAKEN: Final = 4
"""Exit code when another agent already has the name."""
PLACE_TAKEN: Final = 5
"""Exit code when another body is already at the place."""
_TAKEN: Final = {"already-here": NAME_TAKEN, "overlaps": PLACE_TAKEN}


class Phase(Enum):
    """The agent's relation to its simulator."""

    SEEKING = auto()
    ASKING = auto()
    JOINED = auto()
    REMOVED = auto()
    OVER = auto()


class Harness:
    """One agent's side of the contract.

    Attributes:
        phase: The current phase.
        deadline: When `wake` must be called, or None.
        missed: Ticks that never arrived, or arrived after a newer one.
        repeated: Ticks that were answered again because the simulator sent them again.
        errors: Received `Error` messages and messages that could not be decoded.
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
        reads: type[Measures] = Measures,
    ) -> None:
        """Prepare to join with `robot`, a document made by `robot_document.joining`.

        Args:
            robot: The document to join with; it has a name.
            make: Makes a mind for each run.
            options: The mind's options.
            encoding: The encoding of messages to the simulator, which answers in the same one.
            fetch_map: Asks the simulator for its map.
            simulator: Where the simulator is looked for, as text for messages.
            retry_for: Seconds to look for the simulator before giving up.
            reads: The class of what it gets each tick: in a crew, one with its name.
        """
        self.phase = Phase.SEEKING
        self.deadline: float | None = None
        self.missed = 0
        self.repeated = 0
        self.errors = 0
        self._agent, self._reads = robot.name or "", reads
        self._publishes_actions = robot.role != "body"
        self._awaited = joins_barrier(robot)
        self._request = JoinRequest(robot, encoding)
        self._make, self._options = make, dict(options or {})
        self._encoding = encoding
        self._fetch_map = fetch_map or _no_map
        self._simulator = simulator
        self._retry_for = retry_for
        self._error_counts: dict[str, int] = {}
        self._seeking_since = 0.0
        self._asked_at = -math.inf
        self._simulator_gone = False
        self._awaited_words = ""
        self._joined: Joined | None = None
        self._run = ""
        self._current: MindRun | None = None
        self._past_runs: set[str] = set()
        self._early: Payload | None = None
        self._guard = TickGuard()
        self._power_gate = PowerGate()
        self._deleted_text: str | None = None

    # ------------------------------------------------------------ joining

    def start(self, now: float) -> list[Output]:
        """Ask to join."""
        self._seeking_since = now
        return self._ask(now)

    def wake(self, now: float) -> list[Output]:
        """Do what was due at `deadline`; nothing before it."""
        if self.deadline is None or now < self.deadline:
            return []
        if self.phase is Phase.SEEKING:
            return self._ask(now)
        return self._over(1, self._nobody())

    def accepted(self, payload: Payload) -> list[Output]:
        """Handle the reply to a join."""
        if self.phase is not Phase.ASKING:
            return []
        try:
            joined = decode(Joined, *payload, strict=False)
        except WireError as error:
            return self._over(1, f"the reply to join cannot be read: {error.text}")
        self._power_gate.joined(joined)
        if again := self._request.again(self._power_gate.key):
            return again
        self.phase = Phase.JOINED
        self._simulator_gone = False
        self._awaited_words = ""
        same = self._joined is not None and (joined.run, joined.session) == (self._run, self._joined.session)
        self._joined = joined
        self._guard.begin(joined.run, joined.tick)
        outputs: list[Output] = [Print(f"joined agent={self._agent} run={joined.run} tick={joined.tick}")]
        if not same:
            self._begin(joined, joined.run)
        return outputs

    def refused(self, payload: Payload, now: float) -> list[Output]:
        """Handle the error reply to a join."""
        if self.phase is not Phase.ASKING:
            return []
        try:
            refused = decode(Refused, *payload, strict=False)
        except WireError as error:
            return self._over(1, f"the refusal of join cannot be read: {error.text}")
        text = f"refused ({refused.code}): {refused.text}"
        if refused.code not in self._request.transient:
            never_joined = self._joined is None
            return self._over(_TAKEN.get(refused.code, 1) if never_joined else 1, text)
        return self._retry_after(now, TOKEN_RETRY if refused.code == "no-token" else RETRY, text)

    def unanswered(self, now: float, denied: str = "") -> list[Output]:
        """Handle a join without an answer. `denied` says why the router did not let it through, if that is known."""
        if self.phase is not Phase.ASKING:
            return []
        return self._retry_after(now, RETRY, denied or self._nobody())

    def present(self, now: float) -> list[Output]:
        """Handle the appearance of a simulator."""
        if self.phase is Phase.SEEKING:
            return self._ask(now)
        if self.phase is Phase.JOINED and self._simulator_gone:
            self._seeking_since = now
            return self._ask(now)
        return []

    def absent(self, now: float) -> list[Output]:
        """Handle the disappearance of the simulator, or of the connection to it."""
        if self._simulator_gone or self.phase is Phase.OVER:
            return []
        self._simulator_gone = True
        if self.phase is Phase.JOINED and math.isfinite(self._retry_for):
            self.deadline = now + self._retry_for
        return [Log(f"lost simulator={self._simulator}")]

    def _ask(self, now: float) -> list[Output]:
        self.phase, self.deadline, self._asked_at = Phase.ASKING, None, now
        return [self._request.output]

    def _retry_after(self, now: float, pause: float, why: str) -> list[Output]:
        if now + pause - self._seeking_since > self._retry_for:
            return self._over(1, why)
        first, self._awaited_words = self._awaited_words != why, why
        self.phase, self.deadline = Phase.SEEKING, now + pause
        return [Log(f"waiting why={why!r}")] if first else []

    def _nobody(self) -> str:
        return f"no simulator at {self._simulator}, or not allowed"

    # ------------------------------------------------------------ each tick

    def measured_early(self, later: Sequence[Payload] = ()) -> list[Output]:
        """Handle the measures that came before the reply to the join, and those that came since, oldest first.

        Call it after the outputs of `accepted` are done: a mind may take long to be made, and to decide.
        """
        early, self._early = self._early, None
        return self.measured([early, *later] if early else later)

    def measured(self, payloads: Sequence[Payload]) -> list[Output]:
        """Handle `Measures`, oldest first: answer the newest, with the messages heard in all of them."""
        current = self._current
        if current is None:
            if payloads:
                self._early = payloads[-1]
            return []
        if len(payloads) == 1 and payloads[0][0] == current.payload:
            return self._repeat(current)
        outputs: list[Output] = []
        batch: list[Measures] = []
        newest_data = b""
        for payload in payloads:
            try:
                measures = decode(self._reads, *payload, strict=False)
            except WireError as error:
                self.errors += 1
                outputs.append(Log(f"dropped message=Measures why={error.text!r}"))
                continue
            if measures.run in self._past_runs:
                continue
            if measures.run != self._run and self.phase is Phase.ASKING:
                # The simulator was restarted, and the reply with our new session is on its way.
                self._early = payload
            elif self._guard.counts(measures, payload):
                batch.append(measures)
                newest_data = payload[0]
        if self._guard.asks():
            outputs.append(AskClock())
        if not batch:
            return outputs
        newest = batch[-1]
        if newest.tick <= current.tick:
            return outputs + (self._repeat(current) if newest.tick == current.tick else [])
        self.missed += current.missed_before(newest.tick)
        answer = current.answer(batch, newest_data)
        if answer.payload:
            outputs.append(Publish(answer.payload))
        return outputs + (self.stop() if answer.leaves else [])

    def clocked(self, payloads: Sequence[Payload]) -> list[Output]:
        """Handle the answers to a query for the clock; without one, the next measures ask again."""
        clock, confirmed, whys = self._guard.settle(payloads)
        self.errors += len(whys)
        worth = [why for why in whys if self._is_worth_a_line("measures")]
        outputs: list[Output] = [Log(f"dropped message=Measures why={why!r}") for why in worth]
        joined, current = self._joined, self._current
        if clock is None or joined is None or current is None or (clock.run != self._run and not confirmed):
            return outputs
        if clock.run != self._run:
            outputs.append(Print(f"run agent={self._agent} run={clock.run}"))
            self._begin(joined, clock.run)
            self._guard.begin(clock.run, clock.tick)
        elif self._guard.fooled:
            current.tick = min(current.tick, clock.tick - 1)
        return outputs + self.measured(confirmed)

    def _repeat(self, current: MindRun) -> list[Output]:
        self.repeated += 1
        return [Publish(current.last.payload)] if current.last.payload else []

    def _begin(self, joined: Joined, run: str) -> MindRun:
        """Make a new mind, for a new run or a new session."""
        if self._run and self._run != run:
            self._past_runs.add(self._run)
        self._run = run
        options = Options(self._options)
        context = Context(self._agent, joined.robot, joined.position, joined.parameters, options, self._fetch_map, run)
        try:
            mind = self._make(context)
        except USER_ERRORS:
            raise
        except Exception as error:
            raise failed(self._make, error) from error
        self._guard.begin(run, joined.tick if run == joined.run else 0)
        self._current = MindRun(
            mind,
            run=run,
            session=joined.session,
            encoding=self._encoding,
            say_limit=joined.parameters.say_limit,
            publishes_actions=self._publishes_actions,
            awaited=self._awaited,
            key=self._power_gate.key,
        )
        options.check_all_read()
        return self._current

    # ------------------------------------------------------------ errors, power, the end

    def erred(self, payload: Payload, now: float) -> list[Output]:
        """Handle an `Error` message. One about what only another process of this agent sends is not ours."""
        try:
            error = decode(Error, *payload, strict=False)
        except WireError as wrong:
            self.errors += 1
            return [Log(f"dropped message=Error why={wrong.text!r}")]
        if (error.where or "").partition(".")[0] == ("Pose" if self._publishes_actions else "Actions"):
            return []
        self.errors += 1
        if error.code == "deleted" and error.run == self._run and self._publishes_actions:
            asked, self._deleted_text = self._deleted_text is not None, error.text
            return [] if asked or self.phase in (Phase.REMOVED, Phase.OVER) else [AskBody()]
        if error.code in ("not-joined", "session") and self.phase is Phase.JOINED:
            self._seeking_since = now
            self.phase = Phase.SEEKING
            # An error that was sent before we joined must not make us join again and again.
            self.deadline = max(now, self._asked_at + RETRY)
        if not self._is_worth_a_line(error.code):
            return []
        count = self._error_counts[error.code]
        return [Log(f"erred code={error.code} count={count} tick={error.tick} text={error.text!r}")]

    def _is_worth_a_line(self, what: str) -> bool:
        """Count an error, and return whether it is the 1st, 10th, 100th and so on: not every tick may fill the log."""
        count = self._error_counts[what] = self._error_counts.get(what, 0) + 1
        return str(count).strip("0") == "1"

    def bodied(self, is_here: bool) -> list[Output]:
        """Handle the answer to a query for the agent's body, asked after an error said that it was deleted.

        Without it, stay away until somebody starts this program again: whoever deleted the body does not want it back.
        """
        text, self._deleted_text = self._deleted_text, None
        if text is None or self.phase in (Phase.REMOVED, Phase.OVER):
            return []
        if is_here:
            return [Log("dropped message=Error why='it says deleted, but the body is here'")]
        self.phase = Phase.REMOVED
        self.deadline = None
        self._current = None
        return [Print(f"removed agent={self._agent} reason=deleted"), Log(text or "deleted")]

    def powered(self, payload: Payload) -> list[Output]:
        """Handle the `Power` that a real chair must apply."""
        obey = getattr(self._current.mind, "obey", None) if self._current is not None else None
        found = self._power_gate.read(payload) if obey is not None else ""
        if obey is not None and not isinstance(found, str):
            obey(found)
        elif found:
            self.errors += 1
            return [Log(f"dropped message=Power why={found!r}")] if self._is_worth_a_line("power") else []
        return []

    def stop(self) -> list[Output]:
        """Leave the simulation and end."""
        if self.phase is Phase.OVER:
            return []
        if self._joined is None or self.phase is Phase.REMOVED:
            return self._over(0, "")
        leave = RequestLeave(encode(Leave(run=self._run, session=self._joined.session), self._encoding))
        counts = Log(f"counted missed={self.missed} repeated={self.repeated} errors={self.errors}")
        return [leave, counts, Print(f"left agent={self._agent}"), *self._over(0, "")]

    def _over(self, code: int, text: str) -> list[Output]:
        self.phase, self.deadline = Phase.OVER, None
        return [Exit(code, text)]


def _no_map() -> Map:
    raise RuntimeError("this harness cannot fetch a map")
