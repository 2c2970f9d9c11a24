"""One mind in one run of the simulation: `Measures` in, encoded answers out. No I/O.

The harness makes a new one for each run and each session, so a mind never has to reset itself.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import NamedTuple

import msgspec

from intellwheels_agents.mind import Bridge, Mind
from intellwheels_agents.mind_error import USER_ERRORS, failed, wrong_answer
from intellwheels_schemas.codec import Encoding, encode
from intellwheels_schemas.messages import TEXT_PATTERN, Actions, Measures, Pose
from intellwheels_schemas.metal_codes import code_of, pose_line

_NOTHING = Actions()
_TEXT = re.compile(TEXT_PATTERN)


class Answer(NamedTuple):
    """The answer of a mind.

    Attributes:
        payload: The encoded `Actions` or `Pose`; empty if nothing is to be sent.
        leaves: Whether the mind leaves the simulation with it.
    """

    payload: bytes
    leaves: bool = False


class MindRun:
    """A mind, with the last measures that it got and its last answer.

    Attributes:
        mind: The mind or bridge.
        run: The run it belongs to.
        tick: The tick that was answered last; -1 before the first.
        payload: The bytes of the measures that were answered last.
        last: The answer to them.
    """

    def __init__(
        self,
        mind: Mind | Bridge,
        *,
        run: str,
        session: str,
        encoding: Encoding,
        say_limit: int,
        publishes_actions: bool,
        awaited: bool,
        key: str | None = None,
    ) -> None:
        """Start at the first tick of a run.

        Args:
            mind: The mind or bridge that decides.
            run: The run.
            session: The agent's session with the simulator.
            encoding: The encoding of the answers.
            say_limit: The most characters of a message between agents.
            publishes_actions: False for the role `body`: its actions come from another process.
            awaited: Whether a lockstep waits for this agent, so that even empty actions must be sent.
            key: Makes the codes of poses, for the bridge of a real robot.
        """
        self.mind = mind
        self.run = run
        self.tick = -1
        self.payload = b""
        self.last = Answer(b"")
        self._session = session
        self._encoding = encoding
        self._say_limit = say_limit
        self._publishes_actions = publishes_actions
        self._awaited = awaited
        self._key = key
        self._seq = 0

    def missed_before(self, tick: int) -> int:
        """Return how many ticks were skipped between the last answered tick and `tick`."""
        return tick - self.tick - 1 if self.tick >= 0 and tick > self.tick else 0

    def answer(self, batch: Sequence[Measures], payload: bytes) -> Answer:
        """Ask the mind about the newest measures and return its answer.

        Args:
            batch: Decoded measures, oldest first. Messages heard in the older ones are kept.
            payload: The bytes of the newest.

        Raises:
            MindError: The mind raised an exception, or returned something else than actions that can be sent.
        """
        measures = batch[-1] if len(batch) == 1 else self._merged(batch)
        self.tick = measures.tick
        self.payload = payload
        self.last = Answer(b"")
        try:
            decision = self.mind.decide(measures)
        except USER_ERRORS:
            raise
        except Exception as error:
            raise failed(self.mind, error) from error
        self.last = self._encoded(decision, measures.tick)
        return self.last

    def _merged(self, batch: Sequence[Measures]) -> Measures:
        newest = batch[-1]
        heard = tuple(
            message
            for measures in batch
            if measures.run == newest.run and measures.tick > self.tick
            for message in measures.message
        )
        return msgspec.structs.replace(newest, message=heard)

    def _encoded(self, decision: Actions | Pose | None, tick: int) -> Answer:
        seq = self._seq
        self._seq += 1
        if isinstance(decision, Pose):
            pose = msgspec.structs.replace(decision, run=self.run, session=self._session, tick=tick, seq=seq)
            if self._key is not None:
                pose = msgspec.structs.replace(pose, code=code_of(self._key, pose_line(pose)))
            return Answer(encode(pose, self._encoding))
        if decision is not None and not isinstance(decision, Actions):
            raise wrong_answer(self.mind, "Actions", decision)
        if decision is None and self._publishes_actions:
            raise wrong_answer(self.mind, "Actions", None)
        if decision is None or not self._publishes_actions:
            # The mind of a simulated body is another process, and the simulator waits for that one's actions.
            return Answer(b"")
        if decision == _NOTHING and not self._awaited:
            # Nobody waits for it, so it could only arrive late.
            return Answer(b"")
        say = decision.say
        actions = Actions(
            run=self.run,
            session=self._session,
            tick=tick,
            seq=seq,
            left_motor=self._power("left_motor", decision.left_motor),
            right_motor=self._power("right_motor", decision.right_motor),
            mode=decision.mode,
            leave=decision.leave,
            goal=decision.goal,
            say=say if say is None else self._shortened(say),
        )
        try:
            return Answer(encode(actions, self._encoding), leaves=decision.leave)
        except (TypeError, ValueError) as error:
            raise wrong_answer(self.mind, f"Actions that can be sent ({error})", decision) from error

    def _power(self, field: str, power: float | None) -> float | None:
        """Return a power in [-1, 1]; numbers of other libraries, such as numpy's, become plain ones."""
        if power is None:
            return None
        try:
            value = float(power)
        except (TypeError, ValueError):
            value = math.nan
        if math.isnan(value) or isinstance(power, str):
            raise wrong_answer(self.mind, f"a number for {field}", power)
        return min(max(value, -1.0), 1.0)

    def _shortened(self, text: str) -> str:
        if not isinstance(text, str):
            raise wrong_answer(self.mind, "text for say", text)
        if _TEXT.match(text) is None:
            raise wrong_answer(self.mind, "text without control characters for say", text)
        return text[: self._say_limit]
