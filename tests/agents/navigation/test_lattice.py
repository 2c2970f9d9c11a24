"""Headings lead exactly to other cells."""

from __future__ import annotations

import numpy as np
import pytest

from intellwheels_agents.navigation.lattice import ANGLES, COSINES, COUNT, GAPS, LENGTHS, SINES, STEPS


def test_headings_ascend_once_round() -> None:
    assert COUNT == 32
    assert (GAPS > 0.12).all()
    assert (GAPS < 0.26).all()
    assert GAPS.sum() == pytest.approx(2.0 * np.pi)


def test_moves_lead_along_their_headings() -> None:
    for k, (i, j) in enumerate(STEPS):
        assert LENGTHS[k] * np.cos(ANGLES[k]) == pytest.approx(i)
        assert LENGTHS[k] * np.sin(ANGLES[k]) == pytest.approx(j)
        assert (COSINES[k] * LENGTHS[k], SINES[k] * LENGTHS[k]) == pytest.approx((i, j))


def test_each_heading_has_its_opposite() -> None:
    assert all((-i, -j) in STEPS for i, j in STEPS)
