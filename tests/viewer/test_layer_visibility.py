"""Layers that one browser hides, and keeps."""

from __future__ import annotations

from dataclasses import replace

import pytest
import viser

from intellwheels_viewer.drawings.building_colours import DAY, NIGHT
from intellwheels_viewer.drawings.floor_heights import HALF_HEIGHT
from intellwheels_viewer.layer_visibility import LAYERS_KEY
from intellwheels_viewer.panels.layers_panel import Layers
from tests.viewer.browser import opened
from tests.viewer.opened import SNAPSHOT, Opened
from tests.viewer.wire import entity, until

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")


@pytest.mark.process
def test_a_layer_that_was_hidden_is_hidden_the_next_time(pages: viser.ViserServer) -> None:
    stored = replace(Layers(), trails=False).to_json()
    with opened(pages.get_port(), storage=stored) as browser:
        made = Opened(pages, browser)
        browser.wait(lambda: "/trails" in browser.scene)
        assert set(made.page._layers.hidden) == {"trails", "all_wedges"}
        made.page.close()
    until(lambda: not pages.get_clients())


@pytest.mark.process
@pytest.mark.parametrize("stored", ["", "{", "[]", '{"wedges": 7}', "null", "x" * 100_000])
def test_nonsense_that_a_browser_kept_is_as_nothing(pages: viser.ViserServer, stored: str) -> None:
    with opened(pages.get_port(), storage=stored) as browser:
        made = Opened(pages, browser)
        made.page.close()
    until(lambda: not pages.get_clients())


def test_a_layer_is_kept_by_the_browser(here: Opened) -> None:
    here.page._layers.choose(replace(Layers(), trails=False))
    here.browser.wait(lambda: any(message.get("key") == LAYERS_KEY for message in here.browser.heard))


def test_a_browser_that_once_had_full_walls_sees_those_of_another_floor(here: Opened) -> None:
    layering = here.page._layers
    layering.draw_walls(SNAPSHOT, inside=True)
    layering.draw_walls(SNAPSHOT, inside=False)
    drawn: list[object] = []
    assert layering._walls is not None
    layering._walls.show = lambda floor, height, _: drawn.append((floor, height))  # type: ignore[method-assign, assignment, misc]
    layering.draw_walls(replace(SNAPSHOT, revision=SNAPSHOT.revision + 1), inside=False)
    assert drawn == [(SNAPSHOT.floor, HALF_HEIGHT)]


def test_walls_between_the_camera_and_the_followed_are_cut_away(here: Opened) -> None:
    layering = here.page._layers
    floor = SNAPSHOT.floor
    assert floor is not None
    middle, south = (floor.wall[0].corner[0].x + floor.wall[0].corner[1].x) / 2, floor.wall[0].corner[0].y
    cut = layering.hiding(SNAPSHOT, (middle, south - 1.5, 2.0), entity("a", middle, south + 0.6))
    assert cut
    layering.draw_walls(SNAPSHOT, inside=False)
    assert vars(layering)["_walls"] is None
    layering.draw_walls(SNAPSHOT, inside=False, cut=cut)
    assert layering._walls is not None
    drawn: list[object] = []
    layering._walls.show = lambda _, __, parts: drawn.append(parts)  # type: ignore[method-assign, assignment, misc]
    layering.draw_walls(SNAPSHOT, inside=False, cut=cut)
    assert drawn == []
    layering.draw_walls(SNAPSHOT, inside=False)
    assert drawn == [frozenset()]


def test_the_building_has_the_theme_of_the_browser(here: Opened) -> None:
    nodes = here.client.scene._handle_from_node_name
    here.show(SNAPSHOT)
    assert "/floor/plate" not in nodes, "the shared building has this theme"
    here.page._window.choose("Dark")
    here.show(SNAPSHOT)
    plates = [nodes["/floor/plate"].color]
    assert nodes["/walls/sides"].visible
    here.page._window.choose("Light")
    here.show(SNAPSHOT)
    plates.append(nodes["/floor/plate"].color)
    assert plates == [NIGHT.outside, DAY.outside]
