"""The rows of an experiment: each combination of its levels, as a scene of its own. Pure: a scene in, rows out."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import chain, product
from typing import Any, Final, get_args

import msgspec

from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Bridge, Cast, Level, Option, Period, Scene, Setting, Uniform

OPTIONS: Final[Mapping[str, str]] = {
    "SayRange": "--say-range",
    "SayLoss": "--say-loss",
    "SayWalls": "--say-walls",
    "SayDelay": "--say-delay",
    "SayLimit": "--say-limit",
    "CommandTimeout": "--command-timeout",
    "Period": "--period",
}
"""The settings without an agent, and the simulator's option for each."""
FLAGS: Final[Mapping[str, Mapping[str, str]]] = {"SayWalls": {"true": "--say-walls", "false": "--no-say-walls"}}
"""The settings among these that are true or false, and the simulator's option for each value."""
_PERIOD: Final[Any] = get_args(Period)[1]
"""The constraints of a period, as the contract declares them."""


@dataclass(frozen=True, slots=True)
class Row:
    """A combination of levels, one of each factor.

    Attributes:
        name: The names of the levels, joined by `+`; the scene's name if there are no factors.
        title: The titles of the levels.
        real: Whether its chair represents a real one.
        scene: The scene with the cast of this row.
        arguments: Further arguments for the simulator.
        bridges: The bridges by agent: these agents' bodies are chairs in a laboratory.
        uniform: Numbers that differ from seed to seed.
    """

    name: str
    title: str
    real: bool
    scene: Scene
    arguments: tuple[str, ...]
    bridges: Mapping[str, Bridge]
    uniform: tuple[Uniform, ...] = ()


def rows_of(scene: Scene) -> tuple[Row, ...]:
    """Return the rows of a scene. The last factor varies fastest.

    Raises:
        WireError: A setting has an unknown name or a wrong value, or a row has bridges and the experiment's subject has
            none.
    """
    if scene.experiment is None or not scene.experiment.factor:
        bridges = {bridge.agent: bridge for bridge in scene.bridge}
        _check_subject(scene, bridges)
        real = scene.experiment is not None and scene.experiment.subject in bridges
        uniform = scene.experiment.uniform if scene.experiment is not None else ()
        return (Row(scene.name, scene.title or scene.name, real, scene, (), bridges, uniform),)
    factors = [factor.level for factor in scene.experiment.factor]
    return tuple(_row(scene, levels) for levels in product(*factors))


def _row(scene: Scene, levels: tuple[Level, ...]) -> Row:
    cast = {agent.name: agent for agent in scene.cast}
    arguments: list[str] = []
    period = scene.period
    # The cast comes first, in any order of the factors: a setting changes the agent of the row.
    for level in levels:
        cast |= {agent.name: agent for agent in level.cast}
    for level in levels:
        for setting in level.setting:
            if setting.agent is None:
                arguments += _arguments(setting)
                period = _period(setting) if setting.name == "Period" else period
            else:
                cast[setting.agent] = _with_option(cast[setting.agent], setting)
    bridges = {one.agent: one for one in chain(scene.bridge, *(level.bridge for level in levels))}
    _check_subject(scene, bridges)
    return Row(
        name="+".join(level.name for level in levels),
        title=", ".join(level.title or level.name for level in levels),
        real=any(level.real for level in levels)
        or (scene.experiment is not None and scene.experiment.subject in bridges),
        scene=msgspec.structs.replace(scene, cast=tuple(cast.values()), period=period),
        arguments=tuple(arguments),
        bridges=bridges,
        uniform=_uniform(scene, levels),
    )


def _uniform(scene: Scene, levels: tuple[Level, ...]) -> tuple[Uniform, ...]:
    """Return the numbers that differ from seed to seed. A level's range replaces the experiment's for its number."""
    common = scene.experiment.uniform if scene.experiment is not None else ()
    found = {
        (one.agent, one.place, one.obstacle, one.name): one
        for one in chain(common, *(level.uniform for level in levels))
    }
    return tuple(found.values())


def _check_subject(scene: Scene, bridges: Mapping[str, Bridge]) -> None:
    """Raise if the row has bridges but none for the subject, so that the laboratory could not score it."""
    if scene.experiment is None or not bridges:
        return
    if scene.experiment.subject not in bridges:
        expected, got = ", ".join(bridges), scene.experiment.subject
        where = "Experiment.Subject"
        raise WireError("value", f"{where}: expected an agent with a bridge ({expected}), got {got!r}", where)


def _arguments(setting: Setting) -> tuple[str, ...]:
    if setting.name not in OPTIONS:
        known = ", ".join(OPTIONS)
        raise WireError("value", f"Setting.Name: expected one of {known}, got {setting.name!r}", "Setting.Name")
    if setting.name not in FLAGS:
        return OPTIONS[setting.name], setting.value
    if setting.value not in FLAGS[setting.name]:
        raise WireError("value", f"Setting.Value: expected true or false, got {setting.value!r}", "Setting.Value")
    return (FLAGS[setting.name][setting.value],)


def _period(setting: Setting) -> float:
    """Return a period in s. The scene of the row needs it, as the laboratory has the same period."""
    try:
        value = float(setting.value)
    except ValueError:
        value = math.nan
    low, high = _PERIOD.ge, _PERIOD.le
    if not low <= value <= high:
        text = f"Setting.Value: expected a period in [{low:g}, {high:g}] s, got {setting.value!r}"
        raise WireError("value", text, "Setting.Value")
    return value


def _with_option(cast: Cast, setting: Setting) -> Cast:
    if cast.command is not None:
        where, got = "Setting.Agent", cast.name
        raise WireError("value", f"{where}: expected an agent with a mind, got {got!r}, which has a Command", where)
    option = Option(name=setting.name, value=setting.value)
    others = tuple(one for one in cast.option if one.name != setting.name)
    return msgspec.structs.replace(cast, option=(*others, option))
