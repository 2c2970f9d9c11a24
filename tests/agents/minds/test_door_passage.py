"""Which sensor range lets a chair through an automatic door: the simulated world against swept polygons."""

from __future__ import annotations

import math

import pytest
from shapely import affinity
from shapely.geometry import Polygon, box

from intellwheels_schemas.messages import Position
from tests.agents.arena import Arena

HINGE = (6.0, -0.49)
SPEED = 0.5
OPENING = 5.0
LATENCY = 0.15
FRONT = 1.10 - 1.10 * 0.227
"""Distance from the centre of movement of the rear-wheel chair to its front edge, m."""


def leaf(angle: float) -> Polygon:
    """Return the leaf, 1.0 x 0.1 m and hinged 1 cm from one end, turned by an angle from closed."""
    closed = box(-0.05, -0.01, 0.05, 0.99)
    return affinity.translate(affinity.rotate(closed, angle, origin=(0.0, 0.0), use_radians=True), *HINGE)


def touches(swing: str, metres: float, y: float) -> bool:
    """Return whether the chair touches the leaf, by polygons every 10 ms.

    The leaf begins to turn a latency after the chair's front is so near to the frame, and turns evenly.
    """
    sign = 1.0 if swing == "left" else -1.0
    seen = 0.0
    for step in range(2000):
        time = step * 0.01
        front = 6.0 - 0.05 - metres + SPEED * (time - seen)
        share = min(max(time - seen - LATENCY, 0.0) / OPENING, 1.0)
        chair = box(front - 1.10, y - 0.31, front, y + 0.31)
        if chair.intersection(leaf(sign * share * math.pi / 2.0)).area > 0.0:
            return True
        if front - 1.10 > 7.1:
            break
    return False


def arena_with_door(swing: str, metres: float) -> Arena:
    arena = Arena("door")
    options = {"swing": swing, "time": str(OPENING), "Proximity.MaxRange": str(metres), "Proximity.ConeDeg": "20"}
    arena.join("door", "door", "door", "hinge", options)
    return arena


def drive(arena: Arena, y: float, **options: str) -> None:
    arena.join("chair", "drive", "rear-wheel", None, options, Position(x=-2.0, y=y, heading=0.0))


@pytest.mark.parametrize("y", [-0.1, 0.0, 0.1])
@pytest.mark.parametrize(
    ("swing", "metres", "passes"),
    [("right", 3.0, True), ("right", 1.0, False), ("left", 3.6, True), ("left", 3.0, False)],
)
def test_door_range_lets_the_chair_through_as_swept_polygons_predict(
    swing: str, metres: float, passes: bool, y: float
) -> None:
    assert touches(swing, metres, y) is not passes
    arena = arena_with_door(swing, metres)
    drive(arena, y, left=str(SPEED), right=str(SPEED))
    arena.run(30.0, lambda arena: arena.paths["chair"][-1][0] > 9.0)
    assert bool(arena.contacts()) is not passes
    opened = next(tick for tick, words in arena.said["door"] if words == "door opening")
    # It was detected at the sensor range less 0.05 m (`NEARER`), to within the way it drives during the latency.
    assert arena.paths["chair"][opened][0] + FRONT == pytest.approx(5.95 - metres + 0.05, abs=SPEED * LATENCY)


def test_door_never_closes_on_a_chair_in_the_doorway() -> None:
    arena = arena_with_door("right", 3.0)
    # 8 m to the doorway at 0.5 m/s, then half a minute's rest in it.
    drive(arena, 0.0, script="0:0.5,0.5; 15.6:0,0; 50:0.5,0.5; 60:0,0")
    arena.run(50.0)
    assert arena.paths["chair"][-1][0] + FRONT > HINGE[0] > arena.paths["chair"][-1][0] + FRONT - 1.10
    assert [words for _, words in arena.said["door"]] == ["door closed", "door opening", "door open"]
    arena.run(30.0)
    assert [words for _, words in arena.said["door"]][-2:] == ["door closing", "door closed"]
    assert arena.contacts() == []


def test_door_opens_when_it_hears_open() -> None:
    arena = arena_with_door("right", 0.3)
    arena.join("chair", "drive", "rear-wheel", None, {"say": "open"}, Position(x=3.5, y=0.0, heading=0.0))
    arena.run(8.0)
    assert [words for _, words in arena.said["door"]][:3] == ["door closed", "door opening", "door open"]
