"""Bodies that are there: dragged as ghosts, asked to go where they are let go."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from intellwheels_schemas.messages import Delete, Teleport
from tests.viewer.opened import SNAPSHOT, Opened
from tests.viewer.wire import until

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")


def test_a_dragged_body_is_asked_to_go_and_only_a_ghost_moves(here: Opened) -> None:
    here.drag("a", ("start", (1.0, 1.0)), ("update", (2.0, 1.5)))
    assert here.ghost()
    assert here.network.asked == []
    here.drag("a", ("end", (3.0, 2.0)))
    request = here.network.wished()
    assert isinstance(request, Teleport)
    assert request.agent == "a"
    assert (request.position.x, request.position.y) == pytest.approx((3.0, 2.0))
    until(lambda: not here.ghost())


def test_a_body_that_was_hardly_pulled_stays(here: Opened) -> None:
    here.drag("a", ("start", (1.0, 1.0)), ("update", (1.01, 1.0)), ("end", (1.01, 1.0)))
    assert here.network.asked == []


def test_a_body_that_vanishes_while_it_is_dragged_is_let_go(here: Opened) -> None:
    here.drag("a", ("start", (1.0, 1.0)), ("update", (2.0, 1.5)))
    here.show(replace(SNAPSHOT, entities=(), bodies={}))
    here.drag("a", ("update", (2.5, 1.5)), ("end", (3.0, 2.0)))
    assert not here.ghost()
    assert here.network.asked == []


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_a_drag_to_nowhere_moves_nothing(here: Opened, bad: float) -> None:
    here.drag("a", ("start", (1.0, 1.0)), ("update", (bad, 1.5)), ("end", (2.0, bad)))
    assert here.network.asked == []


def test_who_is_selected_is_turned_and_removed_and_nobody_else(here: Opened) -> None:
    for name in (None, "nobody"):
        here.page._drag_move.turn(SNAPSHOT, name, 45.0)
    here.page._drag_move.remove(None)
    assert here.network.asked == []
    here.page._drag_move.turn(SNAPSHOT, "a", 45.0)
    request = here.network.wished()
    assert isinstance(request, Teleport)
    assert request.position.heading == pytest.approx(math.pi / 4)
    here.page._drag_move.remove("a")
    until(lambda: here.network.asked[-1] == ("delete", Delete(agent="a")))
