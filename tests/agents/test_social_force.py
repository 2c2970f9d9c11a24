"""Attraction and repulsion between pedestrians."""

from __future__ import annotations

import math

import pytest

from intellwheels_agents.social_force import POTENTIAL, REACH, attraction, repulsion


def test_group_attracts_a_member_far_from_its_centre() -> None:
    assert attraction((0.0, 0.0), [(3.0, 0.0)]) == pytest.approx((1.0, 0.0))
    assert attraction((0.0, 0.0), [(0.9, 0.0)]) == (0.0, 0.0)
    assert attraction((0.0, 0.0), []) == (0.0, 0.0)


def test_shunned_repel_the_more_the_nearer_they_are() -> None:
    assert repulsion((0.0, 0.0), [(1.0, 0.0)]) == pytest.approx((-POTENTIAL / REACH * math.exp(-1.0 / REACH), 0.0))
    assert repulsion((0.0, 0.0), [(0.5, 0.0)])[0] < repulsion((0.0, 0.0), [(1.0, 0.0)])[0] < 0.0
    assert repulsion((0.0, 0.0), [(1.0, 0.0), (-1.0, 0.0)]) == pytest.approx((0.0, 0.0))
    assert repulsion((0.0, 0.0), []) == (0.0, 0.0)
    assert repulsion((0.0, 0.0), [(0.0, 0.0)]) == (0.0, 0.0)
