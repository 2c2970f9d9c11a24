"""The state of a world: arrays with a column for each body, and the few things that are not numbers.

A state is never changed: a step makes a new one. What is fixed while the set of bodies stays the
same (shapes, motors, sensors) is compiled once, in `body_set`, and shared by all states of that time.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec
import numpy as np

from intellwheels_schemas.messages import End, Goal, Map, Sensors, UserInput
from intellwheels_server.world.kernels.arrays import Floats, Ints, Walls

if TYPE_CHECKING:
    from intellwheels_server.world.body_set import BodySet


class Setup(msgspec.Struct, frozen=True, kw_only=True):
    """What a world is made of besides its bodies.

    Attributes:
        floor: The map.
        seed: Any text; all noise follows from it.
        period: Simulated time of a tick, s.
        say_limit: Code points of one say.
        say_range: How far a say is heard, m.
        say_walls: Walls and door leaves between speaker and listener keep what agents say from being heard.
        say_loss: Share of what agents say that a listener misses, each on its own.
        say_delay: Time after which what agents say is heard, beyond the next tick, s; whole ticks, rounded up.
        command_timeout: Time after which a command no longer counts, s; a robot may ask for its own.
        truth: Whether agents may have truth sensors.
        end: When the run ends, or never.
        strict: Silence of users and of real bodies' poses is counted in simulated time, by the world; otherwise
            it comes as verdicts of the pace keeper.
    """

    floor: Map
    seed: str = "1"
    period: float = 0.05
    say_limit: int = 100
    say_range: float = 8.0
    say_walls: bool = False
    say_loss: float = 0.0
    say_delay: float = 0.0
    command_timeout: float = 0.5
    truth: bool = False
    end: End | None = None
    strict: bool = False


class BodyStatus(msgspec.Struct, frozen=True):
    """What an agent says of itself. The say is shown for a while, so it carries its tick."""

    mode: str | None = None
    goal: Goal | None = None
    say: str | None = None
    say_tick: int = 0


class Utterance(msgspec.Struct, frozen=True):
    """Words that somebody said; `to` one agent or to all in range.

    `at` is where the speaker was after the step they were said in, m, so that who leaves is still heard; without a
    place the sender is an operator, heard everywhere. `due` is the tick in whose measures they are heard.
    """

    sender: str
    text: str
    tick: int
    seq: int | None = None
    to: str | None = None
    at: tuple[float, float] | None = None
    due: int = 0


class KeptStart(msgspec.Struct, frozen=True):
    """A state that was saved under a name; it holds no saved states itself."""

    slot: str
    state: State


class State(msgspec.Struct, frozen=True, kw_only=True):
    """A world at a tick.

    Attributes:
        run: Name of the run, on all that is published; no part of the hash.
        tick: Steps since the run began.
        setup: The floor, the seed and the rules.
        walls: The floor's walls, for the kernels.
        body_set: What is compiled for the bodies that are here; `body_set.names` is sorted.
        numbers: float64[NUMBER_ROWS, n].
        flags: int64[FLAG_ROWS, n].
        samples: float64, the sensors' stored samples, laid out by the body set.
        episodes: int64[e, 3], contacts that go on.
        manners: What agents say of themselves, by name.
        user: The last input of each body's user, by name.
        forwarded: The last readings of each real body's own sensors, by name.
        heard: What is heard at this tick.
        coming: What agents said and is heard later.
        spoken: What operators said at this tick; heard at the next.
        event_count: Events of this run so far; the next event's number.
        revision: How often the map was changed.
        ended: Whether the end condition is met; no further step then.
        end_waived: The end condition no longer counts.
        kept: States that were saved, the oldest first; no part of the hash.
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
    manners: dict[str, BodyStatus] = {}
    user: dict[str, UserInput] = {}
    forwarded: dict[str, Sensors] = {}
    heard: tuple[Utterance, ...] = ()
    coming: tuple[Utterance, ...] = ()
    spoken: tuple[Utterance, ...] = ()
    event_count: int = 0
    revision: int = 0
    ended: bool = False
    end_waived: bool = False
    kept: tuple[KeptStart, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """The bodies' names, sorted: the order of every array's columns."""
        return self.body_set.names

    @property
    def time(self) -> float:
        """Simulated time, s."""
        return self.tick * self.setup.period


def no_episodes() -> Ints:
    """Return the contacts of a world in which nothing touches."""
    return np.empty((0, 3), dtype=np.int64)
