import pytest

from intellwheels_schemas.messages import Corner, Map, Obstacle, Wall
from intellwheels_server.world.kernels.arrays import PIECE_BOTTOM, PIECE_TOP, WALL
from intellwheels_server.world.map_geometry import describe_wall, walls_of

SQUARE = tuple(Corner(x=x, y=y) for x, y in ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)))
LINE = (Corner(x=5.0, y=0.0), Corner(x=9.0, y=0.0))
FLOOR = Map(
    format="iw.v1",
    name="test",
    wall=(Wall(height=2.5, bottom=2.0, corner=SQUARE), Wall(height=1.0, thickness=0.2, corner=LINE)),
    obstacle=(Obstacle(name="bed", bottom=0.3, top=0.6, corner=SQUARE),),
)


def test_walls_come_first_then_obstacles_each_with_its_z_range() -> None:
    walls = walls_of(FLOOR)
    assert walls.links[:, WALL].tolist() == [0, 1, 2]
    assert walls.pieces[:, PIECE_BOTTOM].tolist() == [2.0, 0.0, 0.3]
    assert walls.pieces[:, PIECE_TOP].tolist() == [2.5, 1.0, 0.6]


def test_walls_are_described_by_number_and_obstacles_by_name() -> None:
    assert [describe_wall(FLOOR, index) for index in range(3)] == ["wall 1", "wall 2", "obstacle 'bed'"]


def test_wall_that_is_no_polygon_is_an_error() -> None:
    crossed = Wall(corner=(SQUARE[0], SQUARE[2], SQUARE[1], SQUARE[3]))
    with pytest.raises(ValueError, match="wall 0"):
        walls_of(Map(format="iw.v1", name="test", wall=(crossed,)))
