"""Clearances are never larger than the distance that shapely finds, and have its sign."""

from __future__ import annotations

import random

import numpy as np
import pytest
import shapely
from shapely import affinity

from intellwheels_agents.navigation.footprint_clearance import (
    BORDER,
    CUTOFF,
    Solid,
    boxes_of,
    clearances,
    covering,
    frame_of,
    hidden_points,
    points_along,
    solids_of,
)
from intellwheels_agents.navigation.lattice import ANGLES, COUNT
from intellwheels_maps import floor, robot
from intellwheels_schemas.messages import Corner, Map, Obstacle, Part, Robot
from tests.agents.navigation.rooms import CHAIR, room


def polygons(document: Map, bottom: float, top: float) -> shapely.Geometry:
    solids = [one for one in solids_of(document) if one.bottom < top and bottom < one.top]
    return shapely.union_all([shapely.Polygon(one.corners) for one in solids])


@pytest.mark.parametrize("name", ["rear-wheel", "mid-wheel", "front-wheel", "intellwheels"])
def test_clearance_agrees_with_shapely(name: str) -> None:
    document, body = floor("ward"), robot(name)
    frame = frame_of(document, 0.1)
    field = clearances(frame, solids_of(document), boxes_of(body))
    things = [(part, polygons(document, part.bottom, part.top)) for part in body.part]
    for _, thing in things:
        shapely.prepare(thing)
    draw = random.Random(name)
    for _ in range(1500):
        k, j, i = (
            draw.randrange(COUNT),
            draw.randrange(BORDER, frame.rows - BORDER),
            draw.randrange(BORDER, frame.columns - BORDER),
        )
        x, y = frame.x + 0.1 * i, frame.y + 0.1 * j
        off = np.inf
        for part, thing in things:
            half_l, half_w = part.length / 2.0, part.width / 2.0
            box = shapely.box(part.x - half_l, part.y - half_w, part.x + half_l, part.y + half_w)
            placed = affinity.translate(affinity.rotate(box, ANGLES[k], origin=(0.0, 0.0), use_radians=True), x, y)
            off = min(off, placed.distance(thing))
        found = float(field[k, j, i])
        assert found <= off + 1e-6
        if off > 0.0:
            # At a corner the gap along the axes is shorter than the distance.
            assert found > 0.0
            assert found >= min(CUTOFF, off / 2.0**0.5) - 1e-6
        else:
            assert found <= 1e-6


def test_part_above_meets_what_the_base_passes_under() -> None:
    table = Obstacle(
        name="top", bottom=0.7, top=0.75, corner=tuple(Corner(x=x, y=y) for x, y in ((2, 2), (4, 2), (4, 4), (2, 4)))
    )
    document = Map(format="iw.v1", name="t", obstacle=(table,))
    frame = frame_of(document, 0.1)
    j, i = round((3.0 - frame.y) / 0.1), round((1.7 - frame.x) / 0.1)
    low = Robot(part=(Part(x=0.0, y=0.0, length=1.0, width=0.6, bottom=0.0, top=0.5),))
    high = Robot(part=(*low.part, Part(x=0.0, y=0.0, length=0.4, width=0.4, bottom=0.5, top=1.2)))
    found = [clearances(frame, solids_of(document), boxes_of(body))[0, j, i] for body in (low, high)]
    assert found == pytest.approx([CUTOFF, 0.1], abs=1e-6)


def test_covered_boxes_do_not_count() -> None:
    boxes = boxes_of(CHAIR)
    assert covering(boxes) == boxes[:1]
    assert covering([boxes[0], boxes[0]._replace(bottom=0.6, top=0.9)])[0].bottom == 0.6


def test_points_on_an_outline_are_near_each_other() -> None:
    points = points_along(Solid(((0.0, 0.0), (1.0, 0.0), (1.0, 1.0)), 0.0, 1.0), 0.1)
    steps = np.diff(np.concatenate([points, points[:1]]), axis=0)
    assert np.sqrt((steps**2).sum(axis=1)).max() <= 0.1 + 1e-9


def test_what_no_sensor_sees_is_taken_from_the_map() -> None:
    solids = solids_of(room((1.0, 1.0, 2.0, 2.0)))
    assert hidden_points(solids, boxes_of(CHAIR), 0.3).shape == (0, 2)
    assert hidden_points(solids, boxes_of(CHAIR), None).shape[0] > 100
    only_box = hidden_points(solids, boxes_of(CHAIR), 1.2)
    assert only_box.min() >= 1.0
    assert only_box.max() <= 2.0
