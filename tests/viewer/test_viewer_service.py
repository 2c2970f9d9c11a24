"""The viewer's life, with real pages and a made-up simulator: what comes, what is drawn, what ends and what not."""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from intellwheels_schemas.link import Link
from intellwheels_schemas.messages import Result
from intellwheels_viewer import stage, viewer_service
from intellwheels_viewer.viewer_service import Options, Viewer, serve
from tests.viewer.browser import Browser, opened
from tests.viewer.wire import OTHER, Simulator, body, clock, entity, simulator, until

pytestmark = [pytest.mark.process, pytest.mark.filterwarnings("ignore::DeprecationWarning")]
HERE = Options(port=0)


def _open_files() -> int:
    return len(list(Path("/proc/self/fd").iterdir()))


class Running:
    """A viewer that draws."""

    def __init__(self, endpoint: str) -> None:
        self.stop = threading.Event()
        self.viewer = Viewer(HERE, Link("main", connect=(endpoint,)), self.stop)
        self.thread = threading.Thread(target=self.viewer.run, name="drawing")
        self.thread.start()

    @property
    def port(self) -> int:
        return self.viewer.server.get_port()

    def pages(self) -> int:
        return len(self.viewer._open_pages())

    def selects(self, name: str) -> None:
        """The newest page selects."""
        until(self.pages)
        list(self.viewer._open_pages().values())[-1].select(name)

    def end(self) -> float:
        """Stop, and return how many seconds it took."""
        began = time.monotonic()
        self.stop.set()
        self.thread.join(30.0)
        assert not self.thread.is_alive()
        return time.monotonic() - began


@contextmanager
def running(endpoint: str) -> Iterator[Running]:
    made = Running(endpoint)
    try:
        yield made
    finally:
        made.end()


@pytest.fixture
def world() -> Iterator[tuple[Simulator, Running]]:
    with simulator("lab") as (made, endpoint), running(endpoint) as viewer:
        made.bodies = [body("a"), body("b")]
        made.run(3, entity("a", 1.0), entity("b", 2.0))
        yield made, viewer


def painted(viewer: Running) -> dict[str, tuple[float, float]]:
    """Return where the bodies are drawn."""
    found: dict[str, tuple[float, float]] = {}
    for node, names in viewer.viewer._stage.bodies.names.items():
        if node.endswith("/paint"):
            places = viewer.viewer.server.scene._handle_from_node_name[node].batched_positions  # type: ignore[attr-defined]
            found |= {name: (float(x), float(y)) for name, (x, y, _) in zip(names, places, strict=False)}
    return found


def test_a_page_shows_the_run(world: tuple[Simulator, Running]) -> None:
    _, viewer = world
    with opened(viewer.port) as browser:
        browser.wait(lambda: "World lab" in browser.text() or ">lab<" in browser.text() or "chair" in browser.text())
        browser.wait(lambda: any(node.startswith("/bodies/") for node in browser.scene))
        assert painted(viewer) == {"a": (1.0, 0.0), "b": (2.0, 0.0)}


def test_a_body_that_is_moved_while_the_run_stands_is_drawn_there(world: tuple[Simulator, Running]) -> None:
    made, viewer = world
    until(lambda: painted(viewer))
    made.run(3, entity("a", 7.0), entity("b", 2.0))
    until(lambda: painted(viewer).get("a") == (7.0, 0.0))


def test_what_is_selected_while_the_run_stands_has_its_ring(world: tuple[Simulator, Running]) -> None:
    _, viewer = world
    with opened(viewer.port) as browser:
        browser.wait(lambda: any(node.startswith("/bodies/") for node in browser.scene))
        viewer.selects("a")
        browser.wait(lambda: any(node.startswith("/selected") for node in browser.scene))


def test_a_page_whose_browser_keeps_nothing_is_made_all_the_same(world: tuple[Simulator, Running]) -> None:
    _, viewer = world
    with opened(viewer.port, storage="blocked") as browser:
        browser.element("Camera")
        until(lambda: viewer.pages() == 1)


def test_a_page_that_leaves_is_forgotten(world: tuple[Simulator, Running]) -> None:
    _, viewer = world
    for _ in range(3):
        with opened(viewer.port) as browser:
            browser.element("Camera")
            until(lambda: viewer.pages() == 1)
        until(lambda: viewer.pages() == 0)


def test_a_page_that_leaves_while_it_is_made_is_forgotten(world: tuple[Simulator, Running]) -> None:
    made, viewer = world
    for _ in range(6):
        with opened(viewer.port, storage=None):  # it never answers what it kept
            pass
    with opened(viewer.port) as browser:
        browser.element("Camera")
        until(lambda: viewer.pages() == 1)
        made.run(4, entity("a", 4.0), entity("b"))
        until(lambda: painted(viewer).get("a") == (4.0, 0.0))
    until(lambda: viewer.pages() == 0)
    until(lambda: not [thread for thread in threading.enumerate() if thread.name == "wishes"])


def test_a_fault_in_one_drawing_is_told_once_and_ends_nothing_else(
    world: tuple[Simulator, Running], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    made, viewer = world

    def fail(*_: object) -> None:
        raise ZeroDivisionError("a fault of the test")

    monkeypatch.setattr(viewer.viewer._stage._goals, "show", fail)
    with opened(viewer.port) as browser:
        for tick in range(4, 8):
            made.run(tick, entity("a", float(tick)), entity("b"))
            until(lambda tick=tick: painted(viewer).get("a") == (float(tick), 0.0))  # type: ignore[misc]
        browser.element("Camera")
    assert viewer.thread.is_alive()
    assert capsys.readouterr().err.count("ZeroDivisionError: a fault") == 1


def test_agents_that_vanish_and_runs_that_begin_anew_are_drawn(world: tuple[Simulator, Running]) -> None:
    made, viewer = world
    with opened(viewer.port) as browser:
        browser.element("Camera")
        viewer.selects("a")
        page = next(iter(viewer.viewer._open_pages().values()))
        page.look("follow")
        made.run(5)
        until(lambda: painted(viewer) == {})
        made.bodies = [body("c", OTHER)]
        made.run(0, entity("c", 1.0), run=OTHER)
        until(lambda: painted(viewer) == {"c": (1.0, 0.0)})
        assert viewer.thread.is_alive()


def test_a_selected_text_of_a_stranger_ends_nothing(world: tuple[Simulator, Running]) -> None:
    made, viewer = world
    made.bodies = [body(f"n{k:03d}") for k in range(101)]
    with opened(viewer.port) as browser:
        browser.element("Camera")
        viewer.selects("a/**")
        made.run(5, *(entity(f"n{k:03d}", float(k)) for k in range(101)))
        until(lambda: len(painted(viewer)) == 101)
        made.run(6, *(entity(f"n{k:03d}", k + 0.5) for k in range(101)))
        until(lambda: painted(viewer).get("n000") == (0.5, 0.0))


@pytest.mark.parametrize(
    "message",
    [
        {"type": "NoSuchMessage"}, {"no": "type"}, {"type": "GuiUpdateMessage", "uuid": "x", "updates": {"value": 1}},
        {"type": "ViewerCameraMessage"},
        {"type": "SceneNodeClickMessage", "name": "/bodies/0-wheelchair/paint", "instance_index": 10**9,
         "ray_origin": (0, 0, 0), "ray_direction": (0, 0, 0), "screen_pos": (0, 0), "modifier": None, "owner": ""},
    ],
)  # fmt: skip
def test_a_strangers_message_harms_no_other_page(world: tuple[Simulator, Running], message: dict[str, object]) -> None:
    made, viewer = world
    with opened(viewer.port) as browser, opened(viewer.port) as stranger:
        browser.element("Camera")
        stranger.element("Camera")
        stranger.send(message)
        before = browser.received
        made.run(9, entity("a", 9.0), entity("b"))
        browser.wait(lambda: browser.received > before)
        until(lambda: painted(viewer).get("a") == (9.0, 0.0))


def test_a_page_with_a_camera_that_is_none_harms_no_other(world: tuple[Simulator, Running]) -> None:
    made, viewer = world
    nan = float("nan")
    with opened(viewer.port) as browser, opened(viewer.port, looks=False) as stranger:
        stranger.look(position=(nan, nan, nan), look_at=(nan, nan, nan), image_height=0)
        browser.element("Camera")
        stranger.element("Camera")
        until(lambda: viewer.pages() == 2)
        for page in viewer.viewer._open_pages().values():
            page.select("a")
            page.look("follow")
        made.run(9, entity("a", 9.0), entity("b"))
        until(lambda: painted(viewer).get("a") == (9.0, 0.0))


def test_what_is_driven_is_given_back_when_the_viewer_ends() -> None:
    with simulator("lab") as (made, endpoint):
        made.verdict = lambda verb, data: Result(code="ok", lease="0" * 16)
        made.bodies = [body("a")]
        with running(endpoint) as viewer:
            made.run(3, entity("a"))
            with opened(viewer.port) as browser:
                browser.element("Camera")
                viewer.selects("a")
                page = next(iter(viewer.viewer._open_pages().values()))
                until(lambda: page._stick(0.5, 0.0, 1) or made.asked)  # type: ignore[func-returns-value]
                until(lambda: page._stick(0.5, 0.0, 2) or made.users)  # type: ignore[func-returns-value]
                assert viewer.end() < 8.0
        until(lambda: made.users[-1].forward == 0.0)
        assert b'"Seconds":0' in made.asked[-1][1]


def test_a_page_that_never_reads_holds_no_viewer_that_was_told_to_stop(world: tuple[Simulator, Running]) -> None:
    made, viewer = world
    with opened(viewer.port) as browser, opened(viewer.port, reads=False):
        browser.element("Camera")
        until(lambda: viewer.pages() == 1)
        for tick in range(4, 40):
            made.run(tick, entity("a", float(tick)), entity("b"))
        until(lambda: painted(viewer).get("a") == (39.0, 0.0))
        assert viewer.end() < 10.0


def test_a_viewer_without_a_link_ends_at_once() -> None:
    viewer = Running("tcp/127.0.0.1:1")
    with opened(viewer.port) as browser:
        browser.wait(lambda: "Nothing at" in browser.text())
        assert viewer.end() < 8.0


def test_a_page_that_comes_in_the_middle_is_told_the_phase(world: tuple[Simulator, Running]) -> None:
    made, viewer = world
    until(lambda: painted(viewer))
    made.leave()
    with opened(viewer.port) as browser:
        browser.wait(lambda: 'data-phase="gone"' in browser.text())
        made.come()
        made.put(made.keys.clock, clock(4, stamp=time.time()))
        browser.wait(lambda: 'data-phase="live"' in browser.text())


# ---------------------------------------------------------------- the command's part


def test_a_taken_port_is_an_error_in_words(capsys: pytest.CaptureFixture[str]) -> None:
    with socket.socket() as holder:
        holder.bind(("127.0.0.1", 0))
        holder.listen()
        port = holder.getsockname()[1]
        assert serve(Options(port=port), Link(connect=("tcp/127.0.0.1:1",)), threading.Event()) == 1
    out, err = capsys.readouterr()
    assert "the port is in use" in err
    assert "Traceback" not in err
    assert out == ""


def test_a_link_that_cannot_be_is_an_error_in_words(capsys: pytest.CaptureFixture[str]) -> None:
    assert serve(HERE, Link(connect=("nonsense",)), threading.Event()) == 1
    assert "iw-viewer: link: expected" in capsys.readouterr().err


def test_the_url_is_said_once_it_is_served(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    stop = threading.Event()
    monkeypatch.setattr(viewer_service.Viewer, "run", lambda self: self.server.stop())
    assert serve(HERE, Link(connect=("tcp/127.0.0.1:1",)), stop) == 0
    assert capsys.readouterr().out.startswith("ready url=http://127.0.0.1:")


def test_nothing_of_a_browser_is_left_open(world: tuple[Simulator, Running]) -> None:
    _, viewer = world
    with opened(viewer.port) as browser:
        browser.element("Camera")
    until(lambda: viewer.pages() == 0)
    open_now = _open_files()
    for _ in range(5):
        with opened(viewer.port) as browser:
            assert isinstance(browser, Browser)
            browser.element("Camera")
        until(lambda: viewer.pages() == 0)
    until(lambda: _open_files() <= open_now + 1)


def test_panels_of_many_bodies_are_filled_less_often() -> None:
    assert viewer_service.panel_period(stage.MANY) == viewer_service.PANELS
    assert viewer_service.panel_period(stage.MANY + 1) == viewer_service.PANELS_OF_MANY > viewer_service.PANELS
