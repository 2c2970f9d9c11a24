"""Contacts: a red flash at the point of contact, which grows and fades within half a second of simulated time."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

import viser

from intellwheels_schemas.messages import Event
from intellwheels_viewer import palette
from intellwheels_viewer.drawings.instance_batch import InstanceBatch, quaternions
from intellwheels_viewer.drawings.solids import Solid, ball, loft

FADE: Final = 0.5
"""Duration of a flash, in simulated seconds."""
HEIGHT: Final = 0.55
"""Height of a flash, in metres: above the wheels and below the armrests."""


@dataclass(frozen=True)
class Flash:
    """A flash: its position in metres, and the share of its duration that is left, 1 to 0."""

    x: float
    y: float
    left: float


def flashes(events: Iterable[Event], tick: int, period: float) -> list[Flash]:
    """Return the flashes at a tick, oldest first.

    Args:
        events: The events of the run. Contacts with a position flash.
        tick: The tick of the newest state.
        period: Simulated seconds of a tick.
    """
    made = []
    for event in events:
        age = (tick - event.tick) * period
        if event.code == "contact" and event.x is not None and event.y is not None and 0.0 <= age < FADE:
            made.append(Flash(event.x, event.y, 1.0 - age / FADE))
    return made


def star(points: int = 8, outer: float = 0.28, inner: float = 0.11) -> Solid:
    """Return a thin horizontal star with a ball in its centre."""
    rim = []
    for index in range(2 * points):
        angle, reach = math.pi * index / points, inner if index % 2 else outer
        rim.append((reach * math.cos(angle), reach * math.sin(angle)))
    rings = [[(0.1 * x, 0.1 * y, z) if z else (x, y, 0.0) for x, y in rim] for z in (-0.07, 0.0, 0.07)]
    return loft(rings) + ball(0.0, 0.0, 0.0, 0.11, 10)


class Contacts:
    """The flashes in a scene, one node."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._stars = InstanceBatch(scene, "/contacts", star(), opacity=1.0)

    def show(self, events: Iterable[Event], tick: int, period: float) -> None:
        """Show the flashes at a tick; the arguments are those of `flashes`."""
        shown = flashes(events, tick, period)
        self._stars.show(
            [(flash.x, flash.y, HEIGHT) for flash in shown],
            quaternions([0.0 for _ in shown]),
            [palette.CONTACT for _ in shown],
            scales=[1.6 - 0.6 * flash.left for flash in shown],
            opacities=[flash.left for flash in shown],
        )
