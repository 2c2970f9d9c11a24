"""The viewer as a user has it: a simulator, agents, the viewer and a browser, each a process of its own.

What the page shows is compared with what the simulator says, and what a hand does in the page with what then is in
the simulator. One world is shared, put back before each test; what is killed is a test's own.
"""

from __future__ import annotations

import json
import math
import os
import re
import signal
import statistics
from collections.abc import Callable, Iterator
from itertools import chain
from pathlib import Path
from typing import Any

import av
import pytest
from PIL import Image, ImageStat

from intellwheels_maps import library
from intellwheels_viewer.cameras import corners_of
from tests.e2e import strict_router
from tests.e2e.page_audit import faint_texts, walked
from tests.e2e.screen import OPENING, WAIT, Screen, Theatre, poses_of, turned
from tests.e2e.stage import Peer, free_port, run
from tests.viewer.growth import raw_page
from tests.viewer.panels.board import CHROMIUM, browser

pytestmark = pytest.mark.browser

PLACES = {"chair1": (1.2, 2.6, 0.0), "chair2": (7.6, 6.8, math.pi)}
HIDDEN = ("/trails", "/own/labels/chair1")
"""What one of two browsers hides: a layer of all, and a thing of another, which each browser has for itself."""
HOME = 1e-6
"""Metres by which a body that was put back may be elsewhere."""
CONNECTED = 40.0
"""Seconds until a page shows again what was killed and restarted: Zenoh tries every few seconds."""
STILL = 2e-3
"""Metres a second: who is slower stands."""
# What the page renders for a video is counted on its way out.
_HEAR_PICTURES = """() => {
  const view = window.__viserMutable, send = view.sendMessage;
  window.iwPictures = 0;
  view.sendMessage = message => {
    if (message.type === 'GetRenderResponseMessage') window.iwPictures += 1;
    send(message);
  };
}"""


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    """One for all: while Playwright runs, no other event loop does in this thread."""
    if CHROMIUM is None:
        words = "no Chromium: the page is not tested; install chromium"
        if os.environ.get("REQUIRE_BROWSER") == "1":
            pytest.fail(words)
        pytest.skip(words)
    with browser() as one:
        yield one


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory, chromium: Any) -> Iterator[tuple[Theatre, str]]:
    """A room with two chairs that stand, and a viewer."""
    with Theatre(tmp_path_factory.mktemp("viewer"), "shown") as theatre:
        theatre.server("--map", "room", "--pace", "realtime")
        furnish(theatre)
        yield theatre, theatre.viewer()


@pytest.fixture
def peer(world: tuple[Theatre, str]) -> Iterator[Peer]:
    """Someone who asks the simulator itself; the world is as it was."""
    with world[0].peer() as peer:
        peer.ctl("resume")
        peer.ctl("speed", Factor=1.0)
        for name in peer.entities().keys() - PLACES.keys():
            peer.ctl("delete", Agent=name)
        for name, place in PLACES.items():
            teleport(peer, name, *place)
        yield peer


@pytest.fixture
def screen(world: tuple[Theatre, str], peer: Peer, chromium: Any) -> Iterator[Screen]:
    """A page that shows the world."""
    theatre, url = world
    with theatre.screen(chromium) as screen:
        screen.open(url)
        yield screen


def furnish(theatre: Theatre) -> None:
    theatre.agent("chair1", "drive", "--place", "start1")
    theatre.agent("chair2", "drive", "--place", "start2", robot="mid-wheel")


def teleport(peer: Peer, name: str, x: float, y: float, heading: float = 0.0) -> None:
    answer = peer.ctl("teleport", Agent=name, Position={"X": x, "Y": y, "Heading": heading})
    assert answer["Code"] == "ok", answer
    peer.entity(name, lambda body: math.hypot(body["X"] - x, body["Y"] - y) < HOME)


def at(peer: Peer, name: str) -> tuple[float, float, float]:
    body = peer.entities()[name]
    return body["X"], body["Y"], body.get("Heading", 0.0)


def moves(screen: Screen, peer: Peer, name: str) -> None:
    """Wait until a body moves or turns."""
    x, y, heading = at(peer, name)

    def away() -> bool | None:
        now = at(peer, name)
        return math.hypot(now[0] - x, now[1] - y) > 0.02 or turned(now[2], heading) > 0.05 or None

    screen.wait(away, f"motion of {name}")


def stands(screen: Screen, peer: Peer, name: str) -> None:
    """Wait until a body stands, and see that it stays."""
    screen.wait(lambda: abs(peer.entities()[name].get("Speed", 0.0)) < STILL or None, f"halt of {name}")
    before = at(peer, name)
    peer.ticks_on(8)
    assert at(peer, name)[:2] == pytest.approx(before[:2], abs=0.01)


def shown(screen: Screen, peer: Peer) -> None:
    """Wait until the scene is what the simulator says."""

    def same() -> bool | None:
        scene, state = screen.poses(), poses_of(peer)
        return (
            len(scene) == len(state)
            and all(
                math.hypot(one.x - other.x, one.y - other.y) < 1e-5 and turned(one.heading, other.heading) < 1e-5
                for one, other in zip(scene, state, strict=True)
            )
        ) or None

    screen.wait(same, f"the simulator's poses {poses_of(peer)} in the scene {screen.poses()}")


def away(body: dict[str, Any], x: float, y: float) -> float:
    return math.hypot(body["X"] - x, body["Y"] - y)


# ---------------------------------------------------------------- what is seen


def test_the_scene_is_there_soon_after_opening_and_changes_when_a_chair_moves(
    world: tuple[Theatre, str], peer: Peer, chromium: Any
) -> None:
    theatre, url = world
    with theatre.screen(chromium) as screen:
        assert screen.open(url) < OPENING
        screen.rest()
        before = screen.picture()
        assert statistics.pstdev(before) > 10
        assert len({tuple(before[pixel : pixel + 3]) for pixel in range(0, len(before), 4)}) > 100
        teleport(peer, "chair1", 5.0, 4.0, 1.0)
        shown(screen, peer)
        after = screen.picture()
        assert sum(abs(one - other) > 30 for one, other in zip(before, after, strict=True)) > 100


def test_poses_in_the_scene_are_the_simulators(screen: Screen, peer: Peer) -> None:
    lease = peer.ctl("take", Agent="chair1", Seconds=30.0)["Lease"]
    for number in range(1, 200):
        peer.put("user/chair1", {"Lease": lease, "Seq": number, "Forward": 0.5, "Turn": 0.3})
        peer.ticks_on(1)
        if away(peer.entities()["chair1"], 1.2, 2.6) > 0.1:
            break
    peer.ctl("pause")
    assert away(peer.entities()["chair1"], 1.2, 2.6) > 0.1
    shown(screen, peer)
    teleport(peer, "chair2", 6.123456, 5.654321, 2.345678)
    shown(screen, peer)
    peer.ctl("take", Agent="chair1", Lease=lease, Seconds=0.0)


def test_a_label_is_just_above_its_chair_in_the_page_and_the_floor_fills_its_width(screen: Screen, peer: Peer) -> None:
    shown(screen, peer)
    corners = corners_of(library.floor("room"))

    def fills() -> bool:
        box = screen.page.evaluate("window.__viserMutable.canvas.getBoundingClientRect().toJSON()")
        across = [screen.pixel(x, y, z)[0] - box["left"] for x, y, z in corners]
        least, most, width = min(across), max(across), float(box["width"])
        return bool(least >= 0.0 and most <= width and most - least >= 0.9 * width)

    def labelled(name: str) -> bool:
        """Return whether a label is above its chair, and not far. Its node is the middle of its lower edge."""
        spot = f"window.__viserMutable.nodePoseData['/own/labels/{name}']"
        label = screen.page.evaluate(f"{spot} && {spot}.position")
        if not label:
            return False
        x, y, _ = PLACES[name]
        (across_x, down), (above_x, top) = screen.pixel(*label), screen.pixel(x, y, 1.3)
        return abs(across_x - above_x) < 40 and -60 < down - top <= 2

    # The camera moves once when the panels have their places, and labels follow it a moment later.
    screen.wait(lambda: fills() or None, "a floor from side to side")
    for name in PLACES:
        screen.wait(lambda name=name: labelled(name) or None, f"the label of {name} just above it")  # type: ignore[misc]


def test_the_wedges_of_a_doors_frame_stay_while_its_leaf_turns(
    world: tuple[Theatre, str], screen: Screen, peer: Peer
) -> None:
    theatre, _ = world
    child = theatre.agent("door", "drive", "--place", "hinge", robot="door")
    peer.entity("door", lambda body: True)
    frame = [(8.95, 4.3, math.pi), (9.05, 4.3, 0.0)]  # out-right and in-left, in the world frame
    point = (11.5, 4.3)  # in front of in-left; the open leaf is on the other side

    def wedges() -> list[tuple[float, ...]] | None:
        found = [each for each in screen.instances("^/own/wedges/fan-30") if each[1] == pytest.approx(4.3, abs=0.01)]
        return found if len(found) == len(frame) else None

    def placed(found: list[tuple[float, ...]]) -> bool:
        return all(
            math.hypot(one[0] - other[0], one[1] - other[1]) < 1e-5 and turned(one[2], other[2]) < 1e-5
            for one, other in zip(found, frame, strict=True)
        )

    screen.select("door")
    assert placed(screen.wait(wedges, "the wedges of the door"))
    before = screen.camera()
    screen.page.keyboard.press("p")
    screen.wait(lambda: math.dist(screen.camera(), before) > 0.5 or None, "the camera of the plan")
    screen.rest()
    shut = screen.colour(*point)
    teleport(peer, "door", 9.0, 3.51, 0.0)
    shown(screen, peer)
    peer.ticks_on(5)
    assert placed(screen.wait(wedges, "the wedges of the door"))
    assert screen.colour(*point) == shut
    screen.tab("Layers")
    screen.page.get_by_label("Sensors", exact=True).uncheck()
    screen.wait(lambda: math.dist(screen.colour(*point), shut) > 20 or None, "the picture without wedges")
    theatre.signal(child, signal.SIGTERM)
    assert theatre.exit(child) == 0


def test_two_browsers_look_each_in_its_own_way(
    world: tuple[Theatre, str], screen: Screen, peer: Peer, chromium: Any
) -> None:
    theatre, url = world
    with theatre.screen(chromium, width=800, height=420) as other:
        other.open(url)
        free = screen.camera()
        other.page.keyboard.press("p")
        other.wait(lambda: abs(other.camera()[1] - free[1]) > 10 or None, "the plan's camera")
        other.tab("Layers")
        for layer in ("Trails", "Names, speech"):
            other.page.get_by_label(layer, exact=True).uncheck()

        def visible(one: Screen, node: str) -> bool:
            return bool(one.page.evaluate(f"window.__viserSceneTree.getState()['{node}'].effectiveVisibility"))

        for node in HIDDEN:
            other.wait(lambda node=node: not visible(other, node) or None, f"hidden {node}")  # type: ignore[misc]
        other.select("chair2")
        shown(screen, peer)
        assert all(visible(screen, node) for node in HIDDEN)
        assert screen.camera() == free
        assert screen.page.query_selector("tr.chosen") is None


# ---------------------------------------------------------------- driven


def test_the_chair_selected_drives_by_keys_until_they_are_released_or_the_page_is_left(
    screen: Screen, peer: Peer
) -> None:
    other = at(peer, "chair1")
    screen.select("chair2")
    # The tab Drive was not opened: this page shows the agents.
    screen.page.wait_for_function("window.__iwDrive && !document.getElementById('iw-drive-off')")
    screen.rest()
    camera = screen.camera()
    for key in ("i", "a", "ArrowDown"):
        screen.page.keyboard.down(key)
        moves(screen, peer, "chair2")
        screen.page.keyboard.up(key)
        stands(screen, peer, "chair2")
    screen.page.keyboard.down("l")
    moves(screen, peer, "chair2")
    screen.page.evaluate("window.dispatchEvent(new Event('blur'))")
    stands(screen, peer, "chair2")
    screen.page.keyboard.up("l")
    assert at(peer, "chair1") == other
    assert screen.camera() == camera


def test_who_drives_a_chair_is_said_and_changes_while_a_hand_drives_it(screen: Screen, peer: Peer) -> None:
    row, selected = (screen.page.get_by_test_id(name) for name in ("agent-chair2", "selected"))

    def says(words: str) -> None:
        screen.wait(lambda: words in row.inner_text() or None, f"{words!r} in the row of chair2")

    says("driven by a program")
    screen.select("chair2")
    screen.page.wait_for_function("window.__iwDrive && !document.getElementById('iw-drive-off')")
    screen.page.keyboard.down("i")
    says("driven by you, in this page")
    screen.wait(lambda: "driven by you, in this page" in selected.inner_text() or None, "the same of the selected")
    screen.page.keyboard.up("i")
    stands(screen, peer, "chair2")
    says("driven by a program")
    lease = peer.ctl("take", Agent="chair2", Seconds=30.0)["Lease"]
    says("driven by an operator who took it over")
    peer.ctl("take", Agent="chair2", Lease=lease, Seconds=0.0)
    says("driven by a program")


def test_a_finger_on_a_phone_drives_until_it_is_lifted_and_the_bar_pauses(
    world: tuple[Theatre, str], peer: Peer, chromium: Any
) -> None:
    theatre, url = world
    with theatre.screen(chromium, width=390, height=844) as phone:
        phone.open(url)
        page, touch = phone.page, phone.page.context.new_cdp_session(phone.page)
        bar = page.locator("#iw-bar").bounding_box()
        assert bar is not None
        assert (bar["y"] + bar["height"], bar["width"]) == (844, 390)
        page.locator("#iw-bar [data-tab=Agents]").click()
        page.locator("tr[data-agent=chair2]").dispatch_event("pointerdown", {"button": 0, "bubbles": True})
        page.locator("#iw-bar [data-tab=Drive]").click()
        page.wait_for_function("window.__iwDrive && !document.getElementById('iw-drive-off')")
        stick = page.locator("#iw-stick")
        stick.scroll_into_view_if_needed()
        box = stick.bounding_box()
        assert box is not None
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2

        def finger(kind: str, *points: tuple[float, float]) -> None:
            spots = [{"x": a, "y": b} for a, b in points]
            touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": spots})

        finger("touchStart", (x, y))
        finger("touchMove", (x, y - 25))
        moves(phone, peer, "chair2")
        finger("touchEnd")
        stands(phone, peer, "chair2")
        # The button shows what it does, a moment after the simulator's clock says it.
        for state, act in (("paused", "\u275a\u275a"), ("running", "\u25b6")):
            page.locator("#iw-bar [data-iw=pause]").filter(has_text=act).click()
            phone.wait(lambda state=state: peer.clock()["State"] == state or None, f"{state} run")  # type: ignore[misc]


def test_a_chair_clicked_in_the_scene_drives_and_stops_when_the_page_is_closed(screen: Screen, peer: Peer) -> None:
    screen.rest()
    screen.click("chair1", 1.2, 2.6, 0.5)
    screen.hold("chair1")
    screen.page.keyboard.down("i")
    moves(screen, peer, "chair1")
    screen.page.close()
    peer.entity("chair1", lambda body: abs(body.get("Speed", 0.0)) < STILL)
    halted = at(peer, "chair1")
    peer.ticks_on(10)
    assert at(peer, "chair1") == pytest.approx(halted, abs=0.01)


def test_a_chair_whose_mind_takes_goals_goes_where_the_floor_is_clicked_and_no_other_is_offered_it(
    world: tuple[Theatre, str], screen: Screen, peer: Peer
) -> None:
    theatre, _ = world
    child = theatre.agent("goer", "waypoints", "--place", "spare4", "--option", "points=2.6 4.0")
    peer.entity("goer", lambda body: body.get("Mode") == "arrived")
    screen.rest()
    screen.select("chair1")
    screen.tab("Drive")
    assert not screen.page.get_by_role("button", name="Set a goal").is_visible()
    screen.select("goer")
    screen.tab("Drive")
    screen.press("Set a goal")
    screen.says("The next click sets the goal of goer")
    screen.page.mouse.click(*screen.pixel(4.5, 4.6))
    peer.entity("goer", lambda body: body.get("Mode") == "arrived" and away(body, 4.5, 4.6) < 0.4)
    theatre.signal(child, signal.SIGTERM)
    assert theatre.exit(child) == 0


# ---------------------------------------------------------------- for everybody


def test_every_control_is_reached_with_keys_and_every_text_has_contrast(screen: Screen) -> None:
    page = screen.page
    screen.select("chair1")
    buttons = {"Keys", "Find", "Picture", "Record", "Video", "Link", "Contacts", "Pause", "Find a command", "Settings"}
    contents = {
        "Agents": {"Selected"},
        "Layers": {"System", "Light", "Dark", "Sensors"},
        "Drive": {"Say it"},
        "Place": {"Box"},
    }
    for tab, wanted in contents.items():
        screen.tab(tab)
        walk = walked(page)
        if "" in walk.reached:  # a tab that was just opened names its controls a moment later
            walk = walked(page)
        assert (walk.missed, walk.unseen) == ([], []), tab
        assert wanted | buttons <= set(walk.reached), tab
        assert "" not in walk.reached
    screen.tab("Layers")
    for theme in ("Light", "Dark"):
        page.locator(f"[data-choice={theme}]").press("Enter")
        page.wait_for_selector(f"html[data-mantine-color-scheme={theme.lower()}]")
        for tab in contents:
            screen.tab(tab)
            screen.wait(lambda tab=tab: page.get_by_role("tab", name=tab).get_attribute("aria-selected") or None, tab)  # type: ignore[misc]
            assert faint_texts(page) == [], (theme, tab)
        screen.tab("Layers")
    page.set_viewport_size({"width": 390, "height": 844})
    page.wait_for_selector("#iw-bar", state="visible")
    walk = walked(page)
    assert (walk.missed, walk.unseen) == ([], [])
    assert {"Pause or resume", "List", "Stick", "Events", "Keys and help"} <= set(walk.reached)


def test_a_picture_a_video_and_a_link_hold_what_the_page_shows(
    world: tuple[Theatre, str], screen: Screen, peer: Peer, chromium: Any
) -> None:
    theatre, url = world
    page = screen.page
    screen.select("chair2")
    page.keyboard.press("f")
    peer.ctl("pause")
    shown(screen, peer)
    screen.rest()
    before = screen.camera()
    page.mouse.move(480, 300)
    page.mouse.down()
    page.mouse.move(540, 280, steps=4)
    page.mouse.up()
    screen.wait(lambda: math.dist(screen.camera(), before) > 0.2 or None, "another camera")
    screen.rest()

    with page.expect_download(timeout=WAIT * 1000) as saved:
        screen.press("Picture")
    picture = Image.open(saved.value.path()).convert("RGB")
    assert saved.value.suggested_filename == f"intellwheels-{peer.clock()['Tick']}.png"
    assert [*picture.size] == page.evaluate("[window.__viserMutable.canvas.width, window.__viserMutable.canvas.height]")
    assert min(ImageStat.Stat(picture).stddev) > 10
    assert len(picture.resize((128, 96)).getcolors(128 * 96) or ()) > 100

    page.evaluate(_HEAR_PICTURES)
    screen.press("Video")
    page.get_by_role("button", name="Save", exact=True).wait_for()
    for count in range(1, 5):
        assert peer.ctl("step", Count=1)["Code"] == "ok"
        screen.wait(lambda count=count: page.evaluate("window.iwPictures") >= count or None, "a picture")  # type: ignore[misc]
    with page.expect_download(timeout=WAIT * 1000) as saved:
        screen.press("Save")
    with av.open(str(saved.value.path())) as video:
        frames = list(video.decode(video=0))
    assert len(frames) == page.evaluate("window.iwPictures")
    assert [frame.time for frame in frames] == pytest.approx([0.05 * count for count in range(len(frames))])
    assert [frames[0].width, frames[0].height] == [size // 2 * 2 for size in picture.size]
    assert frames[0].to_ndarray(format="gray").std() > 10

    page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    screen.press("Link")
    screen.wait(lambda: "camera=" in page.url or None, "the link in the address bar")
    assert f"tick={peer.clock()['Tick']}" in page.url
    screen.wait(lambda: page.evaluate("navigator.clipboard.readText()") == page.url or None, "the link to paste")
    with theatre.screen(chromium) as other:
        other.open(url, page.url.partition("?")[2])
        other.page.wait_for_selector("tr.chosen[data-agent=chair2]")
        other.wait(lambda: math.dist(other.camera(), screen.camera()) < 0.01 or None, "the same camera")
        assert other.page.get_attribute("#iw-status", "data-tick") == page.get_attribute("#iw-status", "data-tick")
        # It follows as the first page does.
        teleport(peer, "chair2", 6.0, 5.0)
        shown(other, peer)
        other.rest()
        screen.rest()
        assert math.dist(other.camera(), screen.camera()) < 0.01


# ---------------------------------------------------------------- the clock


def test_pause_step_speed_and_reset_act_on_the_simulator(screen: Screen, peer: Peer) -> None:
    def clock(like: Callable[[dict[str, Any]], bool], what: str) -> dict[str, Any]:
        def found() -> dict[str, Any] | None:
            now = peer.clock()
            return now if like(now) else None

        return screen.wait(found, what)

    screen.press("Pause")
    paused = clock(lambda now: now["State"] == "paused", "a pause")
    screen.page.wait_for_selector("[data-testid=clock] [data-state=paused]", timeout=WAIT * 1000)
    screen.press("10")
    clock(lambda now: now["Tick"] == paused["Tick"] + 10, "ten steps")
    screen.press("Resume")
    clock(lambda now: now["State"] == "running", "the run going on")
    screen.press("5")
    assert clock(lambda now: now.get("Speed", 1.0) == 5.0, "five times the speed")["Run"] == paused["Run"]
    screen.press("Reset")
    clock(lambda now: now["Run"] != paused["Run"], "another run")
    screen.wait(lambda: len(peer.entities()) == 2 or None, "the agents in the new run")
    shown(screen, peer)


# ---------------------------------------------------------------- placed


def test_a_body_dragged_goes_where_it_may_and_a_refused_drop_says_why(screen: Screen, peer: Peer) -> None:
    screen.rest()
    screen.drag((1.2, 2.6, 0.45), (4.2, 3.4, 0.45))
    moved = peer.entity("chair1", lambda body: away(body, 4.2, 3.4) < 0.5)
    shown(screen, peer)
    screen.frame()
    screen.drag((7.6, 6.8, 0.45), (moved["X"], moved["Y"], 0.45))
    screen.says("Not placed")
    screen.wait(lambda: re.search(r"overlap", screen.text()), "the reason of the refusal")
    assert away(peer.entities()["chair2"], 7.6, 6.8) < HOME


def test_things_are_placed_by_a_click_on_the_floor_and_taken_away(screen: Screen, peer: Peer) -> None:
    screen.rest()
    screen.tab("Place")
    screen.press("Box")
    screen.says("Click the floor to place the box")
    screen.page.mouse.move(*screen.pixel(4.5, 4.5))
    screen.page.mouse.click(*screen.pixel(5.0, 4.0))
    crate = peer.entity("crate1", lambda body: away(body, 5.0, 4.0) < 0.1)
    shown(screen, peer)
    screen.page.mouse.click(*screen.pixel(7.6, 6.8))
    screen.says("Not placed")
    screen.press("Stop placing")
    screen.select(crate["Name"])
    screen.tab("Place")
    screen.press("+90")
    peer.entity("crate1", lambda body: turned(body.get("Heading", 0.0), math.pi / 2) < 1e-6)
    screen.press("Remove crate1")
    screen.wait(lambda: "crate1" not in peer.entities() or None, "the crate gone")
    shown(screen, peer)


# ---------------------------------------------------------------- what breaks


def test_ticks_go_on_while_the_viewer_is_stopped_and_while_a_page_never_reads(
    world: tuple[Theatre, str], screen: Screen, peer: Peer
) -> None:
    theatre, url = world
    with raw_page(url):
        late = peer.clock()["Late"]
        peer.ticks_on(30)
        # The other page is served meanwhile.
        teleport(peer, "chair1", 4.0, 3.0)
        shown(screen, peer)
    theatre.signal(theatre.viewing, signal.SIGSTOP)
    try:
        peer.ticks_on(40)
        assert peer.clock()["Late"] - late < 60, "a busy machine's, not the viewer's"
    finally:
        theatre.signal(theatre.viewing, signal.SIGCONT)
    teleport(peer, "chair1", 5.0, 3.0)
    shown(screen, peer)


def test_an_open_page_outlives_simulator_and_router(tmp_path: Path, chromium: Any) -> None:
    with Theatre(tmp_path, "killed") as theatre:
        meeting = f"tcp/127.0.0.1:{free_port()}"

        def router() -> str:
            child = theatre.start("router", "intellwheels_server.service.router", "--listen", meeting)
            theatre.line(child, "ready")
            return child

        first = router()
        simulator = theatre.server("--map", "room", "--connect", meeting)
        url = theatre.viewer(endpoint=meeting)
        theatre.agent("chair1", "drive", "--place", "start1", joined=True)
        with theatre.screen(chromium) as screen:
            screen.open(url)
            theatre.signal(simulator, signal.SIGKILL)
            screen.phase("gone")
            screen.says("World killed has gone")
            theatre.server("--map", "room", "--connect", meeting)
            screen.phase("live", CONNECTED)
            theatre.signal(first, signal.SIGKILL)
            screen.phase("no-router")
            screen.says(f"Nothing at {meeting}")
            router()
            screen.phase("live", CONNECTED)
            with theatre.peer() as peer:
                peer.entity("chair1", lambda body: True)
                shown(screen, peer)


def test_without_the_right_to_steer_every_control_says_so(tmp_path: Path, chromium: Any) -> None:
    with Theatre(tmp_path, "looked-at") as theatre:
        meeting = f"tcp/127.0.0.1:{free_port()}"
        file = strict_router.write(tmp_path / "router.json", meeting)
        theatre.line(theatre.start("router", "tests.e2e.strict_router", str(file)), "ready")
        theatre.server("--map", "room", "--connect", meeting)
        furnish(theatre)
        # Ten requests are not answered.
        url = theatre.viewer(endpoint=meeting, module="tests.e2e.hasty_viewer")
        with theatre.screen(chromium) as screen, theatre.peer() as peer:
            screen.open(url)
            run_before = peer.clock()["Run"]
            screen.rest()

            def told(what: str, act: Callable[[], object]) -> None:
                act()
                screen.says(f"{what}\nView only: ")

            for what, button in (
                ("Not paused", "Pause"), ("Not stepped", "10"), ("Speed not changed", "5"), ("Not reset", "Reset"),
            ):  # fmt: skip
                told(what, lambda button=button: screen.press(button))  # type: ignore[misc]
            screen.select("chair1")
            told("Not placed", lambda: screen.drag((1.2, 2.6, 0.45), (3.5, 3.4, 0.45)))
            screen.hold("chair1")
            told("Cannot drive", lambda: screen.page.keyboard.down("i"))
            screen.page.keyboard.up("i")
            field = screen.page.locator("form input:visible").first
            field.fill("hello")
            told("Not sent", lambda: field.press("Enter"))
            screen.tab("Place")
            told("Not turned", lambda: screen.press("+15"))
            told("Not removed", lambda: screen.press("Remove chair1"))
            screen.press("Box")
            screen.says("Click the floor to place the box")
            screen.clear()
            screen.wait(lambda: "Not placed" not in screen.text() or None, "the notice of the drag gone")
            told("Not placed", lambda: screen.page.mouse.click(*screen.pixel(5.0, 4.0)))
            screen.press("Stop placing")
            assert peer.clock()["Run"] == run_before
            assert peer.clock()["State"] == "running"
            for name, place in PLACES.items():
                assert at(peer, name) == pytest.approx(place, abs=1e-6)


# ---------------------------------------------------------------- what is kept


def test_a_recorded_run_plays_in_a_browser_without_a_server(
    world: tuple[Theatre, str], peer: Peer, chromium: Any, tmp_path: Path
) -> None:
    theatre, _ = world
    file = tmp_path / "run.html"
    viewer = theatre.start(
        "recorder", "intellwheels_viewer", "--connect", theatre.endpoint, "--world", theatre.world, "--port", "0",
        "--record", str(file), "--seconds", "1",
    )  # fmt: skip
    theatre.line(viewer, "recorded", file=str(file))
    assert theatre.exit(viewer) == 0
    with theatre.screen(chromium) as screen:
        wanted: list[str] = []
        screen.page.on("request", lambda request: wanted.append(request.url))
        screen.page.goto(file.as_uri())
        wanted_poses = list(chain(*poses_of(peer)))

        def shown_poses() -> list[float] | None:
            # The recording begins again after its end, and then there are no bodies for a moment.
            found = list(chain(*screen.poses()))
            return found if len(found) == len(wanted_poses) else None

        assert screen.wait(shown_poses, "the bodies", OPENING) == pytest.approx(wanted_poses, abs=1e-5)
        assert not [url for url in wanted if url.startswith(("http", "ws"))]


# ---------------------------------------------------------------- what it costs


def grown(updates: int, timeout: float) -> None:
    """Hold the figures of `tests.viewer.growth` against the promise: from the first thousand updates on."""
    done = run("tests.viewer.growth", str(updates), timeout=timeout)
    assert done.returncode == 0, done.stderr
    figures = [look for look in json.loads(done.stdout.splitlines()[-1])["figures"] if look[0] >= 1000]
    assert figures[-1][0] == updates
    resident, kept = [look[1] for look in figures], {look[2] for look in figures}
    assert max(resident) - resident[0] <= 5 * 2**20
    assert len(kept) == 1, f"messages that viser keeps: {sorted(kept)}"


def test_the_viewer_does_not_grow_with_updates() -> None:
    grown(2000, 120.0)


@pytest.mark.soak
def test_the_viewer_does_not_grow_with_half_an_hour_of_updates() -> None:
    grown(36_000, 1200.0)
