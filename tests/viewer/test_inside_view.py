from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import pytest

from intellwheels_maps import library
from intellwheels_viewer.panels.layers_panel import Layers
from intellwheels_viewer.snapshot import Snapshot
from tests.viewer.drawings.cast import RUN, body
from tests.viewer.opened import Opened
from tests.viewer.wire import entity

pytestmark = [pytest.mark.filterwarnings("ignore::DeprecationWarning"), pytest.mark.process]

ROOM = Snapshot(
    phase="live", run=RUN, floor=library.floor("room"), revision=5, version=9,
    bodies={name: body("rear-wheel") for name in ("me", "near", "far")} | {"door": body("door")},
    entities=(
        entity("me", 2.0, 4.0, heading=0.0), entity("near", 6.0, 5.0), entity("far", 11.0, 1.0),
        entity("door", 9.0, 3.51),
    ),
)  # fmt: skip


def nodes(here: Opened) -> Mapping[str, Any]:
    found: Mapping[str, Any] = here.client.scene._handle_from_node_name
    return found


def visible(here: Opened, name: str) -> bool:
    return name in nodes(here) and bool(nodes(here)[name].visible)


def test_from_the_chair_one_sees_ceiling_doors_the_own_hand_and_the_names_in_sight(here: Opened) -> None:
    here.show(ROOM)
    here.page.select("me")
    assert "/ceiling" not in nodes(here)
    here.page.look("first")
    here.show(ROOM)
    assert all(visible(here, name) for name in ("/ceiling", "/door-tops/0", "/cockpit", "/own/labels/near"))
    assert not visible(here, "/own/labels/far"), "a wall is between"
    assert not visible(here, "/own/labels/me")
    hidden = ("/wedges", "/own/wedges", "/trails", "/lidar")
    assert all(name in nodes(here) and not nodes(here)[name].visible for name in hidden)
    here.page.look("free")
    here.show(ROOM)
    assert not any(visible(here, name) for name in ("/ceiling", "/door-tops/0", "/cockpit"))
    assert all(nodes(here)[name].visible for name in ("/own/wedges", "/trails", "/lidar"))


def test_who_wants_it_sees_sensors_from_the_chair_with_the_own_eyes(here: Opened) -> None:
    here.show(ROOM)
    here.page.select("me")
    here.page._layers.choose(replace(Layers(), senses=True, eye_height=1.5, field_of_view=60.0))
    here.page.look("first")
    here.show(ROOM)
    assert visible(here, "/own/wedges")
    assert here.client.camera.position[2] == pytest.approx(1.5)


def test_a_street_has_no_ceiling(here: Opened) -> None:
    here.show(ROOM)
    here.page.select("me")
    here.page.look("first")
    here.show(ROOM)
    here.show(replace(ROOM, floor=library.floor("crossing"), revision=6))
    assert not visible(here, "/ceiling")
