"""The small plan."""

from __future__ import annotations

import re
from dataclasses import replace
from xml.etree import ElementTree

import pytest
import viser

from intellwheels_maps import library
from intellwheels_schemas.agent_colours import COLOURS, colour_of, css, looks
from intellwheels_schemas.messages import Corner, Entity, Map, Wall
from intellwheels_viewer.panels.plan_panel import CROWD, PlanPanel, bodies_svg, floor_svg, frame
from intellwheels_viewer.snapshot import Sample
from tests.every_case import every_case
from tests.viewer.panels import made_up
from tests.viewer.panels.panel import Calls, enter


@every_case("name", library.names("floors"))
def test_all_of_a_floor_is_in_its_frame(name: str) -> None:
    floor = library.floor(name)
    view = frame(floor)
    for wall in floor.wall:
        for corner in wall.corner:
            assert view.west < corner.x < view.west + view.across
            assert view.north - view.down < corner.y < view.north
    assert 1.15 - 1e-9 <= view.across / view.down <= 2.6 + 1e-9


def test_an_empty_floor_has_a_frame() -> None:
    assert frame(Map(format="iw.v1", name="empty")).across > 1


def test_scale_is_a_round_length_of_at_most_a_quarter() -> None:
    square = tuple(Corner(x=x, y=y) for x, y in ((0, 0), (9.4, 0), (9.4, 8), (0, 8)))
    page = floor_svg(Map(format="iw.v1", name="room", wall=(Wall(thickness=0.1, corner=square),)))
    assert "width:20.00%" in page
    assert "2 m</div>" in page


def test_both_drawings_are_well_formed_and_have_one_view_box() -> None:
    floor = made_up.snapshot().floor
    assert floor is not None
    drawn = [floor_svg(floor), bodies_svg(made_up.snapshot(), made_up.choices())]
    for one in drawn:
        ElementTree.fromstring(one)
    assert len({match[1] for one in drawn if (match := re.search(r'viewBox="([^"]*)"', one))}) == 1


def test_the_drawing_has_no_text_that_shrinks_with_it() -> None:
    assert "<text" not in bodies_svg(made_up.snapshot(), made_up.choices())


def test_a_body_stands_where_the_state_says_in_its_colour() -> None:
    page = bodies_svg(made_up.snapshot(), made_up.choices())
    group = re.search(r'<g data-agent="chair4".*?</g>', page)
    assert group is not None
    points = re.findall(r"(-?[\d.]+),(-?[\d.]+)", group[0].split("</polygon>")[0].split("/>")[0])
    entity = made_up.snapshot().entity("chair4")
    assert entity is not None
    # The centre of movement of this chair is 0.42 of its length from the rear.
    rear = [(float(x), -float(y)) for x, y in (points[0], points[3])]
    front = [(float(x), -float(y)) for x, y in points[1:3]]
    x = sum(x for x, _ in rear) / 2 * 0.58 + sum(x for x, _ in front) / 2 * 0.42
    y = sum(y for _, y in rear) / 2 * 0.58 + sum(y for _, y in front) / 2 * 0.42
    assert (x, y) == pytest.approx((entity.x, entity.y), abs=0.02)
    assert f'fill="{css(colour_of("chair4"))}"' in group[0]


def test_only_the_selected_one_has_a_ring() -> None:
    page = bodies_svg(made_up.snapshot(), made_up.choices())
    assert page.count("iw-ring") == 1
    assert page.index("iw-ring") > page.index('data-agent="chair2"')
    assert "iw-ring" not in bodies_svg(made_up.snapshot(), replace(made_up.choices(), selected=None))


def test_a_body_that_touches_is_edged_in_red_and_a_stale_one_is_faded() -> None:
    page = bodies_svg(made_up.snapshot(), made_up.choices())
    assert page.count('stroke="var(--iw-red)"') == 1
    assert page.count('opacity=".4"') == 1


def test_a_trail_is_twenty_seconds_long_and_its_corners_stay() -> None:
    history = tuple(Sample(k / 20, k / 20, 0.0, 0.0, 1.0) for k in range(601))
    snapshot = replace(made_up.snapshot(), history={"chair1": history}, time=30.0)
    later = replace(snapshot, history={"chair1": history[:-3]}, time=history[-4].time)
    lines = [re.search(r'polyline points="([^"]*)"', bodies_svg(one, made_up.choices())) for one in (snapshot, later)]
    points = [line[1].split() for line in lines if line]
    assert float(points[0][0].split(",")[0]) == pytest.approx(10.5)
    assert points[0][:-2] == [point for point in points[1][:-1] if float(point.split(",")[0]) >= 10.5]


def test_a_crowd_is_few_paths_and_the_selected_one() -> None:
    base = made_up.snapshot()
    names = [f"c{k}" for k in range(1000)]
    crowd = replace(
        base,
        entities=tuple(Entity(name=name, x=k / 50, y=0.0, heading=0.1 * k) for k, name in enumerate(names)),
        bodies=dict.fromkeys(names, base.bodies["chair1"]),
        history={},
    )
    page = bodies_svg(crowd, replace(made_up.choices(), looks=looks(names), selected="c7"))
    assert len(base.entities) < CROWD < 1000
    assert (page.count("<path"), page.count("<g ")) == (len(COLOURS), 1)
    assert len(page) < 60_000


def test_words_of_a_peer_are_text() -> None:
    assert "<img" not in bodies_svg(made_up.hostile(), made_up.attacked())


def test_the_floor_is_sent_once_and_a_press_selects_who_is_there(gui: viser.GuiApi, calls: Calls) -> None:
    panel = PlanPanel(gui, calls.to("select"))
    panel.show(made_up.nothing("no-router"), made_up.choices())
    assert not panel._floor.visible
    panel.show(made_up.snapshot(), made_up.choices())
    assert panel._floor.visible
    drawn = panel._floor.content
    panel.show(made_up.snapshot(), replace(made_up.choices(), selected=None))
    assert panel._floor.content is drawn
    enter(panel._pick._field, "chair2")
    enter(panel._pick._field, "stranger")
    assert calls == [("select", "chair2")]
    panel.show(made_up.snapshot(), made_up.choices(), visible=False)
    assert not panel._bodies.visible
