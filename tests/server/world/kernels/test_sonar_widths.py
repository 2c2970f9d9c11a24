"""Solids of several pieces, bodies of several parts, and faces that continue one another."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from intellwheels_server.world.kernels.sonar_widths import body_span, gather_solid, is_long
from intellwheels_server.world.wall_pieces import Solid, walls_from


def _faces(*rows: tuple[float, float, float, float, float]) -> Any:
    return np.array([(*row, 0.0, 1.0) for row in rows])


def test_faces_in_one_plane_that_follow_one_another_are_one() -> None:
    faces = _faces(
        (1.0, 3.0, -1.0, 0.0, 1.0), (1.0, 2.0, -1.0, 0.0, 1.0), (1.0, 1.0, -1.0, 0.0, 1.0), (1.0, -0.5, -1.0, 0.0, 5.0),
        (1.1, 2.0, -1.0, 0.0, 9.0), (1.0, 2.0, 1.0, 0.0, 9.0), (1.0, 2.0, 0.0, -1.0, 9.0),
    )  # fmt: skip
    for at in range(3):
        assert is_long(at, 3.0, 0.5, faces, len(faces))
        assert not is_long(at, 3.1, 0.5, faces, len(faces))
        assert not is_long(at, 1.1, 1.0, faces, len(faces))


def test_solid_is_all_that_touches_until_it_is_wide_enough() -> None:
    def block(x: float, y: float, top: float = 1.0) -> Solid:
        return Solid([(x, y), (x + 1.0, y), (x + 1.0, y + 1.0), (x, y + 1.0)], 0.0, top)

    walls = walls_from([block(0.0, 0.0), block(1.0, 0.5), block(2.0, 1.5), block(3.1, 1.5), block(9.0, 9.0)])
    members, marks = np.empty(5, np.int64), np.zeros(6, np.int64)
    for piece in range(3):
        count, low, high = gather_solid(piece, 1.0, 0.0, 99.0, *walls, members, marks)
        assert sorted(members[:count].tolist()) == [0, 1, 2]
        assert (low, high) == pytest.approx((0.0, 2.5))
    assert gather_solid(0, 1.0, 0.0, 0.5, *walls, members, marks)[0] == 1


def test_parts_of_a_body_that_touch_are_one_thing() -> None:
    boxes = np.zeros((4, 10))
    boxes[:, 1], boxes[:, 5], boxes[:, 6], boxes[:, 8], boxes[:, 9] = [0.0, 1.0, 2.5, 1.0], 1.0, 1.0, 0.5, 0.5
    boxes[3, 4], boxes[3, 5] = 1.0, 2.0
    owners, members = np.array([0, 0, 0, 1]), np.empty(4, np.int64)
    assert body_span(0, 0.5, 1.0, 0.0, boxes, owners, 4, members) == pytest.approx((-0.5, 1.5))
    assert body_span(2, 0.5, 1.0, 0.0, boxes, owners, 4, members) == pytest.approx((2.0, 3.0))
    assert body_span(1, 0.5, 0.0, 1.0, boxes, owners, 4, members) == pytest.approx((-0.5, 0.5))
