"""The rows of an experiment: each combination of its levels, as a scene of its own. Pure: a scene in, scenes out."""

from __future__ import annotations

import math
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
    "SayWalls": "--say-walls",
    "SayDelay": "--say-delay",
    "SayLimit": "--say-limit",
    "CommandTimeout": "--command-timeout",
    "Period": "--period",
}
"""What a setting without an agent may name, and how the simulator is told."""
WHETHER: Final[Mapping[str, Mapping[str, str]]] = {"SayWalls": {"true": "--say-walls", "false": "--no-say-walls"}}
"""Of these, those that hold or do not: how the simulator is told which."""


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
        WireError: A setting names no rule of the simulation, or its value is none; or the runs of a row with bridges
            are those of a chair without one.
    """
    if scene.experiment is None or not scene.experiment.factor:
        bridges = {one.agent: one for one in scene.bridge}
        _check_subject(scene, bridges)
        real = scene.experiment is not None and scene.experiment.subject in bridges
        return (Row(scene.name, scene.title or scene.name, real, scene, (), bridges),)
    factors = [factor.level for factor in scene.experiment.factor]
    return tuple(_row(scene, levels) for levels in product(*factors))


def _row(scene: Scene, levels: tuple[Level, ...]) -> Row:
    cast = {one.name: one for one in scene.cast}
    words: list[str] = []
    period = scene.period
    # Who is cast comes first, whatever the order of the factors: an option is of whoever stands there then.
    for level in levels:
        cast |= {one.name: one for one in level.cast}
    for level in levels:
        for setting in level.setting:
            if setting.agent is None:
                words += _rule(setting)
                period = _period(setting) if setting.name == "Period" else period
            else:
                cast[setting.agent] = _given(cast[setting.agent], setting)
    bridges = {one.agent: one for one in (*scene.bridge, *(one for level in levels for one in level.bridge))}
    _check_subject(scene, bridges)
    return Row(
        name="+".join(level.name for level in levels),
        title=", ".join(level.title or level.name for level in levels),
        real=any(level.real for level in levels)
        or (scene.experiment is not None and scene.experiment.subject in bridges),
        scene=msgspec.structs.replace(scene, cast=tuple(cast.values()), period=period),
        words=tuple(words),
        bridges=bridges,
    )


def _check_subject(scene: Scene, bridges: Mapping[str, Bridge]) -> None:
    """Raise where runs are scored by a laboratory that the chair is not in."""
    if scene.experiment is None or not bridges:
        return
    if scene.experiment.subject not in bridges:
        expected, got = ", ".join(bridges), scene.experiment.subject
        where = "Experiment.Subject"
        raise WireError("value", f"{where}: expected one with a bridge ({expected}), got {got!r}", where)


def _rule(setting: Setting) -> tuple[str, ...]:
    if setting.name not in RULES:
        known = ", ".join(RULES)
        raise WireError("value", f"Setting.Name: expected a rule ({known}), got {setting.name!r}", "Setting.Name")
    if setting.name not in WHETHER:
        return RULES[setting.name], setting.value
    if setting.value not in WHETHER[setting.name]:
        raise WireError("value", f"Setting.Value: expected true or false, got {setting.value!r}", "Setting.Value")
    return (WHETHER[setting.name][setting.value],)


def _period(setting: Setting) -> float:
    """Return a period, which a laboratory keeps too."""
    try:
        value = float(setting.value)
    except ValueError:
        value = math.nan
    if not 0.001 <= value <= 1.0:
        text = f"Setting.Value: expected a period in [0.001, 1] s, got {setting.value!r}"
        raise WireError("value", text, "Setting.Value")
    return value


def _given(cast: Cast, setting: Setting) -> Cast:
    option = Option(name=setting.name, value=setting.value)
    kept = tuple(one for one in cast.option if one.name != setting.name)
    return msgspec.structs.replace(cast, option=(*kept, option))
