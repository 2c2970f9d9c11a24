"""The lockstep barrier: whose answer to a tick is awaited, and for how long. Pure: time is passed in.

A barrier is opened for a tick, takes one answer of each kind from each member, and may close when none is
awaited. Strict: whoever misses the deadline ends the run. Elastic: a miss keeps the last command, the
third in a row puts the body to rest, and a body at rest is not waited for until it answers again.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final, Literal

from intellwheels_server.world.inputs import Verdict

AnswerKind = Literal["actions", "pose"]
Answer = tuple[str, AnswerKind]
"""An agent, and what of it is awaited."""

Reception = Literal["first", "same", "again"]
"""How an answer is taken: it counts; it came before to the byte; another came before."""

MISSES: Final = 3
"""Misses in a row that put a body to rest."""
FIRST_REPEAT: Final = 0.02
"""Seconds after which unanswered measures are put again, then twice as long, and so on: what drops is made good."""

STALL: Final = 0.25
"""Seconds after which a barrier that awaits somebody is shown as waiting."""


class Barrier:
    """Answers to one tick after the other.

    Args:
        strict: A miss ends the run; else it is made good.
        deadline: Wall time within which an answer must come, s.
    """

    def __init__(self, *, strict: bool, deadline: float) -> None:
        self.strict = strict
        self.deadline = deadline
        self._awaited: set[Answer] = set()
        self._answers: dict[Answer, bytes] = {}
        self._before: dict[Answer, bytes] = {}
        self._misses: dict[str, int] = {}
        self._rested: set[str] = set()
        self._verdicts: list[Verdict] = []
        self._idle = False
        self._opened = 0.0
        self._repeat_at = 0.0
        self._repeat_after = FIRST_REPEAT

    # ------------------------------------------------------------ one tick

    def open(self, answers: Iterable[Answer], now: float) -> None:
        """Await these answers; of bodies at rest they are taken, but not awaited."""
        self._before, self._answers = self._answers, {}
        rested = self._rested
        self._awaited = {answer for answer in answers if answer[0] not in rested} if rested else set(answers)
        self._idle = bool(rested) and not self._awaited
        self.rearm(now)

    def join(self, answers: Iterable[Answer]) -> None:
        """Await these too: their member came while the run was paused."""
        self._awaited.update(answer for answer in answers if answer not in self._answers)

    def rearm(self, now: float) -> None:
        """Count all times from now, after a pause."""
        self._opened = now
        self._repeat_after = FIRST_REPEAT
        self._repeat_at = now + FIRST_REPEAT

    def answer(self, agent: str, kind: AnswerKind, data: bytes) -> Reception:
        """Take a member's answer to the open tick and return how it was taken."""
        key = (agent, kind)
        earlier = self._answers.get(key)
        if earlier is not None:
            return "same" if earlier == data else "again"
        self._answers[key] = data
        self._awaited.discard(key)
        if agent in self._rested:
            self.revive(agent)
        elif self._misses:
            self._misses.pop(agent, None)
        return "first"

    def repeats(self, agent: str, kind: AnswerKind, data: bytes) -> bool:
        """Return whether these very bytes are the answer to this tick already: measures were put twice."""
        return self._answers.get((agent, kind)) == data

    def repeats_late(self, agent: str, kind: AnswerKind, data: bytes) -> bool:
        """Return whether a late message is, to the byte, the last answer that counted: measures were put twice.

        Of messages that name no tick this must not be asked: equal bytes are then the answer to one tick after
        the other.
        """
        key = (agent, kind)
        return self._answers.get(key) == data or self._before.get(key) == data

    def revive(self, agent: str) -> None:
        """Note that a body at rest has answered, to whatever tick: it is awaited again from the next on."""
        if agent in self._rested:
            self._rested.discard(agent)
            self._misses.pop(agent, None)
            self._verdicts.append(Verdict(agent=agent, code="back"))

    def complete(self, now: float) -> bool:
        """Return whether nothing is awaited.

        When all members are at rest, a tick takes the deadline or until one of them answers: a run does not
        race away from those that may come back.
        """
        if self._awaited:
            return False
        return not self._idle or bool(self._answers) or now >= self._opened + self.deadline

    def stalled(self, now: float) -> bool:
        """Return whether an answer has been awaited for longer than a person would call at once."""
        return (bool(self._awaited) or self._idle) and now >= self._opened + STALL

    @property
    def awaited(self) -> tuple[str, ...]:
        """The names of those whose answer is missing, sorted."""
        return tuple(sorted({agent for agent, _ in self._awaited}))

    @property
    def rested(self) -> frozenset[str]:
        """The bodies at rest."""
        return frozenset(self._rested)

    # ------------------------------------------------------------ members that go

    def excuse(self, agent: str, kind: AnswerKind) -> None:
        """Await this answer no more in this tick: its member has left."""
        self._awaited.discard((agent, kind))

    def renew(self, agent: str) -> None:
        """Begin anew with an agent that joins in a body which stays: without misses, and no longer at rest."""
        self.revive(agent)
        self._misses.pop(agent, None)

    def forget(self, agent: str) -> None:
        """Forget misses and rest of an agent whose body is gone."""
        self._misses.pop(agent, None)
        self._rested.discard(agent)

    def begin_new_run(self, rested: Iterable[str] = ()) -> None:
        """Forget everything: a new run awaits all but those at rest in it."""
        self._awaited.clear()
        self._answers, self._before = {}, {}
        self._idle = False
        self._misses.clear()
        self._rested = set(rested)
        self._verdicts.clear()

    # ------------------------------------------------------------ time

    def due(self) -> float:
        """Return when something must be done about what is awaited, in the caller's seconds."""
        if self._awaited:
            return min(self._repeat_at, self._opened + self.deadline)
        return self._opened + self.deadline if self._idle else float("inf")

    def to_repeat(self, now: float) -> tuple[str, ...]:
        """Return whose measures must be put again now, sorted; usually nobody's."""
        if now < self._repeat_at or not self._awaited:
            return ()
        self._repeat_after *= 2.0
        self._repeat_at = now + self._repeat_after
        return self.awaited

    def missed(self, now: float) -> tuple[Answer, ...]:
        """Return what missed the deadline, sorted; with `strict` the run is over, else it is awaited no more."""
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
        """Return what was found since the last call, in order."""
        found, self._verdicts = self._verdicts, []
        return found
