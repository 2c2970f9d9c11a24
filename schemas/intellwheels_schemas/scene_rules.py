"""Rules of maps, scenes and experiments that span several fields. Pure. `rules` applies them.

`intellwheels_maps` makes the checks that need geometry or other files.
"""

from __future__ import annotations

from itertools import product

from intellwheels_schemas.command_line import words_of
from intellwheels_schemas.errors import wrong_value
from intellwheels_schemas.explain import shown
from intellwheels_schemas.messages import Cast, Experiment, Map, Scene, Uniform


def check_map(floor: Map, where: str = "Map") -> None:
    """Check the counts and heights of a map; `intellwheels_maps` checks its geometry.

    Raises:
        WireError: `value`.
    """
    for index, wall in enumerate(floor.wall):
        place = f"{where}.Wall[{index}]"
        least = 3 if wall.thickness is None else 2
        if len(wall.corner) < least:
            raise wrong_value(place, f"at least {least} corners", len(wall.corner))
        if not wall.bottom < wall.height:
            raise wrong_value(f"{place}.Height", f"more than Bottom {shown(wall.bottom)}", shown(wall.height))
    for index, obstacle in enumerate(floor.obstacle):
        place = f"{where}.Obstacle[{index}]"
        if len(obstacle.corner) < 3:
            raise wrong_value(place, "at least 3 corners", len(obstacle.corner))
        if not obstacle.bottom < obstacle.top:
            raise wrong_value(f"{place}.Top", f"more than Bottom {shown(obstacle.bottom)}", shown(obstacle.top))
    for index, zone in enumerate(floor.zone):
        if len(zone.corner) < 3:
            raise wrong_value(f"{where}.Zone[{index}]", "at least 3 corners", len(zone.corner))


def check_scene(scene: Scene, where: str) -> None:
    """Check the cast, the bridges and the experiment of a scene against each other.

    Raises:
        WireError: `value` or `field`.
    """
    names: set[str] = set()
    bridged = bridged_agents(scene)
    for index, cast in enumerate(scene.cast):
        _check_program(cast, bridged, f"{where}.Cast[{index}]")
        if cast.name in names:
            raise wrong_value(f"{where}.Cast[{index}].Name", "each name once", f"{shown(cast.name)} twice")
        names.add(cast.name)
        options = [option.name for option in cast.option]
        for at, name in enumerate(options):
            if name in options[:at]:
                place = f"{where}.Cast[{index}].Option[{at}].Name"
                raise wrong_value(place, "each option once", f"{shown(name)} twice")
    for index, bridge in enumerate(scene.bridge):
        if bridge.agent not in names:
            raise wrong_value(f"{where}.Bridge[{index}].Agent", "an agent of the cast", shown(bridge.agent))
        if bridge.agent in [other.agent for other in scene.bridge[:index]]:
            raise wrong_value(f"{where}.Bridge[{index}].Agent", "each agent once", f"{shown(bridge.agent)} twice")
    for index, reach in enumerate(scene.end.reach if scene.end is not None else ()):
        if reach.agent not in names:
            raise wrong_value(f"{where}.End.Reach[{index}].Agent", "an agent of the cast", shown(reach.agent))
    if scene.experiment is not None:
        for number, factor in enumerate(scene.experiment.factor):
            for at, level in enumerate(factor.level):
                for index, cast in enumerate(level.cast):
                    place = f"{where}.Experiment.Factor[{number}].Level[{at}].Cast[{index}]"
                    _check_program(cast, bridged, place)
        _check_experiment(scene.experiment, names, f"{where}.Experiment")


def bridged_agents(scene: Scene) -> set[str]:
    """Return the agents whose body is a bridge, in all runs or in the rows of some level."""
    factors = scene.experiment.factor if scene.experiment is not None else ()
    levels = [level for factor in factors for level in factor.level]
    return {bridge.agent for bridges in (scene.bridge, *(level.bridge for level in levels)) for bridge in bridges}


def _check_program(cast: Cast, bridged: set[str], where: str) -> None:
    """Check that an agent has either a mind or a command, and nothing that its program would ignore."""
    if cast.command is None:
        if not cast.mind:
            raise wrong_value(where, "a Mind or a Command", "neither")
        if cast.folder is not None:
            raise wrong_value(f"{where}.Folder", "none without a Command", shown(cast.folder))
        return
    if cast.mind:
        raise wrong_value(where, "a Mind or a Command", "both")
    words_of(cast.command, f"{where}.Command")
    if cast.robot and cast.name not in bridged:
        raise wrong_value(f"{where}.Robot", "none with a Command, whose program brings its own body", shown(cast.robot))
    for at, option in enumerate(cast.option):
        if cast.name not in bridged or not option.name[:1].isupper():
            place = f"{where}.Option[{at}].Name"
            raise wrong_value(place, "no option with a Command: write it into the line", shown(option.name))
    if cast.new_run == "restart" and cast.name in bridged:
        raise wrong_value(f"{where}.NewRun", "follow for an agent with a Bridge", "'restart'")


def _check_experiment(experiment: Experiment, cast: set[str], where: str) -> None:
    here = cast | {one.name for factor in experiment.factor for level in factor.level for one in level.cast}
    if experiment.subject not in here:
        raise wrong_value(f"{where}.Subject", "an agent of the cast", shown(experiment.subject))
    _check_uniform(experiment.uniform, here, where)
    _check_once([factor.name for factor in experiment.factor], f"{where}.Factor")
    for index, factor in enumerate(experiment.factor):
        place = f"{where}.Factor[{index}]"
        if not factor.level:
            raise wrong_value(place, "at least one Level", "none")
        _check_once([level.name for level in factor.level], f"{place}.Level")
        for at, level in enumerate(factor.level):
            _check_uniform(level.uniform, here, f"{place}.Level[{at}]")
            for number, bridge in enumerate(level.bridge):
                if bridge.agent not in here:
                    where_bridge = f"{place}.Level[{at}].Bridge[{number}].Agent"
                    raise wrong_value(where_bridge, "an agent of the cast", shown(bridge.agent))
            for number, setting in enumerate(level.setting):
                if setting.agent is not None and setting.agent not in here:
                    raise wrong_value(
                        f"{place}.Level[{at}].Setting[{number}].Agent", "an agent of the cast", shown(setting.agent)
                    )
    rows = {"+".join(level.name for level in levels) for levels in product(*(one.level for one in experiment.factor))}
    for index, compare in enumerate(experiment.compare):
        for side, row in (("First", compare.first), ("Second", compare.second)):
            if row is not None:
                _check_row(row, rows, f"{where}.Compare[{index}].{side}")
        if (compare.second is None) != (compare.expect == "collision-free"):
            raise wrong_value(
                f"{where}.Compare[{index}]",
                "a Second, except for collision-free",
                "no Second" if compare.second is None else "a Second",
            )
    if experiment.umbmark is not None:
        _check_row(experiment.umbmark.left, rows, f"{where}.Umbmark.Left")
        _check_row(experiment.umbmark.right, rows, f"{where}.Umbmark.Right")
        if experiment.umbmark.left == experiment.umbmark.right:
            raise wrong_value(f"{where}.Umbmark.Right", "another row than Left", shown(experiment.umbmark.right))


def _check_uniform(uniforms: tuple[Uniform, ...], agents: set[str], where: str) -> None:
    for index, one in enumerate(uniforms):
        place = f"{where}.Uniform[{index}]"
        given = [name for name, of in (("Agent", one.agent), ("Place", one.place), ("Obstacle", one.obstacle)) if of]
        if len(given) != 1:
            raise wrong_value(place, "one of Agent, Place and Obstacle", " and ".join(given) or "none")
        if one.agent is not None and one.agent not in agents:
            raise wrong_value(f"{place}.Agent", "an agent of the cast", shown(one.agent))
        if one.agent is None:
            numbers = ("X", "Y") if one.place is None else ("X", "Y", "HeadingDeg")
            if one.name not in numbers:
                raise wrong_value(f"{place}.Name", " or ".join(numbers), shown(one.name))
        if one.follows is not None and (one.agent is None or one.follows == one.name):
            raise wrong_value(f"{place}.Follows", "another option of an Agent", shown(one.follows))
        if not one.low < one.high:
            raise wrong_value(f"{place}.High", f"more than Low {shown(one.low)}", shown(one.high))
        same = [(other.agent, other.place, other.obstacle, other.name) for other in uniforms[:index]]
        if (one.agent, one.place, one.obstacle, one.name) in same:
            raise wrong_value(f"{place}.Name", "each number once", f"{shown(one.name)} twice")


def _check_row(row: str, rows: set[str], where: str) -> None:
    if row not in rows:
        raise wrong_value(where, f"a row ({', '.join(sorted(rows)[:20])})", shown(row))


def _check_once(names: list[str], where: str) -> None:
    for index, name in enumerate(names):
        if name in names[:index]:
            raise wrong_value(f"{where}[{index}].Name", "each name once", f"{shown(name)} twice")
