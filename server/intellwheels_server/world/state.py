"""The state of a world: arrays with a column for each body, and the few things that are not numbers.

A state never changes; a step makes a new one. What is fixed while the set of bodies stays the same (shapes, motors,
sensors) is compiled once, in `body_set`, and shared by all states of that time. A changed copy is made with
`msgspec.structs.replace`, so that fields which are not named keep their values.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec
import numpy as np

from intellwheels_schemas import defaults
from intellwheels_schemas.messages import End, Goal, Map, Sensors, UserInput
from intellwheels_server.world.kernels.arrays import Floats, Ints, Walls

if TYPE_CHECKING:
    from intellwheels_server.world.body_set import BodySet


class Setup(msgspec.Struct, frozen=True, kw_only=True):
    """The setup of a world: everything but its bodies.

    Attributes:
        floor: The map.
        seed: Any text; all noise follows from it.
        period: Simulated time of a tick, s.
        say_limit: Code points of one message that an agent says.
        say_range: Distance up to which it is heard, m.
        say_walls: Whether walls and door leaves between speaker and listener keep it from being heard.
        say_loss: Share of messages that a listener misses, in [0, 1]; each message and listener is drawn separately.
        say_delay: Time it takes beyond the next tick, s; rounded up to whole ticks.
        command_timeout: Time after which a command no longer counts, s; a robot may set its own.
        truth: Whether agents may have truth sensors.
        end: When the run ends; None for never.
        strict: Whether the world finds silent users and stale poses of real bodies itself, in simulated time;
            otherwise the service, which has a clock, reports them as verdicts.
    """

    floor: Map
    seed: str = defaults.SEED
    period: float = defaults.PERIOD
    say_limit: int = defaults.SAY_LIMIT
    say_range: float = defaults.SAY_RANGE
    say_walls: bool = defaults.SAY_WALLS
    say_loss: float = defaults.SAY_LOSS
    say_delay: float = defaults.SAY_DELAY
    command_timeout: float = defaults.COMMAND_TIMEOUT
    truth: bool = False
    end: End | None = None
    strict: bool = False


class BodyStatus(msgspec.Struct, frozen=True):
    """The status that an agent reports, and its last message, which is shown for a while after `say_tick`."""

    mode: str | None = None
    goal: Goal | None = None
    say: str | None = None
    say_tick: int = 0


class Utterance(msgspec.Struct, frozen=True):
    """A message that an agent or an operator said.

    Attributes:
        sender: The agent, or the operator.
        text: The message.
        tick: The tick at which it was said.
        seq: Its sequence number, if the sender gave one.
        to: The only agent that hears it; None for all in range.
        at: Position of the speaker after the step, m, so that an agent is heard even if it leaves; None for an
            operator, who is heard everywhere.
        due: The tick whose measures carry it.
    """

    sender: str
    text: str
    tick: int
    seq: int | None = None
    to: str | None = None
    at: tuple[float, float] | None = None
    due: int = 0


class SavedState(msgspec.Struct, frozen=True):
    """A state saved under a name. It holds no saved states itself."""

    slot: str
    state: State


class State(msgspec.Struct, frozen=True, kw_only=True):
    """A world at a tick.

    Attributes:
        run: The name of the run, in everything that is published; not part of the hash.
        tick: Steps since the run began.
        setup: The map, the seed and the rules.
        walls: The walls of the map, for the kernels.
        body_set: The bodies, compiled; `body_set.names` is sorted.
        numbers: float64[NUMBER_ROWS, n].
        flags: int64[FLAG_ROWS, n].
        samples: float64, the sensors' stored samples, laid out by the body set.
        episodes: int64[e, 3], the contacts that have not ended.
        statuses: The status of each agent, by name.
        user: The last input of each body's user, by name.
        forwarded: The last readings of each real body's own sensors, by name.
        heard: Messages that are heard at this tick.
        coming: Messages of agents that are heard later.
        spoken: Messages of operators at this tick, which are heard at the next.
        event_count: Events of this run so far, which is the number of the next one.
        revision: How often the map was changed.
        ended: Whether the end condition is met; then no step may follow.
        end_waived: Whether the end condition no longer counts.
        saved: The saved states, the oldest first; not part of the hash.
    """

    run: str
    tick: int
    setup: Setup
    walls: Walls
    body_set: BodySet
    numbers: Floats
    flags: Ints
    samples: Floats
    episodes: Ints
    statuses: dict[str, BodyStatus] = {}
    user: dict[str, UserInput] = {}
    forwarded: dict[str, Sensors] = {}
    heard: tuple[Utterance, ...] = ()
    coming: tuple[Utterance, ...] = ()
    spoken: tuple[Utterance, ...] = ()
    event_count: int = 0
    revision: int = 0
    ended: bool = False
    end_waived: bool = False
    saved: tuple[SavedState, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """The bodies' names, sorted: the order of every array's columns."""
        return self.body_set.names

    @property
    def time(self) -> float:
        """Simulated time, s."""
        return self.tick * self.setup.period

    @property
    def shown_time(self) -> float:
        """Simulated time as messages show it, s: rounded to 1e-6."""
        return round(self.tick * self.setup.period, 6)


def no_episodes() -> Ints:
    """Return the episodes of a world in which nothing touches."""
    return np.empty((0, 3), dtype=np.int64)
