"""A chair drives through the doors of every kind that a floor can have."""

from __future__ import annotations

from pathlib import Path

import pytest

from intellwheels_maps import robot
from intellwheels_maps.door_leaves import door_leaves
from intellwheels_schemas.files import write_file
from intellwheels_schemas.messages import Corner, Door, DoorKind, Doorway, Map, Position, Wall
from tests.agents.arena import Arena


def hall(door: Door) -> Map:
    """Return a hall, divided at x = 6 by a wall with a door of 1.4 m in its middle."""
    lines = (((0, -3), (14, -3)), ((0, 3), (14, 3)), ((6, -3), (6, -0.7)), ((6, 0.7), (6, 3)))
    walls = tuple(Wall(thickness=0.1, corner=tuple(Corner(x=x, y=y) for x, y in line)) for line in lines)
    doorway = Doorway(name="d", x=6.0, y=0.0, heading_deg=0.0, width=1.4, door=door)
    return Map(format="iw.v1", name="hall", wall=walls, doorway=(doorway,))


@pytest.mark.parametrize("swing", [90.0, -90.0])
@pytest.mark.parametrize("kind", ["hinged", "double-hinged", "sliding", "double-sliding"])
def test_a_door_lets_a_chair_through_and_closes_behind_it(kind: DoorKind, swing: float, tmp_path: Path) -> None:
    leaves = door_leaves(hall(Door(kind=kind, swing_deg=swing)), robot("door"))
    arena = Arena(leaves.floor)
    for cast in leaves.cast:
        file = tmp_path / f"{cast.robot}.xml"
        file.write_text(write_file(leaves.robots[cast.robot]), encoding="utf-8")
        arena.join(cast.name, "door", str(file), cast.place, {one.name: one.value for one in cast.option})
    arena.join(
        "chair", "drive", "rear-wheel", None, {"left": "0.25", "right": "0.25"}, Position(x=1.5, y=0.0, heading=0.0)
    )
    arena.run(60.0, lambda now: now.paths["chair"][-1][0] > 9.0)
    assert arena.paths["chair"][-1][0] > 9.0
    assert arena.contacts() == []
    starts = {cast.name: arena.paths[cast.name][0] for cast in leaves.cast}
    arena.run(25.0)
    for name, start in starts.items():
        assert arena.paths[name][-1] == pytest.approx(start, abs=0.04)
