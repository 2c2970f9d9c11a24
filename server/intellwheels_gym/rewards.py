"""What a step is worth, and when an episode ends. Both have names, and functions of your own may replace them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple, TypeAlias

from intellwheels_schemas.explain import did_you_mean


class Step(NamedTuple):
    """A step of a learner, by the true state of the world.

    Attributes:
        before: Distance to the goal before the step, m.
        after: Distance after it, m.
        reached: Whether the goal is reached.
        contacts: Contacts that began in this step.
        seconds: Simulated time of the step, s.
        time: Simulated time since the episode began, s.
        limit: Length of an episode, s.
        powers: The motor powers of the step, left and right, each in [-1, 1].
    """

    before: float
    after: float
    reached: bool
    contacts: int
    seconds: float
    time: float
    limit: float
    powers: tuple[float, float]


Reward: TypeAlias = Callable[[Step], float]


@dataclass(frozen=True)
class End:
    """A reason for an episode to end.

    Attributes:
        name: Its name, in `info["end"]`.
        met: Whether a step ends the episode.
        truncates: Whether the episode is cut off (`truncated`); otherwise it is over (`terminated`).
    """

    name: str
    met: Callable[[Step], bool]
    truncates: bool = False


REWARDS: Final[Mapping[str, Reward]] = {
    "progress": lambda step: step.before - step.after,
    "reached": lambda step: float(step.reached),
    "contact": lambda step: -float(step.contacts),
    "time": lambda step: -step.seconds,
}
"""The rewards: metres nearer to the goal, 1 at the goal, -1 for each contact, minus the time in s."""

ENDS: Final[Mapping[str, End]] = {
    "reached": End("reached", lambda step: step.reached),
    "contact": End("contact", lambda step: step.contacts > 0),
    # A tick's time may be slightly below the decimal number.
    "timeout": End("timeout", lambda step: step.time >= step.limit - 1e-9, truncates=True),
}
"""The ends: the goal is reached, something is touched, the time is over."""

DEFAULT_REWARD: Final[Mapping[str, float]] = {"progress": 1.0, "reached": 10.0, "contact": 10.0, "time": 0.1}
DEFAULT_ENDS: Final = ("reached", "contact", "timeout")


def reward_of(given: str | Reward | Mapping[str, float]) -> Reward:
    """Return a reward.

    Args:
        given: A name of `REWARDS`, a function, or weights by name, whose weighted rewards are added.

    Raises:
        ValueError: There is no such reward, or a weight is not a finite number.
        TypeError: It is none of these.
    """
    if isinstance(given, str):
        return _named(given)
    if isinstance(given, Mapping):
        parts = []
        for name, weight in given.items():
            if isinstance(weight, bool) or not isinstance(weight, (int, float)) or not math.isfinite(weight):
                raise ValueError(f"reward: expected a finite number as the weight of {name!r}, got {weight!r}")
            parts.append((float(weight), _named(name)))
        return lambda step: sum(weight * part(step) for weight, part in parts)
    if not callable(given):
        raise TypeError(f"reward: expected a name, a function or weights by name, got {given!r}")
    return given


def _named(name: str) -> Reward:
    if name not in REWARDS:
        known = ", ".join(REWARDS)
        raise ValueError(f"reward: expected one of {known} or a function, got {name!r}{did_you_mean(name, REWARDS)}")
    return REWARDS[name]


def ends_of(given: Sequence[str | End]) -> tuple[End, ...]:
    """Return ends, each given by a name of `ENDS` or as an `End`.

    Raises:
        ValueError: There is no such end.
        TypeError: It is no list.
    """
    if isinstance(given, str) or not isinstance(given, Sequence):
        raise TypeError(f"ends: expected a list of names or ends, got {given!r}")
    found = []
    for one in given:
        end = ENDS.get(one) if isinstance(one, str) else one
        if not isinstance(end, End):
            hint = did_you_mean(one, ENDS) if isinstance(one, str) else ""
            raise ValueError(f"ends: expected one of {', '.join(ENDS)} or an End, got {one!r}{hint}")  # noqa: TRY004 - or a wrong name
        found.append(end)
    return tuple(found)
