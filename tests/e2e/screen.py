"""A page of a real viewer in a real browser, as a test sees it: what its scene holds, where a body is on the screen.

What viser keeps in the page is read, never pixels computed by hand; a frame is asked for, because viser draws on
demand only.
"""

from __future__ import annotations

import io
import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Final, NamedTuple, TypeVar

from PIL import Image
from playwright.sync_api import Page

from intellwheels_experiments.run.child_processes import WaitError
from tests.e2e.stage import Peer, Stage

OPENING = 25.0
"""Seconds from the opening of a page until it shows the scene, on a busy machine."""
WAIT = 40.0
"""Seconds for anything else."""
SHARPNESS = 0.5
"""Pixels that are drawn for a pixel of the page, each way. Software draws them, and 1 takes half as long again."""

# In the page: bodies by node, arrays as plain lists.
_BODIES = """() => {
  const state = window.__viserSceneTree ? window.__viserSceneTree.getState() : {}, found = [];
  const plain = (value, type) => value instanceof Uint8Array && type !== Uint8Array
    ? [...new type(value.buffer.slice(value.byteOffset, value.byteOffset + value.byteLength))] : [...value];
  for (const [name, node] of Object.entries(state)) {
    if (!/^\\/bodies\\/\\d+-[^/]+(\\/stale)?\\/paint$/.test(name) || !node.message) continue;
    const shown = node.overrideVisibility ?? node.visibility;
    if (shown === false) continue;
    const props = node.message.props;
    found.push([name, plain(props.batched_positions, Float32Array), plain(props.batched_wxyzs, Float32Array)]);
  }
  return found;
}"""

_INSTANCES = """pattern => {
  const bytes = value => value.buffer.slice(value.byteOffset, value.byteOffset + value.byteLength);
  const plain = value => [...new Float32Array(bytes(value))];
  const numbers = value => value instanceof Uint8Array ? plain(value) : [...value];
  return Object.entries(window.__viserSceneTree.getState())
    .filter(([name, node]) => new RegExp(pattern).test(name) && node.message && node.message.props.batched_positions)
    .map(([, node]) => [numbers(node.message.props.batched_positions), numbers(node.message.props.batched_wxyzs)]);
}"""

_PIXEL = """([x, y, z]) => {
  const view = window.__viserMutable, root = view.nodeRefFromName[''] ?? view.nodeRefFromName['/bodies'];
  const point = view.camera.position.clone().set(x, y, z);
  view.camera.updateMatrixWorld();
  root.updateWorldMatrix(true, false);
  root.localToWorld(point);
  point.project(view.camera);
  const box = view.canvas.getBoundingClientRect();
  return [box.left + (point.x + 1) / 2 * box.width, box.top + (1 - point.y) / 2 * box.height];
}"""

_PICTURE = """() => {
  const canvas = window.__viserMutable.canvas, small = document.createElement('canvas');
  small.width = 128; small.height = 96;
  const pen = small.getContext('2d');
  pen.drawImage(canvas, 0, 0, 128, 96);
  return [...pen.getImageData(0, 0, 128, 96).data];
}"""

# What is dragged is heard on its way out.
_HEAR_DRAGS = """() => {
  const view = window.__viserMutable;
  window.iwDrags = [];
  if (window.iwSend) return;
  window.iwSend = view.sendMessage;
  view.sendMessage = message => {
    if (message.type === 'SceneNodeDragMessage') window.iwDrags.push(message.phase);
    window.iwSend(message);
  };
}"""

COMPILED: Final = 150.0
"""Seconds until a simulator is ready in a checkout in which none ran before, on a busy machine."""

_T = TypeVar("_T")


class Pose(NamedTuple):
    """Where a body stands in the scene: metres, radians."""

    x: float
    y: float
    heading: float


class Screen:
    """A page with a viewer in it.

    Args:
        page: Of Playwright.
        stage: Whose processes' ends and lines are heard while it waits.
    """

    def __init__(self, page: Page, stage: Stage) -> None:
        self.page, self._stage = page, stage

    def open(self, url: str, query: str = "") -> float:
        """Open the viewer's page, wait until it shows bodies, and return how many seconds that took."""
        begun = time.monotonic()
        self.page.goto(f"{url}/?fixedDpr={SHARPNESS}&{query}")
        self.wait(lambda: self.poses() or None, "bodies in the scene", OPENING)
        took = time.monotonic() - begun
        # Keys pressed before the page listens would be lost.
        self.wait(lambda: self.page.evaluate("Boolean(window.__iwKeys)") or None, "a page with keys", OPENING)
        self.clear()
        return took

    def clear(self) -> None:
        """Close all notices, such as that it draws in software."""
        # In one step: a notice may go by itself between two.
        self.page.evaluate("document.querySelectorAll('.mantine-Notification-closeButton').forEach(b => b.click())")

    def wait(self, look: Callable[[], _T | None], what: str, timeout: float = WAIT) -> _T:
        """Look until there is something, which is returned; the page goes on meanwhile."""
        deadline = time.monotonic() + timeout
        while True:
            self._stage.receive()
            found = look()
            if found is not None:
                return found
            if time.monotonic() > deadline:
                raise WaitError(f"{what} did not come in {timeout:g} s; the page says:\n{self.text()}")
            self.page.wait_for_timeout(50)

    def text(self) -> str:
        """Return all words of the page."""
        return str(self.page.evaluate("document.body.innerText"))

    def says(self, words: str, timeout: float = WAIT) -> None:
        """Wait until the page says so."""
        self.wait(lambda: words in self.text() or None, f"{words!r} on the page", timeout)

    def phase(self, phase: str, timeout: float = WAIT) -> None:
        """Wait until the connection is so."""
        self.page.wait_for_selector(f"[data-testid=connection] [data-phase={phase}]", timeout=timeout * 1000)

    # ------------------------------------------------------------ the scene

    def poses(self) -> list[Pose]:
        """Return where bodies stand in the scene, sorted."""
        found = []
        for _, places, turns in self.page.evaluate(_BODIES):
            for index in range(len(places) // 3):
                w, z = turns[4 * index], turns[4 * index + 3]
                found.append(Pose(places[3 * index], places[3 * index + 1], 2 * math.atan2(z, w)))
        return sorted(found)

    def frame(self, count: int = 1) -> None:
        """Wait until so many frames were drawn."""
        drawings = "window.__viserTestpoints.rendererInfo.render.frame"
        before = self.page.evaluate(drawings)

        def drawn() -> bool | None:
            self.page.evaluate("window.__viserMutable.requestRender()")
            return self.page.evaluate(drawings) >= before + count or None

        self.wait(drawn, "a frame")

    def picture(self) -> list[int]:
        """Return the canvas as bytes of R, G, B, A, 128 x 96 pixels."""
        self.frame(3)
        return [int(byte) for byte in self.page.evaluate(_PICTURE)]

    def pixel(self, x: float, y: float, z: float = 0.0) -> tuple[float, float]:
        """Return where on the page a point of the world is."""
        across, down = self.page.evaluate(_PIXEL, [x, y, z])
        return float(across), float(down)

    def colour(self, x: float, y: float) -> tuple[int, int, int]:
        """Return the sRGB colour of the picture at a point of the floor."""
        across, down = self.pixel(x, y)
        clip: Any = {"x": round(across), "y": round(down), "width": 1, "height": 1}
        self.frame(3)
        pixel = Image.open(io.BytesIO(self.page.screenshot(clip=clip))).convert("RGB").getpixel((0, 0))
        assert isinstance(pixel, tuple)
        return int(pixel[0]), int(pixel[1]), int(pixel[2])

    def instances(self, pattern: str) -> list[tuple[float, ...]]:
        """Return x, y and heading of all instances of the nodes whose names match, sorted."""
        found = []
        for places, turns in self.page.evaluate(_INSTANCES, pattern):
            for index in range(len(places) // 3):
                w, z = turns[4 * index], turns[4 * index + 3]
                found.append((places[3 * index], places[3 * index + 1], 2 * math.atan2(z, w)))
        return sorted(found)

    def camera(self) -> list[float]:
        """Return where this page's camera stands, in the page's own axes."""
        return [float(part) for part in self.page.evaluate("window.__viserMutable.camera.position.toArray()")]

    def rest(self) -> None:
        """Wait until the camera stands still."""
        snapshot = [self.camera()]

        def still() -> bool | None:
            self.page.evaluate("window.__viserMutable.requestRender()")
            snapshot.append(self.camera())
            return math.dist(snapshot[-1], snapshot[-2]) < 1e-3 or None

        # The first report of the page's size is what it is framed by; the answer takes a few beats.
        self.page.wait_for_timeout(500)
        self.wait(still, "a camera that stands still")
        self.frame()

    # ------------------------------------------------------------ the hand

    def tab(self, name: str) -> None:
        """Open a tab."""
        self.page.get_by_role("tab", name=name).click()

    def press(self, name: str) -> None:
        """Press a button."""
        self.page.get_by_role("button", name=name, exact=True).click()

    def select(self, agent: str) -> None:
        """Select by the row in the table of agents."""
        self.tab("Agents")
        self.page.get_by_test_id(f"agent-{agent}").locator("b").first.click()
        self.page.wait_for_selector(f"tr.chosen[data-agent={agent}]", timeout=WAIT * 1000)

    def click(self, agent: str, x: float, y: float, z: float) -> None:
        """Select by a click on a body in the scene; where frames are few the first one finds nothing there yet."""

        def chosen() -> bool | None:
            # What is under the pointer is looked up as the last frame has it.
            self.page.evaluate("window.__viserMutable.requestRender()")
            self.page.mouse.move(*self.pixel(x, y, z))
            self.page.wait_for_timeout(200)
            self.page.mouse.click(*self.pixel(x, y, z))
            until = time.monotonic() + 5.0
            while not (found := self.page.query_selector(f"tr.chosen[data-agent={agent}]")):
                if time.monotonic() > until:
                    break
                self.page.wait_for_timeout(50)
            return bool(found) or None

        self.wait(chosen, f"{agent} selected by a click")

    def hold(self, agent: str) -> None:
        """Open the tab Drive and wait until keys drive an agent: the page's handler comes a moment after the words."""
        self.tab("Drive")
        self.says(f"Hold the stick or the keys W A S D to drive {agent}")
        self.page.wait_for_function("window.__iwDrive && !document.getElementById('iw-drive-off')")

    def drag(self, origin: tuple[float, float, float], target: tuple[float, float, float]) -> None:
        """Drag what is at a point of the world to another, as slowly as a hand.

        Viser knows by frames what is under the pointer: where they are few it is taken hold of again.
        """
        self.page.evaluate(_HEAR_DRAGS)
        mouse = self.page.mouse

        def held() -> bool | None:
            # Looked up for each try: the view may have been framed anew since the last.
            start = self.pixel(*origin)
            mouse.move(start[0] - 2, start[1] - 2)
            self.frame()
            mouse.move(*start)
            self.frame(2)
            self.page.wait_for_timeout(300)
            mouse.down()
            self.page.wait_for_timeout(150)
            mouse.move(start[0] + 2, start[1] + 1)
            mouse.move(start[0] + 4, start[1] + 2)
            self.frame(2)
            self.page.wait_for_timeout(150)
            if self.page.evaluate("window.iwDrags.includes('start')"):
                return True
            mouse.up()
            return None

        self.wait(held, "a body in the hand")
        start, end = self.pixel(*origin), self.pixel(*target)
        for step in range(1, 9):
            mouse.move(start[0] + (end[0] - start[0]) * step / 8, start[1] + (end[1] - start[1]) * step / 8)
            self.page.wait_for_timeout(60)
        mouse.move(end[0] + 1, end[1])
        self.page.wait_for_timeout(150)
        mouse.move(*end)
        self.page.wait_for_timeout(150)
        mouse.up()
        self.wait(lambda: self.page.evaluate("window.iwDrags.includes('end')") or None, "the end of the drag")


class Theatre(Stage):
    """A stage with a viewer."""

    def server(self, *words: str, ready: bool = True) -> str:
        """Start a simulator and wait until it is ready; in a new checkout it is compiled first."""
        child = super().server(*words, ready=False)
        if ready:
            self.line(child, "ready", COMPILED)
        return child

    def viewer(self, *words: str, endpoint: str | None = None, module: str = "intellwheels_viewer") -> str:
        """Start a viewer of this world and return its address."""
        self.viewing = self.start(
            "viewer", module, "--connect", endpoint or self.endpoint, "--world", self.world,
            "--port", "0", *words,
        )  # fmt: skip
        return self.line(self.viewing, "ready")["url"]

    @contextmanager
    def screen(self, chromium: Any, *, width: int = 960, height: int = 560) -> Iterator[Screen]:
        """A page of its own: no storage, no camera of another's."""
        page = chromium.new_page(viewport={"width": width, "height": height}, device_scale_factor=1)
        try:
            yield Screen(page, self)
        finally:
            page.close()


def poses_of(peer: Peer) -> list[Pose]:
    """Return where the simulator says that bodies stand, sorted as the scene's are."""
    bodies = peer.entities().values()
    return sorted(Pose(body["X"], body["Y"], body.get("Heading", 0.0)) for body in bodies)


def turned(one: float, other: float) -> float:
    """Return the angle between two headings, in [0, pi]."""
    return abs(math.remainder(one - other, math.tau))
