from __future__ import annotations

import math

import numpy as np

from intellwheels_maps import library
from intellwheels_viewer.sight import blinds, in_sight, leaves
from tests.viewer.drawings.cast import body, entity

ROOM = library.floor("room")


def test_a_wall_hides_and_an_open_door_does_not() -> None:
    walls = blinds(ROOM, 1.2)
    others = [entity("beside", 5.0, 5.0), entity("behind", 11.0, 1.0), entity("through", 11.0, 4.0)]
    assert [each.name for each in in_sight((6.0, 4.0), others, walls)] == ["beside", "through"]
    bodies = {"door": body("door")}
    closed = leaves(bodies, [entity("door", 9.0, 3.51, math.pi / 2)], 1.2)
    seen = in_sight((6.0, 4.0), others, np.concatenate([walls, closed]))
    assert "through" in {each.name for each in seen} or len(closed) == 1


def test_a_closed_leaf_hides_what_is_behind_it() -> None:
    (leaf,) = leaves({"door": body("door")}, [entity("door", 9.0, 3.5, math.pi / 2)], 1.2)
    middle = ((leaf[0] + leaf[2]) / 2, (leaf[1] + leaf[3]) / 2)
    behind = entity("behind", 2 * middle[0] - 6.0, 2 * middle[1] - 4.0)
    assert in_sight((6.0, 4.0), [behind], leaf[None]) == []
    assert len(leaves({"door": body("door")}, [entity("door")], 2.2)) == 0


def test_low_things_hide_nothing_and_without_walls_all_is_seen() -> None:
    ward = library.floor("ward")
    assert len(blinds(ward, 1.2)) > len(blinds(ward, 3.0)) == 0
    assert [each.name for each in in_sight((0.0, 0.0), [entity("a", 1.0)], np.zeros((0, 4)))] == ["a"]
    assert in_sight((0.0, 0.0), [], blinds(ward, 1.2)) == []
