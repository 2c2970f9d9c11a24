"""Invented runs for tests: a chair drives straight ahead."""

from __future__ import annotations

import msgspec
import numpy as np

from intellwheels_experiments.batch.run_measures import RunMeasures
from intellwheels_experiments.batch.run_store import StoredRun
from intellwheels_experiments.batch.trace_reader import Trace
from intellwheels_maps import robot
from intellwheels_schemas.file_records import TraceBody, TraceHeader, TraceTick
from intellwheels_schemas.messages import Event

RUN = "0123456789abcdef"


def straight(ticks: int = 100, speed: float = 0.5, *, aside: float = 0.0, hits: tuple[int, ...] = ()) -> Trace:
    """Return a run along x from (0, aside) in the floor `corridor15m`, with contacts at some ticks."""
    chair = robot("corridor-chair")
    per_metre = chair.encoder_ticks / (np.pi * chair.wheel_diameter)
    moments = []
    for tick in range(ticks + 1):
        x = tick * 0.05 * speed
        count = round(x * per_metre)
        shown = TraceBody(
            pose=(x, aside, 0.0),
            speed=speed if tick else 0.0,
            power=(speed, speed),
            mode="autonomous",
            wheels=(count, count),
        )
        events = tuple(
            Event(run=RUN, tick=tick, number=tick, code="contact", agent="chair", other="wall", x=x, y=0.0, speed=0.1)
            for hit in hits
            if hit == tick
        )
        moments.append(TraceTick(tick=tick, body={"chair": shown}, event=events, hash="f" * 16))
    return Trace(TraceHeader(run=RUN, seed="1", period=0.05, floor="corridor15m"), moments, {"chair": chair})


NUMBERS = RunMeasures(
    success=True, reached=True, collided=False, contacts_physical=0, contacts_virtual=0, clearance=0.2, time=25.0,
    path=15.0, shortest=14.5, spl=0.97, ldlj=-15.0, sparc=-2.4, effort=None, agreement=None, interventions=0,
    odometry_error=0.1, heading_error=0.01, hash="f" * 16,
)  # fmt: skip


def stored(row: str, seed: str, *, success: bool = True, died: str = "") -> StoredRun:
    """Return a stored run."""
    if died:
        return StoredRun(row=row, seed=seed, died=died)
    changes = {} if success else {"success": False, "collided": True, "contacts_physical": 2}
    return StoredRun(row=row, seed=seed, measured=msgspec.structs.replace(NUMBERS, **changes), wall=1.0)
