"""How late the commands of agents are, in runs that do not wait for answers. Pure.

A command that answers an earlier tick still counts for a short time, because an agent that needs longer than a tick to
answer could not drive otherwise. A newer command is never replaced by an older one.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from operator import attrgetter
from typing import Final

from intellwheels_schemas import defaults
from intellwheels_schemas.messages import Actions
from intellwheels_server.service.error_replies import Fault

_MOMENT: Final = attrgetter("tick", "seq")


def has_command(actions: Actions) -> bool:
    """Return whether actions command a motor. Others may come from another part of the program, and be newer."""
    return actions.left_motor is not None or actions.right_motor is not None


class CommandAges:
    """The ages of the commands of all agents in this run.

    Args:
        period: Simulated time of a tick, s.
    """

    def __init__(self, period: float) -> None:
        self._period = period
        # A sum of periods may be a little more than the time that is meant.
        self._limit = int(defaults.LATE_COMMAND / period + 1e-9)
        self._newest: dict[str, tuple[int, int | None]] = {}  # tick and number of the newest command of each agent
        self._counts: Counter[str] = Counter()
        self._ages: dict[str, int] = {}  # sum of the ages in ticks, of agents with late commands

    def check_late(self, agent: str, actions: Actions, run: str, tick: int) -> Fault | None:
        """Return what is wrong with actions that answer an earlier tick, or None if they still count.

        Args:
            agent: Who sent them.
            actions: The actions.
            run: The present run. Only actions that name it may be late.
            tick: The current tick.
        """
        where, limit = "Actions.Tick", tick - self._limit
        answered = tick if actions.tick is None else actions.tick
        if actions.run != run:
            return Fault("late", f"{where}: expected {tick}, or also a Run, got {answered}", where)
        if answered < limit:
            text = f"{where}: expected {limit} or later, at most {defaults.LATE_COMMAND:g} s late, got {answered}"
            return Fault("late", f"{text}; it was not used, because the mind or the machine is too slow", where)
        newest = self._newest.get(agent)
        if not has_command(actions) or newest is None or (answered, actions.seq or 0) > (newest[0], newest[1] or 0):
            return None
        if answered == newest[0] and actions.seq is None:
            return None
        return Fault("late", f"{where}: expected more than {newest[0]}, which has acted, got {answered}", where)

    def take(self, agent: str, actions: Actions, tick: int) -> None:
        """Note that actions with a command act on the step from a tick."""
        answered = tick if actions.tick is None else actions.tick
        newest = self._newest.get(agent)
        if newest is None or answered >= newest[0]:
            self._newest[agent] = answered, actions.seq
        self._counts[agent] += 1
        if tick != answered:
            self._ages[agent] = self._ages.get(agent, 0) + tick - answered

    def take_punctual(self, actions: Mapping[str, Actions]) -> None:
        """Note that actions with a command, one of each agent, act on the step from the tick that they answer.

        Each must have a tick, which must be the current one.
        """
        self._newest.update(zip(actions, map(_MOMENT, actions.values()), strict=True))
        self._counts.update(actions.keys())

    def means(self) -> dict[str, float]:
        """Return the mean age of the commands of each slow agent, s, rounded to 1e-6.

        An agent whose commands are late now and then is not slow: the mean is at least half a tick.
        """
        counts = self._counts
        return {
            agent: round(ages / counts[agent] * self._period, 6)
            for agent, ages in self._ages.items()
            if 2 * ages >= counts[agent]
        }

    def forget(self, agent: str) -> None:
        """Forget an agent whose body is gone."""
        for kept in (self._newest, self._counts, self._ages):
            kept.pop(agent, None)

    def clear(self) -> None:
        """Forget everything, for a new run."""
        self._newest.clear()
        self._counts.clear()
        self._ages.clear()
