"""Pictures of the viewer as it is: `python -m tests.viewer.gallery [FOLDER] [PART ...]`, from the checkout's top.

figure6 runs with real agents, and each camera, tab, layer, empty and error state is kept as a small JPEG, light and
dark, at both sizes, in `viewer/gallery/`; besides `viewer/figure6.jpg` for the README. What is too small to read, or
cut, is printed. Parts are `run`, `states`, `playback` and `reported`, and of these `light` and `dark`, and of the run
`1280` and `1920`; without one all are taken.
"""

from __future__ import annotations

import io
import signal
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final, TypeAlias

from PIL import Image

from intellwheels_experiments.testing.process_group import WORLD
from intellwheels_experiments.testing.rig import Rig
from tests.e2e.screen import Screen, Theatre
from tests.e2e.stage import Stage, free_port
from tests.viewer.panels.board import FAULTS, browser

FOLDER: Final = Path(__file__).parent.parent.parent / "viewer"
MOST: Final = 100_000
"""Bytes of a picture."""
PATIENCE: Final = 150.0
"""Seconds for one picture."""
SIZES: Final = ((1280, 800), (1920, 1080))
THEMES: Final = {"light": (), "dark": ("--dark",)}
PARTS: Final = ("run", "states", "playback", "reported")
Words: TypeAlias = dict[str, tuple[str, ...]]
Sizes: TypeAlias = tuple[tuple[int, int], ...]
LAYERS: Final = ("Full walls", "Sensors", "Lidar", "Trails", "Names, speech", "Goals", "Plan")


class Album:
    """A folder of pictures."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        folder.mkdir(parents=True, exist_ok=True)

    def shoot(self, screen: Screen, name: str) -> None:
        """Keep a picture and print its faults."""
        screen.frame(2)
        screen.page.wait_for_timeout(700)  # a picture for people: what is seen, not what is waited for
        # A browser that draws in software on a busy machine may take long over one frame.
        whole = Image.open(io.BytesIO(screen.page.screenshot(timeout=PATIENCE * 1000))).convert("RGB")
        for quality in (85, 75, 65, 50, 35):
            kept = io.BytesIO()
            whole.save(kept, "JPEG", quality=quality, optimize=True)
            picture = kept.getvalue()
            if len(picture) <= MOST:  # as good as fits
                break
        (self._folder / f"{name}.jpg").write_bytes(picture)
        for fault in dict.fromkeys(screen.page.evaluate(FAULTS)):
            print(f"{name}: {fault}", flush=True)
        print(f"{name}.jpg {len(picture)} bytes", flush=True)


def main(folder: Path, parts: tuple[str, ...], themes: Words, sizes: Sizes) -> None:
    """Take all pictures of these parts."""
    album = Album(folder / "gallery")
    with tempfile.TemporaryDirectory() as scratch, browser() as chromium:
        at = Path(scratch)
        log = at / "figure6.jsonl"
        if "run" in parts or "playback" in parts:
            run_of_figure6(album, folder, chromium, at, log, themes if "run" in parts else {}, sizes)
        if "states" in parts:
            for theme, words in themes.items():
                with Theatre(at / f"states-{theme}", "lab") as theatre:
                    states(album, theatre, chromium, theme, words)
        if "playback" in parts:
            with Theatre(at / "playback", "played") as theatre:
                play(theatre, "--play", str(log))
                played(album, theatre, chromium, themes, "playback", share=0.6, key="o")
        if "reported" in parts:
            with Theatre(at / "reported", "played") as theatre:
                lab, ward = real_chair(at)
                play(theatre, "--play", str(lab), "--reported", str(ward))
                played(album, theatre, chromium, themes, "playback-reported", share=0.95, key="f")


def run_of_figure6(
    album: Album, top: Path, chromium: Any, scratch: Path, log: Path, themes: Words, sizes: Sizes
) -> None:
    """The run: seen while it goes, for the README, then paused and looked at from everywhere."""
    with Rig(scratch / "rig", scene="figure6", pace="realtime", arguments=("--log", str(log))) as rig:
        with Theatre(scratch / "viewers", WORLD) as stage:
            rig.cast()
            rig.ctl("pause")
            urls = {theme: stage.viewer(*THEMES[theme], endpoint=rig.endpoint) for theme in themes}
            if "light" in themes and SIZES[0] in sizes:
                with opened(stage, chromium, urls["light"], *SIZES[0]) as screen:
                    screen.select("chair3")
                    go_on(rig)
                    # A browser that draws in software is a second late with some nodes: they catch up.
                    screen.page.wait_for_timeout(4000)
                    rig.ctl("resume")
                    screen.says("Running")
                    (top / "figure6.jpg").write_bytes(screen.page.screenshot(type="jpeg", quality=88))
                rig.ctl("pause")
            else:
                go_on(rig)
            for theme, url in urls.items():
                for width, height in sizes:
                    with opened(stage, chromium, url, width, height) as screen:
                        tour(album, screen, f"{theme}-{width}")
        rig.end_simulator()


def go_on(rig: Rig) -> None:
    """Let the run go until the first chair is well through the door, clear of its label, and halt it."""
    rig.ctl("resume")
    rig.run_until(lambda now: now["chair1"].x > 9.7, seconds=60.0)
    rig.ctl("pause")


@contextmanager
def opened(theatre: Theatre, chromium: Any, url: str, width: int, height: int) -> Iterator[Screen]:
    """A page with bodies in it, and its camera at rest."""
    with theatre.screen(chromium, width=width, height=height) as screen:
        screen.page.set_default_timeout(PATIENCE * 1000)
        screen.open(url)
        screen.rest()
        yield screen


def tour(album: Album, screen: Screen, prefix: str) -> None:
    """Cameras, tabs and layers in one page."""

    def shoot(name: str) -> None:
        album.shoot(screen, f"{prefix}-{name}")

    shoot("nothing-selected")
    screen.select("chair3")
    shoot("camera-free")
    for key, name in (("p", "plan"), ("f", "follow"), ("h", "first")):
        screen.page.keyboard.press(key)
        screen.page.wait_for_timeout(1500)
        shoot(f"camera-{name}")
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
    for label in LAYERS:
        screen.page.get_by_label(label, exact=True).uncheck()
    screen.page.wait_for_timeout(500)
    shoot("layers-off")
    screen.tab("Agents")
    screen.page.mouse.move(screen.page.viewport_size["width"] - 100, 500)  # type: ignore[index]
    screen.page.mouse.wheel(0, 4000)
    shoot("tab-agents-end")


def states(album: Album, theatre: Theatre, chromium: Any, theme: str, words: tuple[str, ...]) -> None:
    """What is there when something is missing. Each phase is waited for once and taken at both sizes."""
    meeting = f"tcp/127.0.0.1:{free_port()}"
    child = theatre.start("viewer", "intellwheels_viewer", "--connect", meeting, "--port", "0", *words)
    url = theatre.line(child, "ready")["url"] + "/?fixedDpr=1"

    with theatre.screen(chromium, width=SIZES[0][0], height=SIZES[0][1]) as screen:
        screen.page.set_default_timeout(PATIENCE * 1000)
        screen.page.goto(url)

        def shoot(phase: str, name: str) -> None:
            screen.phase(phase, 60.0)
            for width, height in SIZES:
                screen.page.set_viewport_size({"width": width, "height": height})
                screen.rest()
                screen.clear()
                album.shoot(screen, f"{theme}-{width}-state-{name}")

        shoot("no-router", "no-router")
        theatre.line(theatre.start("router", "intellwheels_server.service.router", "--listen", meeting), "ready")
        shoot("no-world", "no-world")
        with Theatre(theatre.folder / "ward", "ward") as other:
            other.server("--map", "room", "--connect", meeting)
            theatre.endpoint = f"tcp/127.0.0.1:{free_port()}"
            simulator = theatre.server("--map", "room", "--connect", meeting)
            # A viewer keeps the one that came alone; another one, begun now, finds two.
            again = theatre.start("viewer2", "intellwheels_viewer", "--connect", meeting, "--port", "0", *words)
            screen.page.goto(theatre.line(again, "ready")["url"] + "/?fixedDpr=1")
            shoot("choose", "choose")
            screen.page.locator("input:visible").first.click()
            screen.page.get_by_role("option", name=theatre.world).click()
            shoot("live", "no-agents")
            theatre.agent("chair1", "drive", "--place", "start1")
            screen.wait(lambda: screen.poses() or None, "the chair")
            theatre.signal(simulator, signal.SIGSTOP)
            shoot("silent", "silent")
            theatre.signal(simulator, signal.SIGKILL)
            shoot("gone", "gone")


# ---------------------------------------------------------------- logs


def play(theatre: Theatre, *words: str) -> None:
    """Play a log in this theatre's world."""
    player = theatre.start(
        "player", "intellwheels_server", "--world", theatre.world, "--listen", theatre.endpoint, *words
    )
    theatre.line(player, "ready", 60.0)


def played(album: Album, theatre: Theatre, chromium: Any, themes: Words, name: str, *, share: float, key: str) -> None:
    """A log on its way, and halted: the same tick in all pictures."""
    urls = {theme: theatre.viewer(*words) for theme, words in themes.items()}
    with theatre.peer() as peer:
        peer.ctl("pause")
        peer.ctl("seek", Tick=int(peer.clock()["Last"] * share))
        for theme, url in urls.items():
            for width, height in SIZES:
                with opened(theatre, chromium, url, width, height) as screen:
                    screen.says("Playing a log")
                    screen.select("chair1")
                    screen.page.keyboard.press(key)
                    screen.page.wait_for_timeout(2000)
                    album.shoot(screen, f"{theme}-{width}-{name}")


def real_chair(scratch: Path) -> tuple[Path, Path]:
    """Return the logs of a laboratory and of the world that its chair, one wheel too large, joined."""
    lab_log, ward_log = scratch / "lab.jsonl", scratch / "ward.jsonl"
    lockstep = ("--pace", "lockstep", "--deadline", "60")
    with stages(scratch) as (lab, ward):
        lab.server("--map", "corner", "--hide-truth", "--expect", "chair1", "--log", str(lab_log), *lockstep)
        ward.server("--map", "corner", "--expect", "chair1", "--log", str(ward_log), *lockstep)
        there = ("--connect", ward.endpoint, "--world", ward.world)
        bridge = ward.start(
            "bridge", "intellwheels_agents.bridge", "world", "--name", "chair1", "--lab-connect", lab.endpoint,
            "--place", "leader", "--chair-option", "WheelRatio=1.03", *there,
        )  # fmt: skip
        ward.line(bridge, "joined", 60.0)
        ward.start(
            "mind", "intellwheels_agents", "waypoints", "--name", "chair1", "--role", "mind",
            "--option", "points=11.2 0", *there,
        )  # fmt: skip
        with ward.peer() as peer:
            peer.entity("chair1", lambda body: body["X"] > 8.0)
        for stage in (ward, lab):
            stage.signal(stage.simulator, signal.SIGTERM)
            stage.exit(stage.simulator)
    return lab_log, ward_log


@contextmanager
def stages(scratch: Path) -> Iterator[tuple[Stage, Stage]]:
    """The two worlds of an experiment with a real chair."""
    with Theatre(scratch / "lab", "lab") as lab, Theatre(scratch / "ward", "ward") as ward:
        yield lab, ward


if __name__ == "__main__":
    given = sys.argv[1:]
    widths = {str(size[0]): size for size in SIZES}
    folders = [Path(word) for word in given if word not in {*PARTS, *THEMES, *widths}]
    main(
        folders[0] if folders else FOLDER,
        tuple(part for part in PARTS if part in given) or PARTS,
        {theme: THEMES[theme] for theme in THEMES if theme in given} or THEMES,
        tuple(widths[word] for word in widths if word in given) or SIZES,
    )
