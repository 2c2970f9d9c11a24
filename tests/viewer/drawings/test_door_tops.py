from __future__ import annotations

import numpy as np
import pytest
import viser

from intellwheels_viewer.drawings.door_look import door
from intellwheels_viewer.drawings.door_tops import DoorTops, top
from intellwheels_viewer.drawings.floor_heights import HALF_HEIGHT
from tests.viewer.drawings.cast import body, entity, node, robot


def test_a_top_goes_on_where_the_cut_leaf_ends_and_hides_its_edge() -> None:
    made = top(robot("door"))
    board, pane = (made[rgb].vertices for rgb in made)
    assert HALF_HEIGHT in np.unique(np.round(board[:, 2], 6))
    assert float(board[:, 2].max()) == pytest.approx(2.0)
    assert float(board[:, 0].max() - board[:, 0].min()) == pytest.approx(1.0, abs=0.01)
    edge = door(robot("door"), cut=HALF_HEIGHT).dark.vertices
    edge = edge[edge[:, 2] > HALF_HEIGHT - 0.04]
    assert (board.min(axis=0) < edge.min(axis=0)).all()
    assert (board.max(axis=0) > edge.max(axis=0)).all()
    assert float(pane[:, 0].max() - pane[:, 0].min()) < 0.8


def test_the_tops_go_with_their_leaves(scene: viser.SceneApi) -> None:
    tops, cast = DoorTops(scene), {"door": body("door"), "a": body("rear-wheel")}
    tops.show(cast, [entity("a"), entity("door", 2.0, 1.0, 0.5)])
    handle = node(scene, "/door-tops/0")
    assert handle.batched_positions.tolist() == [[2.0, 1.0, 0.0]]
    tops.show(cast, ())
    assert not handle.visible


def test_a_low_door_has_none() -> None:
    assert all(not len(each.faces) for each in top(robot("door", top=1.0, length=1.0, width=0.1)).values())
