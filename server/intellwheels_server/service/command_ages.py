"""How late the commands of agents are, in runs that do not wait for answers. Pure.

A command that answers an earlier tick still counts for a short time, because an agent that needs longer than a tick to
answer could not drive otherwise. A newer command is never replaced by an older one.
"""

from __future__ import annotations

from dataclasses import dataclass

from intellwheels_schemas import defaults
from intellwheels_schemas.messages import Actions
from intellwheels_server.service.error_replies import Fault


@dataclass(slots=True)
class _Commands:
    """The commands of an agent: the tick and number of the newest, their count, and the sum of their ages in ticks."""

    tick: int = -1
    seq: int | None = None
    count: int = 0
    ages: int = 0


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
        self._of: dict[str, _Commands] = {}
        self._late: set[str] = set()

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
        newest = self._of.get(agent)
        if not has_command(actions) or newest is None or (answered, actions.seq or 0) > (newest.tick, newest.seq or 0):
            return None
        if answered == newest.tick and actions.seq is None:
            return None
        return Fault("late", f"{where}: expected more than {newest.tick}, which has acted, got {answered}", where)

    def take(self, agent: str, actions: Actions, tick: int) -> None:
        """Note that actions with a command act on the step from a tick."""
        commands = self._of.setdefault(agent, _Commands())
        answered = tick if actions.tick is None else actions.tick
        if answered >= commands.tick:
            commands.tick, commands.seq = answered, actions.seq
        commands.count += 1
        if tick != answered:
            commands.ages += tick - answered
            self._late.add(agent)

    def means(self) -> dict[str, float]:
        """Return the mean age of the commands of each slow agent, s, rounded to 1e-6.

        An agent whose commands are late now and then is not slow: the mean is at least half a tick.
        """
        late = ((agent, self._of[agent]) for agent in self._late)
        return {
            agent: round(commands.ages / commands.count * self._period, 6)
            for agent, commands in late
            if 2 * commands.ages >= commands.count
        }

    def forget(self, agent: str) -> None:
        """Forget an agent whose body is gone."""
        self._of.pop(agent, None)
        self._late.discard(agent)

    def clear(self) -> None:
        """Forget everything, for a new run."""
        self._of.clear()
        self._late.clear()
