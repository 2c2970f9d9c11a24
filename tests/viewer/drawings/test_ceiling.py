from __future__ import annotations

import numpy as np
import pytest

from intellwheels_maps import library
from intellwheels_maps.plane_geometry import contains
from intellwheels_viewer.drawings.building_colours import DAY
from intellwheels_viewer.drawings.ceiling import BELOW, ceiling, height, lamps
from intellwheels_viewer.drawings.glb import normals
from intellwheels_viewer.drawings.rooms import corners_of

WARD = library.floor("ward")


def test_a_ceiling_is_under_the_tops_of_the_walls_and_faces_down() -> None:
    panels, lit = ceiling(WARD, DAY)
    assert float(panels.solid.vertices[:, 2].max()) == pytest.approx(2.5 - BELOW)
    assert float(lit.solid.vertices[:, 2].max()) < 2.5 - BELOW
    for surface in (panels, lit):
        assert np.allclose(normals(surface.solid), (0.0, 0.0, -1.0))
    assert lit.glows


def test_every_room_has_a_lamp_inside() -> None:
    found = lamps(WARD)
    for zone in WARD.zone:
        ring = corners_of(zone)
        assert any(all(contains(ring, corner) for corner in lamp) for lamp in found), zone.name


def test_there_is_none_outdoors() -> None:
    assert height(library.floor("crossing")) is None
    assert ceiling(library.floor("crossing"), DAY) == []
