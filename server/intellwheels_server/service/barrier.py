"""The lockstep barrier: which answers to a tick are still missing, and how long to wait. Pure: time is passed in.

A barrier opens for a tick, takes one answer of each kind from each member, and is complete when none is missing.
Strict: a missed deadline ends the run. Elastic: after a miss the last command stays in force; after the third miss in
a row the body is put to rest, and the barrier does not wait for it until it answers again.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final, Literal

from intellwheels_schemas.file_records import Verdict
from intellwheels_schemas.messages import Actions

AnswerKind = Literal["actions", "pose"]
Answer = tuple[str, AnswerKind]
"""An agent, and the kind of message expected of it."""

Answered = bytes | Actions
"""An answer, to be compared with a second one to the same tick: its bytes, or the actions of an agent of a crew."""

AnswerResult = Literal["first", "duplicate", "conflict"]
"""Kinds of answer: the first one, which counts; the same bytes again; other bytes after the first one."""

MISSES: Final = 3
"""Misses in a row that put a body to rest."""
FIRST_REPEAT: Final = 0.02
"""Seconds after which unanswered measures are sent again; the time doubles with each repetition."""

STALL: Final = 0.25
"""Seconds after which the clock shows an incomplete barrier as waiting."""


class Barrier:
    """The answers to one tick after the other.

    Args:
        strict: Whether a miss ends the run.
        deadline: Wall time within which an answer must come, s.
    """

    def __init__(self, *, strict: bool, deadline: float) -> None:
        self.strict = strict
        self.deadline = deadline
        self._awaited: set[Answer] = set()
        self._answers: dict[Answer, Answered] = {}
        self._before: dict[Answer, Answered] = {}
        self._misses: dict[str, int] = {}
        self._rested: set[str] = set()
        self._verdicts: list[Verdict] = []
        self._idle = False
        self._opened = 0.0
        self._repeat_at = 0.0
        self._repeat_after = FIRST_REPEAT

    # ------------------------------------------------------------ one tick

    def open(self, answers: Iterable[Answer], now: float) -> None:
        """Expect these answers. Bodies at rest may answer, but the barrier does not wait for them."""
        self._before, self._answers = self._answers, {}
        rested = self._rested
        self._awaited = {answer for answer in answers if answer[0] not in rested} if rested else set(answers)
        self._idle = bool(rested) and not self._awaited
        self.restart_timers(now)

    def add(self, answers: Iterable[Answer]) -> None:
        """Expect these answers too: their member joined while the barrier was open."""
        self._awaited.update(answer for answer in answers if answer not in self._answers)

    def restart_timers(self, now: float) -> None:
        """Measure all times from now, after a pause."""
        self._opened = now
        self._repeat_after = FIRST_REPEAT
        self._repeat_at = now + FIRST_REPEAT

    def answer(self, agent: str, kind: AnswerKind, data: Answered) -> AnswerResult:
        """Take a member's answer to the open tick and return whether it is the first one."""
        key = (agent, kind)
        earlier = self._answers.get(key)
        if earlier is not None:
            return "duplicate" if earlier == data else "conflict"
        self._answers[key] = data
        self._awaited.discard(key)
        if agent in self._rested:
            self.revive(agent)
        elif self._misses:
            self._misses.pop(agent, None)
        return "first"

    def repeats(self, agent: str, kind: AnswerKind, data: Answered) -> bool:
        """Return whether the answer to this tick has exactly these bytes: the agent got its measures twice."""
        return self._answers.get((agent, kind)) == data

    def repeats_late(self, agent: str, kind: AnswerKind, data: Answered) -> bool:
        """Return whether a late message repeats the last answer that counted: the agent got its measures twice.

        Not for messages without a tick: there, equal bytes may be the answers to successive ticks.
        """
        key = (agent, kind)
        return self._answers.get(key) == data or self._before.get(key) == data

    def revive(self, agent: str) -> None:
        """Note that a body at rest has answered, to any tick. From the next tick on the barrier waits for it."""
        if agent in self._rested:
            self._rested.discard(agent)
            self._misses.pop(agent, None)
            self._verdicts.append(Verdict(agent=agent, code="back"))

    def complete(self, now: float) -> bool:
        """Return whether no answer is missing.

        When all members are at rest, a tick lasts until one of them answers or the deadline passes, so that the run
        does not race ahead of members that may come back.
        """
        if self._awaited:
            return False
        return not self._idle or bool(self._answers) or now >= self._opened + self.deadline

    def stalled(self, now: float) -> bool:
        """Return whether an answer has been missing for so long that the clock shows it."""
        return (bool(self._awaited) or self._idle) and now >= self._opened + STALL

    @property
    def awaited(self) -> tuple[str, ...]:
        """The agents whose answer is missing, sorted."""
        return tuple(sorted({agent for agent, _ in self._awaited}))

    # ------------------------------------------------------------ members that come and go

    def cancel(self, agent: str, kind: AnswerKind) -> None:
        """Do not wait for this answer in this tick: its member has left."""
        self._awaited.discard((agent, kind))

    def reset_member(self, agent: str) -> None:
        """Forget the misses and rest of an agent whose body gets a new mind or bridge."""
        self.revive(agent)
        self._misses.pop(agent, None)

    def forget(self, agent: str) -> None:
        """Forget an agent whose body is gone."""
        self._misses.pop(agent, None)
        self._rested.discard(agent)

    def begin_new_run(self, rested: Iterable[str] = ()) -> None:
        """Forget everything except the bodies at rest, which are those of the new run."""
        self._awaited.clear()
        self._answers, self._before = {}, {}
        self._idle = False
        self._misses.clear()
        self._rested = set(rested)
        self._verdicts.clear()

    # ------------------------------------------------------------ time

    def due(self) -> float:
        """Return when measures must be sent again or the deadline passes."""
        if self._awaited:
            return min(self._repeat_at, self._opened + self.deadline)
        return self._opened + self.deadline if self._idle else float("inf")

    def to_repeat(self, now: float) -> tuple[str, ...]:
        """Return the agents whose measures must be sent again now, sorted; usually none."""
        if now < self._repeat_at or not self._awaited:
            return ()
        self._repeat_after *= 2.0
        self._repeat_at = now + self._repeat_after
        return self.awaited

    def missed(self, now: float) -> tuple[Answer, ...]:
        """Return the answers that missed the deadline, sorted. If not strict, the barrier stops waiting for them."""
        if not self._awaited or now < self._opened + self.deadline:
            return ()
        missing = tuple(sorted(self._awaited))
        if self.strict:
            return missing
        self._awaited.clear()
        for agent in sorted({agent for agent, _ in missing}):
            misses = self._misses.get(agent, 0) + 1
            self._misses[agent] = misses
            self._verdicts.append(Verdict(agent=agent, code="late"))
            if misses >= MISSES:
                self._rested.add(agent)
                self._verdicts.append(Verdict(agent=agent, code="rested"))
        return missing

    def verdicts(self) -> list[Verdict]:
        """Return the verdicts since the last call, in order."""
        found, self._verdicts = self._verdicts, []
        return found
