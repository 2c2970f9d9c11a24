"""Lidar readings: a point for each ray that hit something, at the height of the sensor."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping

import numpy as np
import viser

from intellwheels_schemas.messages import Body, Entity, Lidar, LidarReading, Measures
from intellwheels_viewer import palette
from intellwheels_viewer.drawings.solids import Array
from intellwheels_viewer.drawings.wedges import mount_frame, mounted
from intellwheels_viewer.range_bands import MIDDLE, NEAR


def points(sensor: Lidar, reading: LidarReading, body: Body, entity: Entity) -> tuple[Array, Array]:
    """Return the hits (N, 3) in the world frame, in metres, and their ranges (N,). Rays without a hit are left out.

    The angle of a ray is `StartDeg` + index x `StepDeg`, anticlockwise from the x axis of the body, not of the sensor.
    """
    frame = mount_frame(sensor, body, entity)
    if frame is None:
        return np.zeros((0, 3), np.float32), np.zeros(0, np.float32)
    x, y, _ = mounted(sensor, frame)
    ranges = np.array([math.nan if each is None else each for each in reading.ranges], np.float64)
    angles = frame.heading + np.radians(reading.start_deg + reading.step_deg * np.arange(len(ranges)))
    hits = np.column_stack([x + ranges * np.cos(angles), y + ranges * np.sin(angles), np.full(len(ranges), sensor.z)])
    there = np.isfinite(ranges)
    return hits[there].astype(np.float32), ranges[there].astype(np.float32)


def cloud(
    bodies: Mapping[str, Body], entities: Iterable[Entity], measures: Mapping[str, Measures], agents: Collection[str]
) -> tuple[Array, Array]:
    """Return the lidar hits of some agents (N, 3) and their colours (N, 3) in sRGB bytes, the same as for wedges."""
    hits, ranges = [np.zeros((0, 3), np.float32)], [np.zeros(0, np.float32)]
    for entity in entities:
        body, measured = bodies.get(entity.name), measures.get(entity.name)
        if entity.name not in agents or body is None or measured is None or measured.sensors is None:
            continue
        readings = {reading.id: reading for reading in measured.sensors.lidar}
        for sensor in body.robot.lidar:
            if sensor.id in readings:
                found, far = points(sensor, readings[sensor.id], body, entity)
                hits.append(found)
                ranges.append(far)
    distance = np.concatenate(ranges)
    band = np.digitize(distance, (NEAR, MIDDLE))
    tints = np.array((palette.NEAR, palette.MIDDLE, palette.FAR), np.float32)
    return np.concatenate(hits), tints[band]


class Lidars:
    """The hits in a scene, as one point cloud."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self._cloud: viser.PointCloudHandle | None = None

    def show(
        self,
        bodies: Mapping[str, Body],
        entities: Iterable[Entity],
        measures: Mapping[str, Measures],
        agents: Collection[str],
    ) -> None:
        """Show the hits of some agents; the arguments are those of `Wedges.show`."""
        hits, tints = cloud(bodies, entities, measures, agents)
        colours = tints.astype(np.uint8)
        if self._cloud is not None:
            self._cloud.visible = bool(len(hits))
            if len(hits):
                self._cloud.points, self._cloud.colors = hits, colours
        elif len(hits):
            self._cloud = self._scene.add_point_cloud(
                "/lidar/points",
                hits,
                colours,
                point_size=0.035,
                point_shape="circle",
                precision="float32",
                point_shading="flat",
            )
