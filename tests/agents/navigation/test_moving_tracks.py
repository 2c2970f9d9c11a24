"""Groups of points are followed, and have a velocity once they have been seen for a while."""

from __future__ import annotations

import numpy as np
import pytest

from intellwheels_agents.navigation.moving_tracks import MAY_START, STAYS, MovingTracks, groups

BODY = np.array([[0.0, 0.0], [0.2, 0.0], [0.2, 0.2]])


def test_connected_points_are_a_group() -> None:
    points = np.concatenate([BODY, BODY + 3.0])
    assert groups(points) == [[0, 1, 2], [3, 4, 5]]


def test_velocity_of_a_walker_is_found() -> None:
    tracks = MovingTracks(0.05)
    found = np.zeros((3, 2))
    for tick in range(60):
        found, growth = tracks.update(BODY + np.array([[0.05 * tick, -0.02 * tick]]))
    assert (growth == MAY_START).all()
    assert found == pytest.approx(np.array([[1.0, -0.4]] * 3), abs=0.05)


def test_new_and_standing_groups_have_none() -> None:
    tracks = MovingTracks(0.05)
    assert (tracks.update(BODY)[0] == 0.0).all()
    assert (tracks.update(BODY + 0.05)[0] == 0.0).all()
    for _ in range(80):
        found, growth = tracks.update(BODY + 0.05)
    assert (found == 0.0).all()
    assert (growth == STAYS).all()


def test_far_jump_is_another_group() -> None:
    tracks = MovingTracks(0.05)
    for tick in range(20):
        tracks.update(BODY + np.array([[0.05 * tick, 0.0]]))
    tracks.update(BODY + 5.0)
    assert tracks.tracks[0].age == 0.0
