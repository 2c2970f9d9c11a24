"""What proximity sensors see that is not on the map, as points, remembered while no sensor looks there.

A reading is an arc: its obstacle is somewhere on it. If the map has something on the arc, that is what was seen.
Otherwise the whole arc counts, until a sensor sees past it or it is old.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final

import numpy as np

from intellwheels_agents.navigation.array_angles import Floats, sines
from intellwheels_agents.navigation.map_distance import MapDistance
from intellwheels_agents.navigation.scan_points import Pose, into_body, into_map
from intellwheels_agents.portable_math import sincos
from intellwheels_agents.range_scan import distance
from intellwheels_schemas.messages import Measures, Proximity, Robot

ON_MAP: Final = 0.2
"""An arc that comes so near to something on the map shows that, m: the pose is not exact."""
FARTHEST: Final = 2.5
"""Longest reading that counts, m."""
SPACING: Final = 0.08
"""Distance between the points of an arc, m."""
SEEN_PAST: Final = 0.15
"""How far beyond a point a sensor must see for the point to be gone, m."""
KEPT: Final = 12.0
"""Time for which a point is remembered, s."""


class ConePoints:
    """The remembered points."""

    def __init__(self, robot: Robot, field: MapDistance) -> None:
        """Take the proximity sensors that move with the body, and the map at their height."""
        self._sensors: dict[str, Proximity] = {one.id: one for one in robot.proximity if one.mount == "body"}
        self._fans = {name: _fan(sensor) for name, sensor in self._sensors.items()}
        self._field = field
        self._points = np.zeros((0, 3))
        self._taken: dict[str, int] = {}

    def update(self, measures: Measures, poses: Mapping[int, Pose]) -> Floats:
        """Return the points in the map, m, after the readings of a tick; `poses` are those of the last ticks."""
        if self._points.shape[0]:
            self._points = self._points[measures.time - self._points[:, 2] <= KEPT]
        added = []
        for reading in measures.sensors.proximity if measures.sensors else ():
            sensor = self._sensors.get(reading.id)
            tick = measures.tick if reading.tick is None else reading.tick
            pose = poses.get(tick)
            if sensor is None or pose is None or self._taken.get(reading.id) == tick:
                continue
            metres = distance(reading, sensor)
            if metres is None:
                continue
            self._taken[reading.id] = tick
            self._clear(sensor, min(metres, sensor.max_range), pose)
            if metres <= min(FARTHEST, sensor.max_range):
                ahead, aside = self._fans[sensor.id]
                arc = into_map(np.stack([sensor.x + metres * ahead, sensor.y + metres * aside], axis=1), pose)
                if float(self._field.at(arc[:, 0], arc[:, 1]).min()) > ON_MAP:
                    added.append(np.concatenate([arc, np.full((arc.shape[0], 1), measures.time)], axis=1))
        if added:
            self._points = np.concatenate([self._points, *added])[-600:]
        return self._points[:, :2]

    def _clear(self, sensor: Proximity, metres: float, pose: Pose) -> None:
        """Forget the points that a sensor sees past."""
        if not self._points.shape[0]:
            return
        body = into_body(self._points, pose)
        s, c = sincos(sensor.direction_deg * math.pi / 180.0)
        dx, dy = body[:, 0] - sensor.x, body[:, 1] - sensor.y
        along, across = c * dx + s * dy, np.abs(c * dy - s * dx)
        off = np.sqrt(dx * dx + dy * dy)
        half_sine, half_cosine = sincos(min(sensor.cone_deg / 2.0, 89.0) * math.pi / 180.0)
        inside = across * half_cosine < along * half_sine
        self._points = self._points[~(inside & (off < metres - SEEN_PAST))]


def _fan(sensor: Proximity) -> tuple[Floats, Floats]:
    """Return the cosines and sines of the directions of an arc's points, in the body's frame."""
    width = sensor.cone_deg * math.pi / 180.0
    count = max(2, int(width * min(FARTHEST, sensor.max_range) / SPACING) + 2)
    s, c = sines((sensor.direction_deg * math.pi / 180.0) + width * (np.arange(count) / (count - 1) - 0.5))
    return c, s
