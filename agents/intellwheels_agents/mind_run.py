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
from intellwheels_schemas.codec import Encoding, encode
from intellwheels_schemas.messages import TEXT_PATTERN, Actions, Measures, Pose

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
            ValueError: The mind returned a power that is not a number, or text with control characters.
        """
        measures = batch[-1] if len(batch) == 1 else self._merged(batch)
        self.tick = measures.tick
        self.payload = payload
        self.last = Answer(b"")
        self.last = self._encoded(self.mind.decide(measures), measures.tick)
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
            return Answer(encode(pose, self._encoding))
        if decision is None or not self._publishes_actions:
            # The mind of a simulated body is another process, and the simulator waits for that one's actions.
            return Answer(b"")
        if decision == _NOTHING and not self._awaited:
            # Nobody waits for it, so it could only arrive late.
            return Answer(b"")
        left, right, say = decision.left_motor, decision.right_motor, decision.say
        actions = Actions(
            run=self.run,
            session=self._session,
            tick=tick,
            seq=seq,
            left_motor=left if left is None or -1.0 <= left <= 1.0 else _clamped(left),
            right_motor=right if right is None or -1.0 <= right <= 1.0 else _clamped(right),
            mode=decision.mode,
            leave=decision.leave,
            goal=decision.goal,
            say=say if say is None else self._shortened(say),
        )
        return Answer(encode(actions, self._encoding), leaves=decision.leave)

    def _shortened(self, text: str) -> str:
        if _TEXT.match(text) is None:
            raise ValueError(f"say: expected text without control characters, got {text!r}")
        return text[: self._say_limit]


def _clamped(power: float) -> float:
    if math.isnan(power):
        raise ValueError("a mind's power: expected a number, got nan")
    return 1.0 if power > 0.0 else -1.0
