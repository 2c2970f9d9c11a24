"""Pictures of the viewer as it is: `python -m tests.viewer.gallery [FOLDER]`, from the checkout's top.

figure6 runs with real agents, and each camera, tab, layer, empty and error state is kept as a small JPEG, light and
dark, in `viewer/gallery/`; besides `viewer/figure6.jpg` for the README. What is too small to read, or cut, is printed.
"""

from __future__ import annotations

import signal
import sys
import tempfile
from pathlib import Path
from typing import Any, Final

from intellwheels_experiments.ensemble import WORLD
from intellwheels_experiments.rig import Rig
from tests.e2e.screen import Screen, Theatre
from tests.e2e.stage import free_port
from tests.viewer.panels.board import FAULTS, browser

FOLDER: Final = Path(__file__).parent.parent.parent / "viewer"
MOST: Final = 100_000
"""Bytes of a picture."""
SMALL, LARGE = (1280, 800), (1920, 1080)
THEMES: Final = {"light": (), "dark": ("--dark",)}


class Album:
    """A folder of pictures."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        folder.mkdir(parents=True, exist_ok=True)

    def shoot(self, screen: Screen, name: str) -> None:
        """Keep a picture and print its faults."""
        screen.frame(2)
        screen.page.wait_for_timeout(700)  # a picture for people: what is seen, not what is waited for
        for quality in (85, 75, 65, 50, 35):
            picture = screen.page.screenshot(type="jpeg", quality=quality)
            if len(picture) <= MOST:  # as good as fits
                break
        (self._folder / f"{name}.jpg").write_bytes(picture)
        for fault in dict.fromkeys(screen.page.evaluate(FAULTS)):
            print(f"{name}: {fault}", flush=True)
        print(f"{name}.jpg {len(picture)} bytes", flush=True)


def main(folder: Path) -> None:
    """Take all pictures."""
    album = Album(folder / "gallery")
    with tempfile.TemporaryDirectory() as scratch, browser() as chromium:
        log = Path(scratch) / "figure6.jsonl"
        run_of_figure6(album, Album(folder), chromium, Path(scratch), log)
        for theme, words in THEMES.items():
            with Theatre(Path(scratch) / theme, "lab") as theatre:
                states(album, theatre, chromium, theme, words)
                playback(album, theatre, chromium, theme, words, log)


def run_of_figure6(album: Album, top: Album, chromium: Any, scratch: Path, log: Path) -> None:
    """The run: seen while it goes, then paused and looked at from everywhere."""
    with Rig(scratch / "rig", scene="figure6", pace="realtime", words=("--log", str(log))) as rig:
        stage = Theatre(scratch / "viewers", WORLD)
        with stage:
            rig.cast()
            rig.ctl("pause")
            urls = {theme: stage.viewer(*words, endpoint=rig.endpoint) for theme, words in THEMES.items()}
            with stage.screen(chromium, width=SMALL[0], height=SMALL[1]) as screen:
                screen.open(urls["light"])
                screen.select("chair3")
                rig.ctl("resume")
                rig.run_until(lambda now: now["chair1"].x > 8.2, seconds=60.0)
                # A browser that draws in software is a second late with some nodes: they catch up.
                rig.ctl("pause")
                screen.page.wait_for_timeout(4000)
                rig.ctl("resume")
                screen.says("Running")
                (top._folder / "figure6.jpg").write_bytes(screen.page.screenshot(type="jpeg", quality=88))
            rig.ctl("pause")
            for theme, url in urls.items():
                for width, height in (SMALL, LARGE):
                    with stage.screen(chromium, width=width, height=height) as screen:
                        screen.open(url)
                        screen.rest()
                        tour(album, screen, f"{theme}-{width}", brief=width != SMALL[0])
        rig.end_simulator()


def tour(album: Album, screen: Screen, prefix: str, *, brief: bool) -> None:
    """Cameras, tabs and layers in one page; of a brief one those that a larger window changes."""

    def shoot(name: str) -> None:
        album.shoot(screen, f"{prefix}-{name}")

    if not brief:
        shoot("nothing-selected")
    screen.select("chair3")
    shoot("camera-free")
    for key, name in (("p", "plan"), ("f", "follow"), ("h", "first")):
        screen.page.keyboard.press(key)
        screen.page.wait_for_timeout(1500)
        shoot(f"camera-{name}")
        if brief:
            return
    screen.page.keyboard.press("o")
    screen.rest()
    screen.tab("Drive")
    shoot("tab-drive")
    screen.tab("Place")
    screen.press("Table")
    screen.page.mouse.move(*screen.pixel(2.5, 4.5))
    screen.page.wait_for_timeout(300)
    screen.page.mouse.move(*screen.pixel(2.6, 4.6))
    screen.page.wait_for_timeout(500)
    shoot("tab-place")
    screen.page.mouse.click(*screen.pixel(4.5, 4.5))
    screen.says("Not placed")
    shoot("refused")
    screen.press("Stop placing")
    screen.clear()
    screen.tab("Layers")
    shoot("tab-layers")
    screen.page.get_by_label("Full walls").check()
    screen.page.wait_for_timeout(500)
    shoot("layers-full-walls")
    for label in ("Full walls", "Sensors", "Trails", "Names, speech", "Goals", "Plan"):
        screen.page.get_by_label(label, exact=True).uncheck()
    screen.page.wait_for_timeout(500)
    shoot("layers-off")
    screen.tab("Agents")
    screen.page.mouse.move(screen.page.viewport_size["width"] - 100, 500)  # type: ignore[index]
    screen.page.mouse.wheel(0, 4000)
    shoot("tab-agents-end")


def states(album: Album, theatre: Theatre, chromium: Any, theme: str, words: tuple[str, ...]) -> None:
    """What is there when something is missing."""
    meeting = f"tcp/127.0.0.1:{free_port()}"

    def viewer() -> str:
        child = theatre.start("viewer", "intellwheels_viewer", "--connect", meeting, "--port", "0", *words)
        return theatre.line(child, "ready")["url"] + "/?fixedDpr=1"

    with theatre.screen(chromium, width=SMALL[0], height=SMALL[1]) as screen:
        screen.page.goto(viewer())

        def shoot(phase: str, name: str, timeout: float = 40.0) -> None:
            screen.phase(phase, timeout)
            screen.clear()
            album.shoot(screen, f"{theme}-state-{name}")

        shoot("no-router", "no-router")
        theatre.line(theatre.start("router", "intellwheels_server.router", "--listen", meeting), "ready")
        shoot("no-world", "no-world")
        for world in ("lab", "ward"):
            theatre.world, theatre.endpoint = world, f"tcp/127.0.0.1:{free_port()}"
            theatre.server("--map", "room", "--connect", meeting)
        # The first viewer took the world that was there first.
        screen.page.goto(viewer())
        shoot("choose", "choose")
        screen.page.locator("input:visible").first.click()
        screen.page.get_by_role("option", name="ward").click()
        shoot("live", "no-agents")
        theatre.agent("chair1", "drive", "--place", "start1")
        screen.wait(lambda: screen.poses() or None, "the chair")
        theatre.signal(theatre.simulator, signal.SIGSTOP)
        shoot("silent", "silent")
        theatre.signal(theatre.simulator, signal.SIGKILL)
        shoot("gone", "gone")


def playback(album: Album, theatre: Theatre, chromium: Any, theme: str, words: tuple[str, ...], log: Path) -> None:
    """A log that is played."""
    theatre.endpoint = f"tcp/127.0.0.1:{free_port()}"
    player = theatre.start("player", "intellwheels_server", "--play", str(log), "--listen", theatre.endpoint)
    theatre.line(player, "ready", 60.0)
    viewer = theatre.start("viewer", "intellwheels_viewer", "--connect", theatre.endpoint, "--port", "0", *words)
    with theatre.screen(chromium, width=SMALL[0], height=SMALL[1]) as screen:
        screen.open(theatre.line(viewer, "ready")["url"])
        screen.says("Playing a log")
        screen.page.wait_for_timeout(4000)
        album.shoot(screen, f"{theme}-playback")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER)
