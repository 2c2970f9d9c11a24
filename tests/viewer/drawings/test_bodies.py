from __future__ import annotations

import asyncio
import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import viser

from intellwheels_schemas.messages import Body
from intellwheels_viewer import palette
from intellwheels_viewer.drawings.bodies import Bodies, grouped, pose_arrays, tints
from intellwheels_viewer.drawings.body_documents import BodyDocuments
from intellwheels_viewer.palette import Colours
from tests.viewer.drawings.cast import body, entity, node, triangles

CAST: dict[str, Body] = {
    "a": body("rear-wheel"),
    "b": body("rear-wheel", motor_noise=0.1),
    "c": body("mid-wheel"),
    "table": body("table"),
}
FORMS = BodyDocuments().of(CAST, crowd=False)
LOOK = "/bodies/0-wheelchair"


def test_bodies_that_look_alike_are_one_group_in_the_order_of_the_state() -> None:
    groups = grouped(FORMS, [entity("b"), entity("c"), entity("a"), entity("unknown")])
    assert [[each.name for each in group] for group in groups.values()] == [["b", "a"], ["c"]]


def test_bodies_as_arrays_have_the_poses_of_the_state() -> None:
    placed = pose_arrays([entity("a", 1.25, -2.5, 0.5)], lambda _: (1, 2, 3))
    assert placed.positions.tolist() == [[1.25, -2.5, 0.0]]
    assert placed.headings.tolist() == [0.5]
    assert placed.colours.tolist() == [[1, 2, 3]]


def test_a_tint_lies_under_the_footprint_not_under_the_centre_of_movement() -> None:
    placed, sizes = tints(FORMS, [entity("a", 1.0, 2.0, math.pi / 2), entity("table")], lambda _: (0, 0, 0))
    assert placed.names == ("a",)
    assert placed.positions[0] == pytest.approx([1.0, 2.3003, 0.0], abs=1e-4)
    assert sizes[0] == pytest.approx([1.1, 0.62, 1.0])


def test_a_pose_reaches_the_scene_to_a_hundred_thousandth(scene: viser.SceneApi) -> None:
    bodies = Bodies(scene)
    bodies.show(CAST, [entity("a", 12.345678, -3.2109876, 1.2345678), entity("c")], Colours())
    handle = node(scene, f"{LOOK}/paint")
    assert handle.batched_positions[0] == pytest.approx([12.345678, -3.2109876, 0.0], abs=1e-5)
    turn = 2 * math.atan2(handle.batched_wxyzs[0][3], handle.batched_wxyzs[0][0])
    assert turn == pytest.approx(1.2345678, abs=1e-5)


def test_nodes_are_kept_while_bodies_come_and_go(scene: viser.SceneApi) -> None:
    bodies, colours = Bodies(scene), Colours()
    bodies.show(CAST, [entity("a"), entity("b")], colours)
    paint = node(scene, f"{LOOK}/paint")
    bodies.show(CAST, [entity("c")], colours)
    assert not paint.visible
    bodies.show(CAST, [entity("b")], colours)
    assert node(scene, f"{LOOK}/paint") is paint
    assert paint.visible
    assert bodies.names[f"{LOOK}/paint"] == ("b",)


def test_what_touches_has_a_red_footprint_and_keeps_its_paint(scene: viser.SceneApi) -> None:
    bodies, colours = Bodies(scene), Colours()
    bodies.show(CAST, [entity("a", contact=True), entity("table", contact=True)], colours)
    red = palette.light_bytes([palette.CONTACT]).tolist()
    assert node(scene, f"{LOOK}/outline").batched_colors.tolist() == red
    assert node(scene, "/bodies/contact").batched_positions.shape == (2, 3)
    assert node(scene, f"{LOOK}/paint").batched_colors.tolist() == palette.light_bytes([colours.rgb("a")]).tolist()


def test_what_is_stale_is_faded(scene: viser.SceneApi) -> None:
    bodies = Bodies(scene)
    bodies.show(CAST, [entity("a"), entity("b")], Colours(), {"b"})
    assert bodies.names[f"{LOOK}/paint"] == ("a",)
    assert bodies.names[f"{LOOK}/stale/paint"] == ("b",)
    assert node(scene, f"{LOOK}/stale/paint").opacity == 0.35


def test_the_selected_has_the_ring_and_nobody_else(scene: viser.SceneApi) -> None:
    bodies = Bodies(scene)
    bodies.show(CAST, [entity("a", 3.0), entity("b")], Colours(), selected="a")
    ring = node(scene, "/bodies/selection/ring")
    assert ring.position == pytest.approx([3.3003, 0.0, 0.0])
    bodies.show(CAST, [entity("b")], Colours(), selected="a")
    assert not ring.visible


def test_an_agent_of_a_repeated_colour_has_stripes(scene: viser.SceneApi) -> None:
    many = {f"a{index}": body("rear-wheel") for index in range(1, 27)}
    Bodies(scene).show(many, [entity(name) for name in many], Colours())
    assert node(scene, "/bodies/stripes").batched_positions.shape == (12 + 2 * 2, 3)


def test_a_crowd_is_drawn_with_few_triangles(scene: viser.SceneApi) -> None:
    many = {f"a{index}": body("rear-wheel") for index in range(50)}
    bodies = Bodies(scene)
    bodies.show(many, [entity(name) for name in many], Colours())
    assert sum(triangles(node(scene, f"{LOOK}/{part}")) for part in ("paint", "trim")) <= 600
    assert len(bodies.names[f"{LOOK}/paint"]) == 50


def fire(handle: Any, kind: str, **fields: Any) -> None:
    """Call what viser would call for an event."""
    for entry in handle._impl.click_cb if kind == "click" else handle._impl.drag_cb:
        asyncio.run(entry.callback(SimpleNamespace(**fields)))


def test_a_click_names_the_body_also_when_it_was_asked_for_before_there_were_any(scene: viser.SceneApi) -> None:
    bodies, picked = Bodies(scene), list[str]()
    bodies.on_pick(lambda name, event: picked.append(name))
    bodies.show(CAST, [entity("b"), entity("a")], Colours())
    fire(node(scene, f"{LOOK}/trim"), "click", instance_index=1)
    fire(node(scene, "/bodies/tint"), "click", instance_index=0)
    fire(node(scene, f"{LOOK}/trim"), "click", instance_index=7)
    assert picked == ["a", "b"]


def test_a_drag_names_the_body_it_began_on_to_its_end(scene: viser.SceneApi) -> None:
    bodies, dragged = Bodies(scene), list[tuple[str, str]]()
    bodies.show(CAST, [entity("b"), entity("a")], Colours())
    bodies.on_drag(lambda name, event: dragged.append((name, event.phase)))
    paint = node(scene, f"{LOOK}/paint")
    fire(paint, "drag", phase="start", instance_index=1, client_id=4)
    bodies.show(CAST, [entity("a")], Colours())
    fire(paint, "drag", phase="update", instance_index=1, client_id=4)
    fire(paint, "drag", phase="end", instance_index=1, client_id=4)
    fire(paint, "drag", phase="update", instance_index=1, client_id=4)
    assert dragged == [("a", "start"), ("a", "update"), ("a", "end")]


def test_doors_are_cut_as_walls_are_unless_told_otherwise(scene: viser.SceneApi) -> None:
    cast = {"door": body("door")}
    Bodies(scene).show(cast, [entity("door")], Colours())
    Bodies(scene, name="/tall", cut=None).show(cast, [entity("door")], Colours())
    assert float(np.max(node(scene, "/bodies/0-door/paint").vertices[:, 2])) == pytest.approx(1.1)
    assert float(np.max(node(scene, "/tall/0-door/paint").vertices[:, 2])) == pytest.approx(2.0)
