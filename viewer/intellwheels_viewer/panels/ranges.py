"""Ranges in words and tones: near, middle and far, with the same bands as the wedges in the scene.

"Nothing seen" and a failure are not ranges, so they are shown as words.
"""

from __future__ import annotations

from typing import Final, Literal, TypeAlias

from intellwheels_schemas.messages import Body, Measures, Status
from intellwheels_viewer.range_bands import MIDDLE, NEAR
from intellwheels_viewer.snapshot import Snapshot

Tone: TypeAlias = Literal["near", "middle", "far"]

WORDS: Final[dict[Status, str]] = {"ok": "", "none": "nothing seen", "near": "too near", "fault": "failed"}


def tone(distance: float) -> Tone:
    """Return the band of a range in metres."""
    if distance < NEAR:
        return "near"
    return "middle" if distance < MIDDLE else "far"


def nearest(snapshot: Snapshot, name: str) -> float | None:
    """Return the smallest range of an agent's sensors in metres; None if they see nothing or there are none.

    An object below the minimum range of a sensor counts as that range. Agents without subscribed measures use the
    newest sample of their history.
    """
    measures = snapshot.measures.get(name)
    if measures is not None and measures.sensors is not None:
        found = _distances(measures, snapshot.bodies.get(name))
    else:
        history = snapshot.history.get(name, ())
        found = [value for value in history[-1].ranges if value is not None] if history else []
    return min(found, default=None)


def _distances(measures: Measures, body: Body | None) -> list[float]:
    sensors = measures.sensors
    if sensors is None:
        return []
    least: dict[str, float] = {}
    if body is not None:
        least.update((one.id, one.min_range) for one in body.robot.proximity)
        least.update((one.id, one.min_range) for one in body.robot.lidar)
    found = [one.value for one in sensors.proximity if one.value is not None]
    found += [least.get(one.id, 0.0) for one in sensors.proximity if one.status == "near"]
    for lidar in sensors.lidar:
        found += [value for value in lidar.ranges if value is not None]
        found += [least.get(lidar.id, 0.0) for status in lidar.statuses if status == "near"]
    return found
