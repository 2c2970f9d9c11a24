from __future__ import annotations

import pytest

from intellwheels_maps import floor, names
from intellwheels_schemas.file_records import Join, SpawnBody, TeleportBody
from intellwheels_schemas.messages import Map, Place, Position
from intellwheels_server.world import Setup, apply, begin
from intellwheels_server.world.floor_bounds import outside
from intellwheels_server.world.map_geometry import walls_of
from tests.server.worlds import box_wall, cart, floor_of

ROOM = (
    box_wall(0.0, 0.0, 10.0, 0.2), box_wall(0.0, 5.0, 10.0, 5.2), box_wall(0.0, 0.0, 0.2, 5.2),
    box_wall(9.8, 0.0, 10.0, 5.2),
)  # fmt: skip
DOORWAY = (*ROOM[:2], box_wall(0.0, 0.0, 0.2, 2.0), box_wall(0.0, 3.2, 0.2, 5.2), ROOM[3])
U_SHAPE = ROOM[1:]
FAR = 300.0


def found(area: Map, x: float, y: float) -> str | None:
    return outside(walls_of(area), area, x, y)


@pytest.mark.parametrize("walls", [ROOM, DOORWAY])
def test_position_beyond_outer_walls_is_outside(walls: tuple[object, ...]) -> None:
    area = floor_of(walls)  # type: ignore[arg-type]
    text = "map 'test' has outer walls: expected x in [0, 10] and y in [0, 5.2], got (300, 2)"
    assert found(area, FAR, 2.0) == text
    assert found(area, 5.0, -0.1) is not None
    assert found(area, 5.0, 2.5) is None


@pytest.mark.parametrize("walls", [(), U_SHAPE, ROOM[:1], ROOM[:2], (box_wall(4.0, 2.0, 5.0, 3.0),)])
def test_map_without_outer_walls_ends_nowhere(walls: tuple[object, ...]) -> None:
    assert found(floor_of(walls), FAR, 2.0) is None  # type: ignore[arg-type]


def test_place_before_the_house_belongs_to_the_map() -> None:
    area = floor_of(ROOM, (Place(name="street", x=-3.0, y=2.0),))
    assert found(area, -2.5, 2.0) is None
    assert found(area, -3.5, 2.0) is not None


def test_included_maps_contain_their_places() -> None:
    for name in names("floors"):
        area = floor(name)
        assert all(found(area, spot.x, spot.y) is None for spot in (area.grid.position if area.grid else ())), name
    assert found(floor("ward"), FAR, 2.0) is not None


def test_body_does_not_come_outside_by_join_spawn_or_teleport() -> None:
    state = begin(Setup(floor=floor_of(ROOM)), run="0" * 16)
    beyond = Position(x=FAR, y=2.0, heading=0.0)
    state, outputs = apply(state, [
        Join(agent="a", robot=cart(FAR, 2.0)), SpawnBody(robot=cart(FAR, 2.0, name="b")),
        Join(agent="c", robot=cart(5.0, 2.0)), TeleportBody(agent="c", position=beyond),
        TeleportBody(agent="c", position=beyond, force=True),
    ])  # fmt: skip
    assert [one.refused for one in outputs.outcomes] == ["value", "value", None, "value", None]
    assert "expected x in [0, 10]" in outputs.outcomes[0].text
    assert sorted(state.names) == ["c"]


def test_real_chair_is_accepted_anywhere() -> None:
    state = begin(Setup(floor=floor_of(ROOM)), run="0" * 16)
    _, outputs = apply(state, [Join(agent="a", robot=cart(FAR, 2.0, type="real"))])
    assert [one.code for one in outputs.outcomes] == ["ok"]
