"""A simulator's voice at 20 Hz without the simulator: what a viewer hears of many chairs with wedges.

python -m tests.bench.feed ENDPOINT WORLD CHAIRS
"""

from __future__ import annotations

import itertools
import math
import os
import sys
import threading
import time
import traceback
from typing import Final

import msgspec

from intellwheels_maps.hospital import hospital
from intellwheels_schemas import link
from intellwheels_schemas.codec import encode
from intellwheels_schemas.messages import (
    Body,
    Clock,
    Entity,
    MapInfo,
    Measures,
    ProximityReading,
    Robot,
    Sensors,
    WorldState,
)
from tests.bench.tick import SENSORS
from tests.viewer.wire import HASH, RUN, Simulator

PERIOD: Final = 0.05
PART: Final = 250
"""Entities in a part of the state."""
WEDGES: Final = SENSORS[:6]


def body(name: str) -> Body:
    """Return a chair with wedges."""
    robot = Robot(
        name=name, kind="wheelchair", length=1.2, width=0.7, center=0.4, top=1.3, top_speed=1.0, track=0.57,
        proximity=WEDGES,
    )  # fmt: skip
    return Body(run=RUN, tick=0, robot=robot)


def entities(names: list[str], tick: int) -> list[Entity]:
    """Return where the chairs are: each goes round a place of its own."""
    wide = math.ceil(math.sqrt(len(names)))
    found = []
    for number, name in enumerate(names):
        angle = 0.02 * tick + number
        x, y = 2.0 * (number % wide) + math.cos(angle), 2.0 * (number // wide) + math.sin(angle)
        heading = math.remainder(angle + math.pi / 2, math.tau)
        found.append(Entity(name=name, x=x, y=y, heading=heading, speed=0.4, turn_rate=0.4))
    return found


def measures(tick: int, number: int) -> Measures:
    """Return what a chair perceives: every reading another than the tick before."""
    readings = tuple(
        ProximityReading(id=sensor.id, value=1.5 + 1.2 * math.sin(0.1 * tick + number + index))
        for index, sensor in enumerate(WEDGES)
    )
    return Measures(run=RUN, tick=tick, time=tick * PERIOD, sensors=Sensors(proximity=readings))


def main() -> None:
    """Speak until standard input ends."""
    address, world, chairs = sys.argv[1], sys.argv[2], int(sys.argv[3])
    session = link.open_session(link.Link(listen=(address,)), threading.Event())
    assert session is not None
    simulator = Simulator(session, world)
    keys, names = simulator.keys, [f"a{number:04d}" for number in range(chairs)]
    simulator.floor = msgspec.structs.replace(hospital(1))
    simulator.bodies = [body(name) for name in names]
    ended = threading.Event()

    def listen() -> None:
        sys.stdin.read()
        ended.set()

    threading.Thread(target=listen, daemon=True).start()
    print("ready", flush=True)
    begun = time.monotonic()
    for tick in itertools.count(1):
        if ended.wait(max(begun + tick * PERIOD - time.monotonic(), 0.0)):
            return
        if tick % 20 == 1:
            simulator.put(keys.map, MapInfo(run=RUN, tick=0, name="hospital", revision=0, hash=HASH))
        simulator.clock = Clock(
            run=RUN,
            tick=tick,
            time=tick * PERIOD,
            state="running",
            pace="realtime",
            hash=HASH,
            stamp=time.time(),
            factor=1.0,
        )
        simulator.put(keys.clock, simulator.clock)
        placed = entities(names, tick)
        cut = [tuple(placed[first : first + PART]) for first in range(0, chairs, PART)]
        simulator.states = [
            WorldState(run=RUN, tick=tick, time=tick * PERIOD, part=part, parts=len(cut), entity=some)
            for part, some in enumerate(cut)
        ]
        for state in simulator.states:
            simulator.put(keys.state(state.part), state)
        for number, name in enumerate(names):
            session.put(keys.measures(name), encode(measures(tick, number)), encoding="application/json")


if __name__ == "__main__":
    try:
        main()
    finally:
        # Sessions with callbacks hang at exit; nothing here is worth a clean end.
        traceback.print_exc()
        os._exit(0)
