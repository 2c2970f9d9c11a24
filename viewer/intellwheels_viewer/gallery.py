"""`python -m intellwheels_viewer.gallery`: takes the ten pictures of the viewer that the repository keeps.

The scene figure6 runs with its agents, and a headless Chromium opens its page: every camera, two tabs and a refusal, in
the light theme. The log of that run is then played in the dark theme. A chair that enters the ward gives two more
pictures of what a driver sees. A run is stepped from tick to tick, and a picture of a paused page is taken when two in
a row are equal, so a slow machine takes longer and shows the same.
"""

from __future__ import annotations

import argparse
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Final

from intellwheels_schemas.command_parser import CommandParser
from intellwheels_schemas.process import PYTHON

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

PICTURES: Final = (
    "free", "plan", "follow", "first-person", "first-person-ward", "first-person-corridor", "drive", "place", "refused",
    "playback",
)  # fmt: skip
"""The names of the files, without `.jpg`."""
LIMIT: Final = 180.0
"""Seconds for a start or for one step in a page. A browser that draws in software on a busy machine is slow."""
SIZE: Final = (1280, 800)
QUALITY: Final = 75
SLOW: Final = ("--speed", "0.1")
"""The run begins when the page opens, which may need many seconds more until it can be paused."""
FLAGS: Final = (
    "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--disable-dev-shm-usage", "--hide-scrollbars", "--force-color-profile=srgb", "--disable-gpu-rasterization",
)  # fmt: skip
"""Arguments with which Chromium draws without a graphics card, and with the same colours everywhere."""
IN_ROOM: Final = 150
"""The tick at which chair1 passes the table."""
BEFORE_DOOR: Final = 160
"""The tick at which chair1 has the door before it, half open."""
AT_DOOR: Final = 250
"""The tick at which chair1 comes to the open door."""
BEHIND_DOOR: Final = 300
"""The tick at which it is through, and its label is clear of that of the door."""

WARD: Final = """\
<Scene Format="iw.v1" Name="enter-ward" Title="A chair enters a ward" Map="ward"
    Seed="1" Period="0.05" Pace="lockstep" Miss="strict">
  <Cast Name="chair1" Robot="mid-wheel" Mind="waypoints" Place="lobby1">
    <Option Name="points" Value="-3.0 0.1 -2.0 0.05 1.5 0.05 9.0 -0.2"/>
  </Cast>
  <Cast Name="door" Robot="door" Mind="door" Place="ward-door-hinge">
    <Option Name="swing" Value="right"/>
    <Option Name="time" Value="6"/>
  </Cast>
  <End><Timeout Seconds="60.0"/></End>
</Scene>
"""
"""The scene of the pictures of the ward."""
IN_LOBBY: Final = 102
"""The tick at which chair1 has the door of the ward before it, half open."""
IN_CORRIDOR: Final = 264
"""The tick at which chair1 has the doorways of the corridor on both sides."""

_TICK: Final = "() => parseInt(document.querySelectorAll('[data-testid=clock] .iw-figure')[1].innerText)"

# Where on the page a point of the floor is.
_PIXEL: Final = """([x, y]) => {
  const view = window.__viserMutable, root = view.nodeRefFromName[''] ?? view.nodeRefFromName['/bodies'];
  const point = view.camera.position.clone().set(x, y, 0);
  view.camera.updateMatrixWorld();
  root.updateWorldMatrix(true, false);
  root.localToWorld(point);
  point.project(view.camera);
  const box = view.canvas.getBoundingClientRect();
  return [box.left + (point.x + 1) / 2 * box.width, box.top + (1 - point.y) / 2 * box.height];
}"""


class GalleryError(Exception):
    """Pictures cannot be taken; the text says why."""


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    found = CommandParser(
        prog="python -m intellwheels_viewer.gallery",
        description="Take the ten pictures of the viewer: of the scene figure6 and of one in the ward, in Chromium.",
        epilog="It takes about 10 minutes on a busy machine, and needs Chromium and the package playwright "
        "(pip install playwright).",
    )
    found.add_argument(
        "--out", type=Path, default=Path("viewer/gallery"), metavar="FOLDER",
        help="folder of the pictures; pictures of the same name are replaced (default: viewer/gallery)",
    )  # fmt: skip
    return found


def main(arguments: list[str] | None = None) -> int:
    """Run the command and return its exit code."""
    folder: Path = parser().parse_args(arguments).out
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory() as scratch, _chromium() as browser:
            log = Path(scratch) / "figure6.jsonl"
            _live(browser, folder, log)
            _playback(browser, folder, log)
            _ward(browser, folder, Path(scratch) / "enter-ward.xml")
    except (GalleryError, OSError) as error:
        print(f"gallery: {error}", file=sys.stderr)
        return 1
    return 0


def _live(browser: Browser, folder: Path, log: Path) -> None:
    """Take the pictures of a run: all but the last while it is paused."""
    scene = ("figure6", "--view", "--view-port", "0", *SLOW, "--log", str(log))
    with _started(r"view it at (\S+)", "intellwheels_experiments", *scene) as url, _page(browser, url) as page:
        _halt(page, BEFORE_DOOR)
        page.keyboard.press("h")
        _keep(_picture(page), folder, "first-person")
        _step(page, AT_DOOR)
        for key, name in (("p", "plan"), ("f", "follow")):
            page.keyboard.press(key)
            _keep(_picture(page), folder, name)
        page.keyboard.press("o")
        _step(page, BEHIND_DOOR)
        page.get_by_role("tab", name="Drive").click()
        _keep(_picture(page), folder, "drive")
        page.get_by_role("tab", name="Place").click()
        _press(page, "Table")
        for x in (6.1, 6.2):  # the ghost follows the pointer
            page.mouse.move(*page.evaluate(_PIXEL, [x, 4.4]))
        _keep(_picture(page), folder, "place")
        page.mouse.click(*page.evaluate(_PIXEL, [4.5, 4.5]))
        page.get_by_text("Not placed", exact=True).wait_for()
        _keep(_now(page), folder, "refused")  # the notice goes by itself
        _press(page, "Stop placing")
        _select(page, "chair3")  # a slow one: in a picture of a run its ring is drawn a little later than it
        _picture(page)
        _press(page, "Resume")
        page.get_by_test_id("clock").get_by_text("Running", exact=True).wait_for()
        _keep(_now(page), folder, "free")


def _playback(browser: Browser, folder: Path, log: Path) -> None:
    """Take the picture of a log that is played."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        endpoint = f"tcp/127.0.0.1:{probe.getsockname()[1]}"
    viewer = ("intellwheels_viewer", "--dark", "--port", "0", "--connect", endpoint)
    with (
        _started("ready", "intellwheels_server", "--play", str(log), *SLOW, "--listen", endpoint),
        _started(r"url=(\S+)", *viewer) as url,
        _page(browser, url) as page,
    ):
        _halt(page, IN_ROOM)
        _keep(_picture(page), folder, "playback")


def _ward(browser: Browser, folder: Path, scene: Path) -> None:
    """Take the pictures that a driver sees in the ward."""
    scene.write_text(WARD)
    command = (str(scene), "--view", "--view-port", "0", *SLOW)
    with _started(r"view it at (\S+)", "intellwheels_experiments", *command) as url, _page(browser, url) as page:
        _halt(page, IN_LOBBY)
        page.keyboard.press("h")
        _keep(_picture(page), folder, "first-person-ward")
        _step(page, IN_CORRIDOR)
        _keep(_picture(page), folder, "first-person-corridor")


@contextmanager
def _chromium() -> Iterator[Browser]:
    try:
        from playwright.sync_api import Error, sync_playwright  # noqa: PLC0415
    except ImportError:
        raise GalleryError("pictures need playwright: pip install playwright") from None
    with sync_playwright() as playwright:
        try:
            # Without a Chromium of the system, the one that `playwright install chromium` downloads.
            browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
        except Error as error:
            raise GalleryError(f"no Chromium: install it, or run `playwright install chromium`\n{error}") from None
        try:
            yield browser
        except Error as error:
            raise GalleryError(f"the page did not do what was expected of it: {error}") from None
        finally:
            browser.close()


@contextmanager
def _started(pattern: str, module: str, *arguments: str) -> Iterator[str]:
    """Run a command, and interrupt it at the end.

    Args:
        pattern: What its output must have before it counts as started; the last group of it is given.
        module: The command.
        arguments: Its arguments.
    """
    command = (*PYTHON, "-m", module, *arguments)
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as process:
        overdue = threading.Timer(LIMIT, process.kill)
        overdue.start()
        try:
            found = _announced(process, pattern)
            overdue.cancel()
            yield found
        finally:
            overdue.cancel()
            process.send_signal(signal.SIGINT)
            process.communicate(timeout=LIMIT)


def _announced(process: subprocess.Popen[str], pattern: str) -> str:
    said = []
    for line in process.stdout or ():
        said.append(line)
        if found := re.search(pattern, line):
            return found[found.lastindex or 0]
    raise GalleryError(f"{process.args!r} did not start:\n{''.join(said)}")


@contextmanager
def _page(browser: Browser, url: str) -> Iterator[Page]:
    page = browser.new_page(viewport={"width": SIZE[0], "height": SIZE[1]}, device_scale_factor=1)
    page.set_default_timeout(LIMIT * 1000)
    page.goto(f"{url}/?fixedDpr=1")
    yield page
    page.close()


def _select(page: Page, agent: str) -> None:
    page.get_by_role("tab", name="Agents").click()
    page.get_by_test_id(f"agent-{agent}").locator("b").first.click()
    page.wait_for_selector(f"tr.chosen[data-agent={agent}]")
    # Notices are in the way, such as that Chromium draws in software.
    page.evaluate("document.querySelectorAll('.mantine-Notification-closeButton').forEach(b => b.click())")


def _halt(page: Page, tick: int) -> None:
    """Pause a run that has just begun, at normal speed from now on, and step it to a tick."""
    _press(page, "Pause")
    _select(page, "chair1")
    _press(page, "1", which=1)  # the speed; the first button of this name makes a step
    page.get_by_text("in real time").wait_for()
    _step(page, tick)


def _step(page: Page, tick: int) -> None:
    for ticks in (100, 10, 1):
        while (now := page.evaluate(_TICK)) + ticks <= tick:
            _press(page, str(ticks))
            page.wait_for_function(f"tick => ({_TICK})() >= tick", arg=now + ticks)


def _press(page: Page, name: str, which: int = 0) -> None:
    page.get_by_role("button", name=name, exact=True).nth(which).click()


def _now(page: Page) -> bytes:
    return page.screenshot(type="jpeg", quality=QUALITY)


def _picture(page: Page) -> bytes:
    """Return a picture of a page that has come to rest."""
    deadline, last = time.monotonic() + LIMIT, b""
    while time.monotonic() < deadline:
        picture = _now(page)
        if picture == last:
            return picture
        last = picture
        page.wait_for_timeout(1000)
    raise GalleryError(f"the page did not come to rest in {LIMIT:g} s")


def _keep(picture: bytes, folder: Path, name: str) -> None:
    (folder / f"{name}.jpg").write_bytes(picture)
    print(f"{folder / name}.jpg {len(picture)} bytes", flush=True)


if __name__ == "__main__":
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # what it started is ended too
    sys.exit(main())
