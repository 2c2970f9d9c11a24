"""How fast a browser draws the ward with 30 agents that move, in software.

`python -m tests.bench.frames FRAMES` prints frames a second, and frames a second of the browser's CPU time, which a
busy machine changes little. It measures the packages on `PYTHONPATH`, so another checkout is measured in the same
browser.
"""

from __future__ import annotations

import math
import os
import shutil
import sys
import threading
import time
import warnings
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Final, cast

import msgspec

from intellwheels_maps import library
from intellwheels_schemas.messages import Body, Entity, Grid, Map

AGENTS: Final = 30
SIZE: Final = (1280, 800)
RATE: Final = 20.0
RUN: Final = "0" * 16
ROBOTS: Final = ("rear-wheel", "mid-wheel", "intellwheels", "front-wheel", "person")
OPENING: Final = 120_000.0
"""Milliseconds until the page shows the scene, at most."""
WARM: Final = 3
"""Frames before the measured ones: shaders are compiled, shadows drawn."""

_READY: Final = """() => window.__viserTestpoints && window.__viserMutable && window.__viserMutable.canvas
  && window.__viserTestpoints.rendererInfo.render.triangles > 20000"""
_DRAW: Final = """count => new Promise(done => {
  const frames = () => window.__viserTestpoints.rendererInfo.render.frame, first = frames();
  const draw = () => {
    if (frames() >= first + count) done(frames() - first);
    else { window.__viserMutable.requestRender(); requestAnimationFrame(draw); }
  };
  draw();
})"""


def cast_of(floor: Map) -> list[tuple[str, str, float, float]]:
    """Return name, robot and place of each agent: 28 at the places of the ward, and two visitors."""
    grid = cast("Grid", floor.grid)
    places = [place for place in grid.position if "wheelchair" in place.kinds or place.name.endswith("-door")]
    return [
        (f"a{number}", ROBOTS[number % len(ROBOTS)], place.x, place.y) for number, place in enumerate(places[:AGENTS])
    ]


def moment(agents: list[tuple[str, str, float, float]], tick: int) -> tuple[Entity, ...]:
    """Return the states at a tick: all turn on the spot and go to and fro by a few centimetres."""
    return tuple(
        Entity(
            name=name, x=x + 0.1 * math.sin(tick / 5.0), y=y, heading=math.remainder(tick / 20.0 + y, math.tau),
            speed=0.5, left_output=0.5, right_output=0.5, travelled=tick / 40.0, state="drive",
        )
        for name, _, x, y in agents
    )  # fmt: skip


def browser_cpu() -> float:
    """Return the CPU time of all processes that this one started, and of those that they started, in seconds."""
    parents: dict[int, list[tuple[int, float]]] = {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rpartition(")")[2].split()
        except OSError:  # it has ended
            continue
        used = (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
        parents.setdefault(int(fields[1]), []).append((int(stat.parent.name), used))
    total, todo = 0.0, [os.getpid()]
    while todo:
        for child, used in parents.get(todo.pop(), []):
            total += used
            todo.append(child)
    return total


def frames(count: int) -> tuple[float, float]:
    """Serve the scene, open it in Chromium, and return frames a second, and frames a second of CPU time."""
    from playwright.sync_api import sync_playwright

    from intellwheels_viewer.gallery import FLAGS
    from intellwheels_viewer.origin_guard import open_server
    from intellwheels_viewer.page import Page
    from intellwheels_viewer.snapshot import Snapshot
    from intellwheels_viewer.stage import Stage

    warnings.simplefilter("ignore", DeprecationWarning)
    floor = library.floor("ward")
    agents = cast_of(floor)
    bodies = {
        name: Body(
            run=RUN, tick=0, robot=msgspec.structs.replace(library.robot(robot), name=name), owner="1" * 16,
            roles=("both",),
        )
        for name, robot, _, _ in agents
    }  # fmt: skip
    made = [
        Snapshot(
            phase="live", world="main", run=RUN, tick=tick, time=tick / RATE, floor=floor, revision=0, bodies=bodies,
            entities=moment(agents, tick), version=tick,
        )
        for tick in range(1, 126)
    ]  # fmt: skip
    server = open_server("127.0.0.1", 0)
    stage = Stage(server)
    stage.show(made[0], set())
    quiet = SimpleNamespace(
        ask=lambda *_: None, put_user=lambda *_: None, note_speech=lambda *_: None, choose=lambda *_: None, quiet=0.0,
        world="main",
    )  # fmt: skip
    pages: list[Page] = []
    server.on_client_connect(lambda client: pages.append(Page(client, cast(Any, quiet), stage.colours)))
    stop = threading.Event()

    def run() -> None:
        begun, tick = time.monotonic(), 0
        while not stop.wait(max(begun + tick / RATE - time.monotonic(), 0.0)):
            tick += 1
            snapshot = made[tick % len(made)]
            stage.show(snapshot, set())
            for page in pages:
                page.draw(snapshot)
                if tick % 5 == 0:
                    page.panels(snapshot)

    drawing = threading.Thread(target=run, daemon=True)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
        try:
            page = browser.new_page(viewport={"width": SIZE[0], "height": SIZE[1]}, device_scale_factor=1)
            page.goto(f"http://127.0.0.1:{server.get_port()}/?fixedDpr=1")
            drawing.start()
            page.wait_for_function(_READY, timeout=OPENING)
            page.evaluate(_DRAW, WARM)
            begun, used = time.monotonic(), browser_cpu()
            drawn = page.evaluate(_DRAW, count)
            return drawn / (time.monotonic() - begun), drawn / (browser_cpu() - used)
        finally:
            stop.set()
            browser.close()


if __name__ == "__main__":
    print("frames a second: {:.3f}, of CPU time: {:.3f}".format(*frames(int(sys.argv[1]))), flush=True)
    os._exit(0)
