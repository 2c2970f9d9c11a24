"""The rows of an experiment: each combination of its levels, as a scene of its own. Pure: a scene in, scenes out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from typing import Final

import msgspec

from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Bridge, Cast, Level, Option, Scene, Setting

RULES: Final[Mapping[str, str]] = {
    "SayRange": "--say-range",
    "SayLoss": "--say-loss",
    "SayDelay": "--say-delay",
    "SayLimit": "--say-limit",
    "CommandTimeout": "--command-timeout",
    "Period": "--period",
}
"""What a setting without an agent may name, and how the simulator is told."""


@dataclass(frozen=True, slots=True)
class Row:
    """A combination of levels.

    Attributes:
        name: Their names with `+` between; of a scene without factors, the scene's.
        title: Their titles.
        real: Whether its chair stands for one of hardware.
        scene: With the cast of this row.
        bridges: Those of the cast whose bodies are chairs of a laboratory, by name.
        words: Further words for the simulator.
    """

    name: str
    title: str
    real: bool
    scene: Scene
    words: tuple[str, ...]
    bridges: Mapping[str, Bridge]


def rows_of(scene: Scene) -> tuple[Row, ...]:
    """Return the rows of a scene, the last factor varied first.

    Raises:
        WireError: A setting names no rule of the simulation.
    """
    if scene.experiment is None or not scene.experiment.factor:
        return (Row(scene.name, scene.title or scene.name, False, scene, (), {}),)
    factors = [factor.level for factor in scene.experiment.factor]
    return tuple(_row(scene, levels) for levels in product(*factors))


def _row(scene: Scene, levels: tuple[Level, ...]) -> Row:
    cast = {one.name: one for one in scene.cast}
    words: list[str] = []
    # Who is cast comes first, whatever the order of the factors: an option is of whoever stands there then.
    for level in levels:
        cast |= {one.name: one for one in level.cast}
    for level in levels:
        for setting in level.setting:
            if setting.agent is None:
                words += _rule(setting)
            else:
                cast[setting.agent] = _given(cast[setting.agent], setting)
    return Row(
        name="+".join(level.name for level in levels),
        title=", ".join(level.title or level.name for level in levels),
        real=any(level.real for level in levels),
        scene=msgspec.structs.replace(scene, cast=tuple(cast.values())),
        words=tuple(words),
        bridges={one.agent: one for level in levels for one in level.bridge},
    )


def _rule(setting: Setting) -> tuple[str, str]:
    if setting.name not in RULES:
        known = ", ".join(RULES)
        raise WireError("value", f"Setting.Name: expected a rule ({known}), got {setting.name!r}", "Setting.Name")
    return RULES[setting.name], setting.value


def _given(cast: Cast, setting: Setting) -> Cast:
    option = Option(name=setting.name, value=setting.value)
    kept = tuple(one for one in cast.option if one.name != setting.name)
    return msgspec.structs.replace(cast, option=(*kept, option))
