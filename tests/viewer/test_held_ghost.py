"""The one ghost of a browser, moved from two threads."""

from __future__ import annotations

import math
import threading

import pytest

from intellwheels_viewer.held_ghost import position
from intellwheels_viewer.panels.place import PALETTE
from tests.viewer.opened import Opened

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")


def test_hands_and_answers_move_the_ghost_at_once_without_harm(here: Opened) -> None:
    faults: list[Exception] = []

    def move_ghost(shift: float) -> None:
        try:
            for step in range(60):
                here.page._choose(list(PALETTE)[step % len(PALETTE)])
                here.page._placing_click._preview(step * 0.01 + shift, 1.0)
                here.page._held_ghost.mark_refused()
                here.page._held_ghost.clear()
        except Exception as fault:
            faults.append(fault)

    hands = [threading.Thread(target=move_ghost, args=(shift,)) for shift in (0.0, 0.5)]
    for each in hands:
        each.start()
    for each in hands:
        each.join(30.0)
    assert faults == []


@pytest.mark.parametrize(
    ("heading", "brought"), [(0.5, 0.5), (math.pi, math.pi), (-math.pi, math.pi), (2.5 * math.pi, math.pi / 2)]
)
def test_a_heading_is_brought_into_the_half_open_turn(heading: float, brought: float) -> None:
    found = position(1.0, 2.0, heading)
    assert (found.x, found.y) == (1.0, 2.0)
    assert found.heading == pytest.approx(brought)


def test_an_empty_hand_turns_and_reddens_nothing(here: Opened) -> None:
    here.page._held_ghost.turn(1.0)
    here.page._held_ghost.mark_refused()
    assert here.page._held_ghost.ghost is None
