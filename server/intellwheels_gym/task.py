"""A scene as a task: who learns, where each learner must go, and how long it may take. Everything is checked here."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from intellwheels_agents.robot_document import DEFAULT_ROBOT, default_robot, equipped, split_options
from intellwheels_experiments.batch.experiment_rows import Row, rows_of
from intellwheels_maps import floor, robot, scene
from intellwheels_maps.library import folder_of
from intellwheels_schemas.explain import did_you_mean
from intellwheels_schemas.messages import Cast, Map, Robot, Scene

SECONDS: Final = 60.0
"""Length of an episode if the scene has no Timeout, s."""
WITHIN: Final = 0.3
"""Distance from a goal that counts as reached if the scene has no Reach for the learner, m."""


@dataclass(frozen=True)
class GoalPlace:
    """Where a learner must go.

    Attributes:
        place: The name of a place of the map; None for the point.
        point: x and y in m, if there is no place.
        within: Distance that counts as reached, m.
    """

    place: str | None
    point: tuple[float, float]
    within: float

    def on(self, ground: Map) -> tuple[float, float]:
        """Return x and y on a map, m. A place may have moved with the seed."""
        spots = ground.grid.position if ground.grid is not None else ()
        return next(((spot.x, spot.y) for spot in spots if spot.name == self.place), self.point)


@dataclass(frozen=True)
class Task:
    """A scene as a task.

    Attributes:
        row: The scene with the cast of one row of its experiment.
        ground: The map, before a seed varies it.
        folder: Where relative paths in the scene start; None: the working directory.
        goals: The goal of each learner, by its name, in the order of the cast.
        seconds: Length of an episode, s.
    """

    row: Row
    ground: Map
    folder: Path | None
    goals: Mapping[str, GoalPlace]
    seconds: float


def load_task(
    of: str | Path | Scene,
    *,
    learners: Sequence[str] | None = None,
    goals: Mapping[str, object] | None = None,
    goal: object = None,
    row: str | None = None,
    seconds: float | None = None,
    folder: Path | None = None,
    single: bool = False,
) -> Task:
    """Return a scene as a task.

    Args:
        of: The name of an included scene, the path of a file, or a scene.
        learners: Agents of the cast that learn; default: every wheelchair with a goal.
        goals: The goal of each learner: the name of a place, or (x, y) in m. Default: its Reach in the scene.
        goal: The goal of the only learner, instead of `goals`.
        row: A row of the scene's experiment. Its Uniform elements then vary with the seed. A scene whose experiment has
            no Factor has one row, which is the default.
        seconds: Length of an episode; default: the Timeout of the scene, or 60 s.
        folder: Where relative paths start if `of` is a scene.
        single: Whether only the first of the default learners learns.

    Raises:
        WireError: The scene or a file that it uses is missing or wrong.
        ValueError: An argument does not fit the scene.
    """
    document = of if isinstance(of, Scene) else scene(of)
    folder = folder if isinstance(of, Scene) else folder_of(of)
    chosen = _row(document, row)
    ground = floor(chosen.scene.map, beside=folder)
    cast = {one.name: one for one in chosen.scene.cast}
    given = dict(goals or {})
    chairs = [name for name, one in cast.items() if body_of(one, folder).kind == "wheelchair"]
    reached = {one.agent for one in (chosen.scene.end.reach if chosen.scene.end else ())} | given.keys()
    names = _learners(learners, [name for name in chairs if name in reached] or chairs, cast)
    names = names[:1] if single else names
    if goal is not None:
        if len(names) != 1 or given:
            raise ValueError(f"goal: expected one learner without goals, got {_listed(names)}")
        given = {names[0]: goal}
    found = {name: _goal(name, chosen.scene, ground, given.get(name)) for name in names}
    for name in given:
        if name not in names:
            raise ValueError(f"goals: expected the name of a learner ({_listed(names)}), got {name!r}")
    end = chosen.scene.end
    limit = seconds if seconds is not None else end.timeout.seconds if end and end.timeout else SECONDS
    if isinstance(limit, bool) or not isinstance(limit, (int, float)) or not 0.0 < limit < math.inf:
        raise ValueError(f"seconds: expected a number above 0, got {limit!r}")
    wanted = {}
    for name, member in cast.items():
        if name in found:
            one = found[name]
            if one is None:
                places = [spot.name for spot in (ground.grid.position if ground.grid else ())]
                raise ValueError(
                    f"goals: scene {document.name!r} has no Reach for {name!r}: "
                    f"expected a place ({_listed(places)}) or (x, y), got none"
                )
            wanted[name] = one
        elif member.command is not None:
            raise ValueError(f"agent {name!r}: expected a mind, got a command, which needs a network")
    return Task(chosen, ground, folder, wanted, float(limit))


def body_of(cast: Cast, folder: Path | None) -> Robot:
    """Return the robot of an agent of a cast, with the fields that its options set, without what its mind adds.

    Raises:
        WireError: There is no such robot, or its fields contradict each other.
        OptionError: An option names a field that the robot does not have.
    """
    fields, _ = split_options({one.name: one.value for one in cast.option})
    name = cast.robot or (default_robot(cast.mind) if cast.mind else DEFAULT_ROBOT)
    return equipped(robot(name, beside=folder), fields)


def _row(document: Scene, name: str | None) -> Row:
    varied = document.experiment is not None and bool(document.experiment.factor)
    if name is None and varied:
        # The scene as it stands, as `iw-run SCENE` runs it.
        return Row(document.name, document.title or document.name, False, document, (), {})
    rows = {row.name: row for row in rows_of(document)}
    if name is not None and name not in rows:
        text = f"row: expected one of scene {document.name!r} ({_listed(list(rows))}), got {name!r}"
        raise ValueError(text + did_you_mean(str(name), list(rows)))
    row = rows[name] if name is not None else next(iter(rows.values()))
    if row.arguments:
        raise ValueError(f"row: expected a row that sets agents only, got {row.name!r} with {' '.join(row.arguments)}")
    return row


def _learners(given: Sequence[str] | None, usual: list[str], cast: Mapping[str, Cast]) -> list[str]:
    if given is None:
        if not usual:
            raise ValueError("learners: expected a scene with a wheelchair, got none")
        return usual
    if isinstance(given, str) or not given:
        raise ValueError(f"learners: expected names of agents ({_listed(list(cast))}), got {given!r}")
    for name in given:
        if name not in cast:
            raise ValueError(
                f"learners: expected agents of the scene ({_listed(list(cast))}), got {name!r}"
                f"{did_you_mean(str(name), list(cast))}"
            )
    if len(set(given)) < len(given):
        raise ValueError(f"learners: expected each name once, got {_listed(list(given))}")
    return [name for name in cast if name in given]


def _goal(agent: str, document: Scene, ground: Map, given: Any) -> GoalPlace | None:
    reach = next((one for one in (document.end.reach if document.end else ()) if one.agent == agent), None)
    within = reach.within if reach is not None else WITHIN
    if given is None:
        return None if reach is None else GoalPlace(reach.place, (0.0, 0.0), within)
    if isinstance(given, str):
        places = [spot.name for spot in (ground.grid.position if ground.grid else ())]
        if given not in places:
            raise ValueError(
                f"goals: expected a place of map {ground.name!r} ({_listed(places)}), got {given!r}"
                f"{did_you_mean(given, places)}"
            )
        return GoalPlace(given, (0.0, 0.0), within)
    try:
        x, y = (float(number) for number in given)
    except (TypeError, ValueError):
        x = y = math.nan
    if not (math.isfinite(x) and math.isfinite(y)):
        raise ValueError(f"goals: expected a place or (x, y) in m for {agent!r}, got {given!r}")
    return GoalPlace(None, (x, y), within)


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names) or "it has none"
