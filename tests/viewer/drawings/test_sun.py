"""The sun of all browsers, and that of one that looks from far."""

from __future__ import annotations

import pytest
import viser

from intellwheels_maps import library
from intellwheels_viewer.cameras import FOV, STEEP, corners_of, fit
from intellwheels_viewer.drawings.label_layout import Picture
from intellwheels_viewer.drawings.sun import FAR, NAME, NEAR, OwnSun, has_shadows
from intellwheels_viewer.stage import Stage

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")


def at(distance: float) -> Picture:
    """Return a camera at a distance above what it looks at."""
    return Picture((1.0, 2.0, distance), (1.0, 2.0, 0.0), FOV, 1280, 800)


def test_shadows_end_where_viser_draws_none_and_do_not_flicker_at_the_limit() -> None:
    between = (NEAR + FAR) / 2
    assert has_shadows(at(FAR), had=True)
    assert has_shadows(at(between), had=True)
    assert not has_shadows(at(FAR + 0.1), had=True)
    assert not has_shadows(at(between), had=False)
    assert has_shadows(at(NEAR), had=False)


def test_the_first_view_of_a_ward_has_no_shadows() -> None:
    view = fit(corners_of(library.floor("ward")), STEEP, FOV, 0.87)
    (px, py, pz), (lx, ly, lz) = view.position.tolist(), view.look_at.tolist()
    assert not has_shadows(Picture((px, py, pz), (lx, ly, lz), view.fov, 696, 800), had=True)


def test_a_browser_has_a_sun_of_its_own_from_when_it_looks_from_far(pages: viser.ViserServer) -> None:
    Stage(pages)
    scene = pages.scene
    shared = scene._handle_from_node_name[NAME]
    sun = OwnSun(scene)  # in place of a browser's scene
    sun.show(None)
    sun.show(at(5.0))
    assert scene._handle_from_node_name[NAME] is shared
    sun.show(at(50.0))
    own = scene._handle_from_node_name[NAME]
    assert own is not shared
    assert isinstance(own, viser.DirectionalLightHandle)
    assert not own.cast_shadow
    sun.show(None)
    assert not own.cast_shadow
    sun.show(at(5.0))
    assert own.cast_shadow
    assert scene._handle_from_node_name[NAME] is own
    pages.scene.reset()
