import numpy as np

from intellwheels_schemas.messages import Position, Proximity
from intellwheels_server.world.sensors.proximity_arrays import joined, piece_of

_EYE = Proximity(id="eye", x=0.3, y=0.4, z=0.4, direction_deg=90.0, cone_deg=60.0, max_range=4.0)


def test_sensors_of_a_body_share_a_mount_that_reaches_as_far_as_they_see() -> None:
    piece = piece_of([_EYE, _EYE], Position(x=1.0, y=2.0, heading=0.5))
    assert piece.seeing.mounts.tolist() == [[1.0, 2.0, 0.5, 4.5]]
    assert piece.seeing.groups.tolist() == [[0, 0, 0, 2]]
    assert piece.seeing.beams.shape == (2, 9)
    assert piece.sonars.beams.shape == (0, 9)
    assert (piece.sonar.tolist(), piece.is_infrared.tolist()) == ([False, False], [False, False])


def test_start_of_one_body_does_not_change_that_of_another_with_the_same_sensors() -> None:
    first = piece_of([_EYE], Position(x=1.0, y=2.0, heading=0.5))
    second = piece_of([_EYE], Position(x=-1.0, y=0.0, heading=0.0))
    assert first.seeing.mounts.tolist() == [[1.0, 2.0, 0.5, 4.5]]
    assert second.seeing.mounts.tolist() == [[-1.0, 0.0, 0.0, 4.5]]


def test_bodies_side_by_side_count_their_sensors_through() -> None:
    start = Position(x=0.0, y=0.0, heading=0.0)
    one, two, none = (piece_of([_EYE] * count, start).seeing for count in (1, 2, 0))
    groups = joined([two, none, one], np.array([3, 4, 7])).groups
    assert groups.tolist() == [[3, 0, 0, 2], [7, 0, 2, 3]]
