"""Distances in words and tones: near, middle, far, as the wedges in the scene have them.

Nothing seen is not a distance, and neither is a failure: both are words.
"""

from __future__ import annotations

from typing import Final, Literal, TypeAlias

from intellwheels_schemas.messages import Body, Measures, Status
from intellwheels_viewer.snapshot import Snapshot

Tone: TypeAlias = Literal["near", "middle", "far"]

NEAR: Final = 0.6
"""m: about a footrest's swing; what is nearer is met by turning on the spot."""
MIDDLE: Final = 1.5
"""m: what a chair at a walking pace reaches in about a second."""

WORDS: Final[dict[Status, str]] = {"ok": "", "none": "nothing seen", "near": "too near", "fault": "failed"}


def tone(distance: float) -> Tone:
    """Return how near a distance in m is."""
    if distance < NEAR:
        return "near"
    return "middle" if distance < MIDDLE else "far"


def nearest(seen: Snapshot, name: str) -> float | None:
    """Return the smallest distance in m that an agent's sensors see; None: they see nothing, or there are none.

    What is nearer than a sensor's range counts as its least. The newest measures where they are watched, else the
    newest that were kept for plots.
    """
    measures = seen.measures.get(name)
    if measures is not None and measures.sensors is not None:
        found = _distances(measures, seen.bodies.get(name))
    else:
        history = seen.history.get(name, ())
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
