"""Crews of many chairs as whole processes: late ticks and CPU in real time."""

from __future__ import annotations

from typing import Final

import msgspec

from intellwheels_maps.hospital import WIDTH, hospital
from intellwheels_schemas.messages import Corner, Grid, Map
from tests.bench.network import measure
from tests.bench.rows import Row

PLAN_PLACES: Final = 1000
"""Chairs for which there is one more plan of the hospital."""
RAYS: Final = 10_000_000
"""Rays a second that all sensors may cast: by default a world refuses more than 3,125 of these chairs."""
GAP: Final = 10.0
"""Distance between two plans, m."""


def hospitals(plans: int) -> Map:
    """Return a map of hospital plans side by side, with the walls and the places of each."""
    walls, places = [], []
    for number in range(plans):
        plan, shift = hospital(number + 1), number * (WIDTH + GAP)
        walls += [
            msgspec.structs.replace(wall, corner=tuple(Corner(x=one.x, y=one.y + shift) for one in wall.corner))
            for wall in plan.wall
        ]
        places += [
            msgspec.structs.replace(place, name=f"p{number}-{place.name}", y=place.y + shift)
            for place in (plan.grid.position if plan.grid is not None else ())
        ]
    return Map(format="iw.v1", name="hospitals", wall=tuple(walls), grid=Grid(position=tuple(places)))


def bench(*, seconds: float = 60.0, small: bool = False) -> list[Row]:
    """Return the rows."""
    rows = []
    for chairs, crews, goal in ((4, 2, ""),) if small else ((1000, 4, "<= 12"), (5000, 20, "<= 45")):
        floor = hospitals(-(-chairs // PLAN_PLACES))
        found = measure(
            "intellwheels_server",
            "realtime",
            chairs,
            crews,
            seconds,
            host="tests.bench.crew_chairs",
            floor=floor,
            more=("--world-rays", str(RAYS)),
            settle=0.2 if small else 1.0,
        )
        case = f"{chairs} chairs in {crews} crews, 20 Hz"
        rows.append(Row("crews", case, "late ticks", 100.0 * found.late / max(1, found.ticks), "%", "<= 0.1"))
        rows.append(Row("crews", case, "CPU of the simulator", 100.0 * found.cpu, "% of a core", goal))
        rows.append(Row("crews", case, "memory of the simulator", found.memory, "MiB"))
    return rows
