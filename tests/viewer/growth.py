"""How a viewer grows, as a process of its own for `tests/e2e/test_viewer.py`. It prints figures as JSON.

The real viewer with pages, fed by made-up updates as fast as it draws them: five chairs that go round, measures of
all, events, words. A raw page reads what it is sent, in another process.
"""

from __future__ import annotations

import gc
import json
import math
import os
import subprocess
import sys
import threading
import time
import warnings
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

import msgspec
import viser
from websockets.sync.client import connect
from websockets.sync.connection import Connection

from intellwheels_maps import library
from intellwheels_schemas.keys import Verb
from intellwheels_schemas.link import Link
from intellwheels_schemas.messages import (
    Body,
    Clock,
    Entity,
    Event,
    Events,
    MapInfo,
    Measures,
    ProximityReading,
    Record,
    Result,
    Sensors,
    UserInput,
    WorldState,
)
from intellwheels_viewer import viewer_service
from intellwheels_viewer.snapshot import Snapshot
from intellwheels_viewer.state_store import StateStore

RUN: Final = "0" * 16
CHAIRS: Final = tuple(f"chair{number}" for number in range(1, 6))
EVERY: Final = 250
"""Updates between two looks at the figures."""
CAMERA: Final = {
    "type": "ViewerCameraMessage",
    "wxyz": (1.0, 0.0, 0.0, 0.0),
    "position": (0.0, -5.0, 5.0),
    "fov": 0.7,
    "near": 0.1,
    "far": 1000.0,
    "image_height": 600,
    "image_width": 800,
    "look_at": (0.0, 0.0, 0.0),
    "up_direction": (0.0, 0.0, 1.0),
}
"""What a page says first; the viewer makes its panels then."""


@contextmanager
def raw_page(url: str) -> Iterator[Connection]:
    """Connect as a page does that draws nothing. What is not received is not read from the socket either."""
    with connect(
        url.replace("http://", "ws://"),
        subprotocols=[f"viser-v{viser.__version__}"],  # type: ignore[list-item]
        compression=None,
        max_queue=1,
        max_size=None,
        ping_interval=None,
        close_timeout=0.2,
    ) as connection:
        connection.send(msgspec.msgpack.encode(CAMERA))
        yield connection


def read(url: str) -> None:
    """Read all that comes, until it ends."""
    with raw_page(url) as connection:
        for _ in connection:
            pass


class MadeUp:
    """Stands for the network: each `update` is an update."""

    quiet = 0.0

    def __init__(self, updates: int, viewer: viewer_service.Viewer, stop: threading.Event) -> None:
        self._updates, self._viewer, self._stop = updates, viewer, stop
        self._store = StateStore()
        self._tick = 0
        self.figures: list[tuple[int, int, int]] = []

    def start(self) -> None:
        """Say what is said once."""
        store = self._store
        store.on_clock(self._clock())
        store.on_map_info(MapInfo(run=RUN, tick=0, name="room", revision=0, hash=RUN))
        store.on_floor(library.floor("room"))
        store.on_events(Events(run=RUN, next=0, oldest=0))
        for index, name in enumerate(CHAIRS):
            robot = library.robot(("rear-wheel", "mid-wheel", "intellwheels")[index % 3])
            store.on_body(Body(run=RUN, tick=0, robot=msgspec.structs.replace(robot, name=name), owner="0" * 32))

    def update(self) -> Snapshot:
        """Make one update and return what is known, when a page looks."""
        if self._viewer._pages:
            self._go_on()
        return self._store.snapshot("live", "main", ("main",), "tcp/127.0.0.1:7447")

    def _go_on(self) -> None:
        self._tick += 1
        tick, store = self._tick, self._store
        store.on_state(WorldState(run=RUN, tick=tick, time=tick * 0.05, part=0, parts=1, entity=self._entities()))
        for number, name in enumerate(CHAIRS):
            readings = tuple(
                ProximityReading(id=sensor.id, value=1.5 + math.sin(tick / 9 + number))
                for sensor in library.robot("rear-wheel").proximity
            )
            store.on_measures(name, Measures(run=RUN, tick=tick, time=tick * 0.05, sensors=Sensors(proximity=readings)))
        if tick % 2 == 0:
            store.on_event(
                Event(run=RUN, tick=tick, number=tick // 2 - 1, code="contact", agent="chair1", x=2.0, y=2.0)
            )
        if tick % 10 == 0:
            store.on_clock(self._clock())
        if tick % EVERY == 0:
            gc.collect()
            pages = int(Path("/proc/self/statm").read_text().split()[1])
            buffer = self._viewer.server._websock_server._broadcast_buffer
            self.figures.append((tick, pages * os.sysconf("SC_PAGE_SIZE"), len(buffer.message_from_id)))
        if tick >= self._updates:
            self._stop.set()

    def _clock(self) -> Clock:
        return Clock(
            run=RUN, tick=self._tick, time=self._tick * 0.05, state="running", pace="realtime", factor=1.0, late=0,
            hash=RUN, stamp=float(self._tick),
        )  # fmt: skip

    def _entities(self) -> tuple[Entity, ...]:
        found = []
        for number, name in enumerate(CHAIRS):
            along = self._tick / 40 + 1.3 * number
            say = f"here at {self._tick // 100}" if number == self._tick // 100 % 5 else None
            found.append(
                Entity(
                    name=name,
                    x=4.5 + 3 * math.cos(along),
                    y=4 + 3 * math.sin(along),
                    heading=math.remainder(along + math.pi / 2, math.tau),
                    speed=0.5,
                    say=say,
                    contact=number == 0,
                )
            )
        return tuple(found)

    def watch(self, agents: Collection[str]) -> None:
        """All is heard."""

    def close(self) -> None:
        """There is nothing to close."""

    world = "main"

    def choose(self, world: str) -> None:
        """There is one world."""

    def ask(self, verb: Verb, wish: Record) -> Result:
        """Nobody asks."""
        raise NotImplementedError

    def put_user(self, agent: str, wish: UserInput) -> None:
        """Nobody drives."""


def main(updates: int) -> None:
    """Run and print the figures: seconds, and at each look the update, resident bytes and viser's kept messages."""
    viewer_service.FRAME = 0.0  # type: ignore[misc]
    viewer_service.PANELS = 0.05  # type: ignore[misc]
    stop = threading.Event()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # viser's own use of websockets
        viewer = viewer_service.Viewer(viewer_service.Options(port=0), Link("main", connect=("tcp/127.0.0.1:1",)), stop)
    made_up = MadeUp(updates, viewer, stop)
    viewer._network = made_up  # type: ignore[assignment]
    url = f"http://127.0.0.1:{viewer.server.get_port()}"
    begun = time.monotonic()
    reader = subprocess.Popen([sys.executable, "-m", "tests.viewer.growth", url], stderr=subprocess.DEVNULL)
    try:
        viewer.run()
    finally:
        reader.kill()
        reader.wait()
    print(json.dumps({"seconds": time.monotonic() - begun, "figures": made_up.figures}))


if __name__ == "__main__":
    if sys.argv[1].startswith("http"):
        read(sys.argv[1])
    else:
        main(int(sys.argv[1]))
