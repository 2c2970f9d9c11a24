from __future__ import annotations

import math

from intellwheels_maps import library
from intellwheels_maps.check import wall_pieces
from intellwheels_maps.plane_geometry import contains
from intellwheels_viewer.drawings.building_colours import DAY
from intellwheels_viewer.drawings.rooms import rooms_of
from intellwheels_viewer.drawings.signs import HEIGHT, places, signs

WARD = library.floor("ward")


def test_a_sign_hangs_on_a_wall_and_names_the_room_that_one_enters() -> None:
    rooms = rooms_of(WARD)
    pieces = [piece for wall in WARD.wall for piece in wall_pieces(wall)]
    found = places(WARD)
    assert {sign.text for sign in found} >= {"Room 1", "Room 9", "Day room", "Bathroom", "Corridor"}
    for sign in found:
        dx, dy = math.cos(sign.heading), math.sin(sign.heading)
        here = rooms.at(sign.x + 0.3 * dx, sign.y + 0.3 * dy)
        assert here is None or (here.title or here.name) != sign.text
        assert any(contains(piece, (sign.x - 0.04 * dx, sign.y - 0.04 * dy)) for piece in pieces)


def test_all_signs_are_two_surfaces_at_eye_height() -> None:
    plates, letters = signs(WARD, DAY)
    assert letters.picture is not None
    assert len(letters.solid.faces) == 2 * len(places(WARD))
    assert abs(float(plates.solid.vertices[:, 2].mean()) - HEIGHT) < 0.01


def test_a_street_and_a_map_without_doorways_have_none() -> None:
    assert signs(library.floor("crossing"), DAY) == []
    assert signs(library.floor("square"), DAY) == []
