"""Arcs that the map explains do not count; others do until a sensor sees past them, or they are old."""

from __future__ import annotations

import numpy as np

from intellwheels_agents.navigation.cone_points import KEPT, ConePoints
from intellwheels_agents.navigation.footprint_clearance import solids_of
from intellwheels_agents.navigation.map_distance import MapDistance
from intellwheels_schemas.messages import Measures, Proximity, ProximityReading, Robot, Sensors
from tests.agents.kinematics import RUN
from tests.agents.navigation.rooms import room

CONE = Proximity(id="front", x=0.5, y=0.0, z=0.3, direction_deg=0.0, cone_deg=20.0, max_range=4.0)
FIELD = MapDistance(solids_of(room()), 0.3)
POSE = (3.0, 3.0, 0.0)


def seen(points: ConePoints, tick: int, metres: float | None, of: int | None = None) -> np.ndarray:
    status = "ok" if metres is not None else "none"
    reading = ProximityReading(id="front", value=metres, status=status, tick=of)  # type: ignore[arg-type]
    measures = Measures(run=RUN, tick=tick, time=0.05 * tick, sensors=Sensors(proximity=(reading,)))
    return points.update(measures, dict.fromkeys(range(tick + 1), POSE))


def test_arc_that_the_map_explains_is_no_obstacle() -> None:
    points = ConePoints(Robot(proximity=(CONE,)), FIELD)
    assert seen(points, 1, 2.45).shape == (0, 2)


def test_other_arc_counts_until_the_sensor_sees_past_it() -> None:
    points = ConePoints(Robot(proximity=(CONE,)), FIELD)
    arc = seen(points, 1, 1.0)
    assert arc.shape[0] > 3
    assert np.abs(np.sqrt((arc[:, 0] - 3.5) ** 2 + (arc[:, 1] - 3.0) ** 2) - 1.0).max() < 1e-9
    assert seen(points, 2, 0.6).shape[0] > arc.shape[0]
    assert seen(points, 3, None).shape[0] <= 4  # the ends of the arcs are on the edge of the cone


def test_arc_is_forgotten_after_a_while_and_a_repeated_reading_counts_once() -> None:
    points = ConePoints(Robot(proximity=(CONE,)), FIELD)
    first = seen(points, 1, 1.0)
    assert seen(points, 2, 1.0, of=1).shape[0] == 2 * first.shape[0] or seen(points, 2, 1.0, of=1).shape == first.shape
    silent = Measures(run=RUN, tick=999, time=1.0 + KEPT, sensors=None)
    assert points.update(silent, {}).shape == (0, 2)
