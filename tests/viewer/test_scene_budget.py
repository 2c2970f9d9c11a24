"""What a crowded ward costs to draw: counted from what viser is given, without a browser."""

from __future__ import annotations

import math
from typing import Any

import pytest
import viser

from intellwheels_maps import library
from intellwheels_schemas.messages import Body, Entity
from intellwheels_viewer.snapshot import Snapshot
from intellwheels_viewer.stage import Stage
from tests.viewer.drawings.cast import RUN, robot, triangles
from tests.viewer.wire import entity

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")

WARD = library.floor("ward")


def crowded() -> Snapshot:
    """Return a ward with 30 agents: 24 chairs of three models with somebody in them, 5 people and a door."""
    assert WARD.grid is not None
    places = [place for place in WARD.grid.position if "wheelchair" in place.kinds][:29]
    bodies: dict[str, Body] = {}
    entities: list[Entity] = []
    for number, place in enumerate(places):
        kind = "person" if number % 6 == 5 else ("rear-wheel", "mid-wheel", "intellwheels")[number % 3]
        name = f"a{number}"
        bodies[name] = Body(run=RUN, tick=0, roles=("both",), robot=robot(kind))
        entities.append(entity(name, place.x, place.y, heading=math.radians(place.heading_deg)))
    bodies["door"] = Body(run=RUN, tick=0, roles=("both",), robot=robot("door"))
    entities.append(entity("door", -0.1, -0.49))
    return Snapshot(phase="live", run=RUN, tick=1, floor=WARD, revision=0, bodies=bodies, entities=tuple(entities))


def primitives(handle: Any) -> int:
    """Return how often a node is drawn for one picture, without shadows."""
    props = handle._impl.props
    return props.glb_data.count(b'"attributes"') if hasattr(props, "glb_data") else 1


def test_a_ward_of_thirty_has_at_most_150_thousand_triangles_and_150_draw_calls(pages: viser.ViserServer) -> None:
    Stage(pages).show(crowded(), ())
    nodes = [each for each in pages.scene._handle_from_node_name.values() if each.visible]
    drawn = [(each, triangles(each) * len(getattr(each, "batched_positions", (0,)))) for each in nodes]
    assert sum(count for _, count in drawn) <= 150_000
    assert sum(primitives(each) for each, count in drawn if count) <= 150
    pages.scene.reset()


def test_only_what_stands_casts_a_shadow(pages: viser.ViserServer) -> None:
    Stage(pages).show(crowded(), ())
    nodes = pages.scene._handle_from_node_name
    casting = {name for name, each in nodes.items() if getattr(each._impl.props, "cast_shadow", False)}
    flat = ("/outline", "/tint", "/contact", "/stripes")
    assert any(name.endswith("/paint") for name in casting)
    assert not [name for name in casting if name.endswith(flat) or name.startswith(("/floor", "/goals", "/labels"))]
    pages.scene.reset()
