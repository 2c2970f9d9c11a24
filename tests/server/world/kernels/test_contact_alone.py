"""What a body does alone: its proposal if that may stand, else the nearest thing to it that may."""

import math

import numpy as np
import pytest

from intellwheels_server.world.kernels.contact_alone import best_alone
from intellwheels_server.world.kernels.penetration import OF_ANCHORED, SPOT_H, SPOT_X, SPOT_Y
from tests.server.world.kernels.test_penetration import AROUND, BLOCKS, INDEX, spots


def best(
    start: tuple[float, float, float], travel: float, turn: float, *, anchored: bool = False
) -> tuple[bool, float, float, list[float]]:
    """Let body 0 do its best before the wall x = 5 with the other body far away; return where it ends too."""
    old = spots(start, (-50.0, 0.0, 0.0))
    x, y, heading = start
    proposal = spots(
        (x + travel * math.cos(heading), y + travel * math.sin(heading), heading + turn), (-50.0, 0.0, 0.0)
    )
    index, result = INDEX.copy(), np.zeros((2, 5))
    index[0, OF_ANCHORED] = anchored
    whole, forward, turned = best_alone(
        *BLOCKS, index, AROUND, old, old, 0, proposal, travel, turn, abs(travel) + 2.0 * abs(turn), result
    )
    return whole, forward, turned, [result[0, row] for row in (SPOT_X, SPOT_Y, SPOT_H)]


def test_proposal_that_may_stand_is_granted_to_the_bit() -> None:
    assert best((2.0, 0.0, 0.0), 0.125, 0.0) == (True, 0.125, 0.0, [2.125, 0.0, 0.0])


def test_body_that_drives_at_a_wall_stops_flush() -> None:
    whole, forward, turned, (x, y, heading) = best((3.875, 0.0, 0.0), 0.25, 0.0)
    assert not whole
    assert forward == pytest.approx(0.125, abs=1e-8)
    assert x == pytest.approx(4.0, abs=1e-8)
    assert (turned, y, heading) == (0.0, 0.0, 0.0)


def test_body_that_is_flush_with_a_wall_turns_without_its_travel() -> None:
    # Its middle is 1.125 m before the wall and its corners are 1.118 m from it: it can turn in place.
    whole, _, turned, (x, _, heading) = best((3.875, 0.0, 0.0), 0.25, 0.25)
    assert not whole
    assert (turned, heading) == (0.25, 0.25)
    assert x <= 4.0


def test_hinged_body_does_not_slide_and_gets_a_share_of_its_motion() -> None:
    whole, forward, turned, _ = best((3.9, 0.0, 0.0), 0.0, 0.5, anchored=True)
    assert not whole
    assert forward == 0.0
    assert 0.0 < turned < 0.5
