"""A search finds every face that a way by a mirror can meet."""

from __future__ import annotations

import math
import random
from typing import Any

import numpy as np

from intellwheels_server.world.kernels import face_columns
from intellwheels_server.world.kernels.sonar_face_grid import face_grid, faces_by_mirror

GRID: Any = face_grid
SEARCH: Any = faces_by_mirror
WAVE = 0.00865


def _faces(draw: random.Random, count: int) -> Any:
    faces = np.zeros((count, face_columns.COUNT))
    for face in faces:
        turn = draw.uniform(-math.pi, math.pi)
        length = draw.choice((0.02, 0.1, 1.0, 5.0))
        face[:5] = draw.uniform(-4.0, 4.0), draw.uniform(-4.0, 4.0), math.cos(turn), math.sin(turn), length
    return faces


def _scratch(count: int) -> tuple[Any, Any, Any]:
    return np.empty(count, np.int64), np.empty((2, 3)), np.empty(count, np.int64)


def test_faces_in_the_sector_of_a_mirror_and_at_its_ends_are_found_in_order() -> None:
    draw = random.Random(1)
    faces = _faces(draw, 400)
    x, y, reach = 0.3, -0.2, 4.0
    grid = GRID(x, y, reach, WAVE, faces, np.arange(400), *_scratch(400), True)
    places = np.linspace(0.0, 1.0, 400)[:, None] * faces[:, face_columns.LENGTH]
    at_x = faces[:, face_columns.X] - x - places * faces[:, face_columns.NY]
    at_y = faces[:, face_columns.Y] - y + places * faces[:, face_columns.NX]
    narrow = 0
    for mirror in range(400):
        px, py = faces[mirror, face_columns.X] - x, faces[mirror, face_columns.Y] - y
        nx, ny, length = faces[mirror, face_columns.NX : face_columns.LENGTH + 1]
        height = nx * px + ny * py
        if height >= 0.0:
            continue
        first, last = sorted(draw.uniform(0.0, length) for _ in range(2))
        count = SEARCH(px, py, nx, ny, length, height, first, last, 2.0 * reach, mirror + 1, grid)
        if count < 0:
            continue
        narrow += 1
        found = grid.found[:count].tolist()
        assert found == sorted(set(found))
        from_x, from_y = at_x - 2.0 * height * nx, at_y - 2.0 * height * ny
        right = px - first * ny - 2.0 * height * nx, py + first * nx - 2.0 * height * ny
        left = px - last * ny - 2.0 * height * nx, py + last * nx - 2.0 * height * ny
        seen = (right[0] * from_y - right[1] * from_x >= 0.0) & (from_x * left[1] - from_y * left[0] >= 0.0)
        seen &= np.hypot(from_x, from_y) <= 2.0 * reach
        # Within a wave of an end of the mirror.
        for along in (-WAVE, length + WAVE):
            seen |= np.hypot(at_x - px + along * ny, at_y - py - along * nx) < WAVE
        assert set(np.flatnonzero(seen.any(axis=0)).tolist()) <= set(found)
    assert narrow > 50


def test_without_need_there_is_no_grid() -> None:
    assert GRID(0.0, 0.0, 4.0, WAVE, _faces(random.Random(2), 3), np.arange(3), *_scratch(3), False).cells.size == 0
