"""The panels in a page: what a person sees is whole, what is pressed calls, and letting go stops."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from dataclasses import replace
from typing import Any, cast

import pytest
from playwright.sync_api import Page

from intellwheels_viewer.panels.callbacks import assign, element_id
from intellwheels_viewer.panels.scan_panel import OFF
from intellwheels_viewer.panels.stick_input import GENTLE
from tests.viewer.panels import made_up
from tests.viewer.panels.board import FAULTS, Board, opened, served
from tests.viewer.panels.made_up import DENIED
from tests.viewer.wire import until

pytestmark = pytest.mark.browser
TABS = ("Agents", "Drive", "Place", "Layers", "Events", "Selected")


@pytest.fixture(scope="module")
def shown(chromium: Any) -> Iterator[tuple[Page, Board]]:
    with served(made_up.snapshot(), made_up.choices()) as (server, boards):
        yield opened(chromium, server), boards[0]


@pytest.fixture
def board(shown: tuple[Page, Board]) -> Board:
    shown[1].show(made_up.snapshot(), made_up.choices())
    shown[1].calls.clear()
    return shown[1]


@pytest.fixture
def page(shown: tuple[Page, Board], board: Board) -> Page:
    shown[0].get_by_role("tab", name="Drive").click()
    # The handler runs when its image has failed, a moment after the page is there.
    shown[0].wait_for_function("window.__iwDrive")
    # The test before may have shown nobody to drive: its page is not this one's yet.
    shown[0].wait_for_selector("#iw-drive-off", state="detached")
    return shown[0]


def held(calls: list[tuple[Any, ...]], forward: float, turn: float) -> int:
    return sum(call[0] == "stick" and call[1:3] == pytest.approx((forward, turn)) for call in calls)


def released(calls: list[tuple[Any, ...]]) -> bool:
    return bool(calls) and calls[-1][:3] == ("stick", 0.0, 0.0)


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_no_text_is_small_or_cut(chromium: Any, theme: str) -> None:
    with served(made_up.snapshot(), made_up.choices(), dark=theme == "dark") as (server, _):
        page = opened(chromium, server)
        for tab in TABS:
            page.get_by_role("tab", name=tab).click()
            assert page.evaluate(FAULTS) == []
        page.close()


def test_no_word_of_a_peer_runs_as_script(chromium: Any) -> None:
    with served(made_up.hostile(), made_up.attacked()) as (server, boards):
        page = opened(chromium, server)
        for tab in TABS:
            page.get_by_role("tab", name=tab).click()
        page.wait_for_function("document.body.innerText.includes('onerror')")
        assert page.evaluate("window.hacked") is None
        # It is a name like any other: its row selects it.
        page.get_by_role("tab", name="Agents").click()
        page.locator("tr[data-agent]").click()
        boards[0].wait(lambda calls: ("select", made_up.ATTACK) in calls)
        assert page.evaluate("window.hacked") is None
        page.close()


def test_a_key_drives_ten_times_a_second_until_it_is_released(page: Page, board: Board) -> None:
    page.keyboard.down("i")
    board.wait(lambda calls: held(calls, GENTLE, 0.0) >= 5)
    page.keyboard.down("j")
    board.wait(lambda calls: held(calls, GENTLE, GENTLE))
    page.keyboard.up("i")
    page.keyboard.up("j")
    board.wait(released)
    counts = [call[3] for call in board.calls]
    assert counts == list(range(counts[0], counts[0] + len(counts)))


@pytest.mark.parametrize(
    ("key", "forward", "turn"),
    [
        ("w", GENTLE, 0.0),
        ("ArrowDown", -GENTLE, 0.0),
        ("a", 0.0, GENTLE),
        ("ArrowRight", 0.0, -GENTLE),
        ("e", GENTLE, -GENTLE),
    ],
)
def test_other_keys_drive_too_and_leave_the_camera_alone(
    page: Page, board: Board, key: str, forward: float, turn: float
) -> None:
    where = "window.__viserMutable.camera.position.toArray()"
    before = page.evaluate(where)
    page.keyboard.down(key)
    board.wait(lambda calls: held(calls, forward, turn) >= 2)
    page.keyboard.up(key)
    board.wait(released)
    assert page.evaluate(where) == before


def test_arrows_move_along_tabs_that_were_reached_with_the_tab_key(page: Page, board: Board) -> None:
    page.get_by_role("tab", name="Agents").focus()
    page.keyboard.press("Shift+Tab")
    page.keyboard.press("Tab")
    if page.evaluate("document.activeElement.getAttribute('role') === 'tab'"):
        page.keyboard.press("ArrowRight")
        assert not [call for call in board.calls if call[0] == "stick"]


def test_a_question_mark_shows_the_keys_and_escape_hides_them(page: Page, board: Board) -> None:
    page.keyboard.press("?")
    page.wait_for_selector("#iw-keys[open]")
    assert "drive the selected chair" in page.inner_text("#iw-keys")
    page.keyboard.press("Escape")
    page.wait_for_selector("#iw-keys[open]", state="detached")
    assert not [call for call in board.calls if call[0] == "stick"]


def test_a_filter_is_reached_and_pressed_with_keys(page: Page, board: Board) -> None:
    page.get_by_role("tab", name="Events").click()
    button = page.locator("[data-choice=Contacts]")
    button.focus()
    page.keyboard.press("Enter")
    page.wait_for_selector("[data-choice=Contacts][aria-pressed=true]")
    assert set(page.locator("[data-testid=events] li").evaluate_all("all => all.map(one => one.dataset.code)")) == {
        "contact",
        "parted",
    }
    # The page is that of all tests here.
    page.locator("[data-choice=All]").first.press("Enter")
    page.evaluate("document.activeElement.blur()")


def test_a_page_says_what_its_window_is_like(board: Board, shown: tuple[Page, Board]) -> None:
    window = shown[1].shell
    until(lambda: window._window.value)
    assert '"width":1280' in window._window.value
    shown[0].wait_for_selector("#iw-bar", state="hidden")


def test_nothing_is_sent_after_the_release(page: Page, board: Board) -> None:
    page.keyboard.press("k")
    board.wait(released)
    sent = len(board.calls)
    # Three beats of the page's timer, by its own clock.
    page.evaluate("() => new Promise(done => setTimeout(done, 350))")
    assert len(board.calls) == sent


@pytest.mark.parametrize("event", ["blur", "pagehide"])
def test_a_page_that_is_left_stops(page: Page, board: Board, event: str) -> None:
    page.keyboard.down("l")
    board.wait(lambda calls: held(calls, 0.0, -GENTLE))
    page.evaluate(f"window.dispatchEvent(new Event('{event}'))")
    board.wait(released)
    page.keyboard.up("l")


def test_the_stick_drives_as_far_as_it_is_pulled_and_springs_back(page: Page, board: Board) -> None:
    box = page.locator("[data-testid=stick]").bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x, y - 19, steps=3)
    board.wait(lambda calls: held(calls, 0.5, 0.0) >= 3)
    page.mouse.move(x - 500, y, steps=3)
    board.wait(lambda calls: held(calls, 0.0, 1.0))
    page.mouse.up()
    board.wait(released)


@pytest.fixture
def scanning(page: Page, board: Board) -> Iterator[Page]:
    page.wait_for_function("window.__iwScan")
    yield page
    page.mouse.move(1, 1)
    choose(board, OFF)
    page.wait_for_selector("#iw-scan", state="detached")


def choose(board: Board, method: str, seconds: float = 5.0) -> None:
    """Choose a method of scanning. `test_scan_panel` chooses as a page does."""
    assign(board.scan.method, method)
    assign(board.scan.seconds, seconds)
    board.scan._restart()
    if method != OFF:
        # A switch that is down in the first message after the choice may have been down before it: it selects nothing.
        until(lambda: board.scan._scan._updated is not None)


def test_a_switch_drives_the_highlighted_way_and_does_not_pause(scanning: Page, board: Board) -> None:
    choose(board, "One switch")
    scanning.wait_for_selector("#iw-scan .lit[data-scan='1']")
    scanning.keyboard.down(" ")
    board.wait(lambda calls: held(calls, GENTLE, 0.0) >= 5)
    scanning.wait_for_selector("#iw-scan .driving[data-scan='1']")
    scanning.keyboard.up(" ")
    board.wait(released)
    scanning.keyboard.down(" ")
    board.wait(lambda calls: not released(calls))
    scanning.evaluate("window.dispatchEvent(new Event('blur'))")
    board.wait(released)
    scanning.keyboard.up(" ")
    assert {call[0] for call in board.calls} == {"stick"}


def test_a_pointer_that_rests_on_a_command_drives_until_it_leaves(scanning: Page, board: Board) -> None:
    choose(board, "Dwell", 0.4)
    scanning.wait_for_selector("#iw-scan")
    assert scanning.evaluate(FAULTS) == []
    scanning.locator("#iw-scan [data-scan='2']").hover()
    # The board is drawn again under the pointer, which does not move.
    board.wait(lambda calls: held(calls, 0.0, GENTLE) >= 5)
    scanning.mouse.move(1, 1)
    board.wait(released)


def test_a_short_press_of_a_switch_counts(scanning: Page, board: Board) -> None:
    choose(board, "Two switches")
    scanning.wait_for_selector("#iw-scan .lit[data-scan='1']")
    for lit in (2, 3, 4):
        until(lambda: not board.scan._scan._pressed)
        scanning.keyboard.press(" ")
        scanning.wait_for_selector(f"#iw-scan .lit[data-scan='{lit}']", timeout=5000.0)


def test_a_finger_that_was_lifted_rests_nowhere(scanning: Page, board: Board) -> None:
    choose(board, "Dwell", 3.0)
    cell = scanning.locator("#iw-scan [data-scan='2']")
    cell.scroll_into_view_if_needed()
    box = cell.bounding_box()
    assert box is not None
    at = f"{{clientX: {box['x'] + 5}, clientY: {box['y'] + 5}, pointerType: 'touch'}}"
    scanning.evaluate(f"window.dispatchEvent(new PointerEvent('pointermove', {at}))")
    scanning.wait_for_selector("#iw-scan [data-scan='2'] i", state="attached", timeout=5000.0)
    scanning.evaluate(f"window.dispatchEvent(new PointerEvent('pointerup', {at}))")
    scanning.wait_for_selector("#iw-scan [data-scan='2'] i", state="detached", timeout=2500.0)
    assert board.calls == []


def test_typing_is_not_driving(page: Page, board: Board) -> None:
    field = page.locator("form input:visible").first
    field.fill("")
    # As a person types: viser sends one message in 50 ms, and of those between the newest only.
    field.press_sequentially("jolly kilt", delay=80)
    field.press("Enter")
    board.wait(lambda calls: ("say", "jolly kilt", None) in calls)
    assert not any(call[0] == "stick" for call in board.calls)


def test_keys_drive_while_another_tab_is_open(page: Page, board: Board) -> None:
    page.get_by_role("tab", name="Layers").click()
    page.keyboard.down("i")
    board.wait(lambda calls: held(calls, GENTLE, 0.0) >= 2)
    page.keyboard.up("i")
    board.wait(released)


def test_keys_drive_before_the_tab_drive_was_ever_open(chromium: Any) -> None:
    with served(made_up.snapshot(), made_up.choices()) as (server, boards):
        page = opened(chromium, server)
        page.get_by_role("tab", name="Agents").click()
        page.wait_for_function("window.__iwDrive && !document.getElementById('iw-drive-off')")
        assert page.query_selector("#iw-stick") is None
        page.keyboard.down("i")
        boards[0].wait(lambda calls: held(calls, GENTLE, 0.0) >= 2)
        page.keyboard.up("i")
        boards[0].wait(released)
        page.close()


@pytest.mark.parametrize("where", ["tab", "button", "checkbox"])
def test_keys_work_wherever_the_focus_is(page: Page, board: Board, where: str) -> None:
    triggered = threading.Event()
    command = board.gui.add_command("Try", hotkey="space")

    @command.on_trigger
    async def note(_: object) -> None:
        triggered.set()

    # The command is there when the page lists it: until then the key is nobody's.
    page.wait_for_function("window.__iwKeys")
    if where == "tab":
        page.get_by_role("tab", name="Layers").click()
    elif where == "button":
        page.get_by_role("button", name="Pause").click()
    else:
        page.get_by_label("Buttons").click()
    assert page.evaluate("document.activeElement !== document.body")
    try:
        for _ in range(20):
            page.keyboard.press("Space")
            if triggered.wait(0.5):
                break
        assert triggered.is_set()
        assert [call[0] for call in board.calls].count("pause") == int(where == "button")
        page.keyboard.down("i")
        board.wait(lambda calls: held(calls, GENTLE, 0.0))
        page.keyboard.up("i")
        board.wait(released)
    finally:
        command.remove()
        if where == "checkbox":
            page.get_by_label("Buttons").click()


def test_a_list_gives_the_keys_back_once_something_is_chosen(page: Page, board: Board) -> None:
    everybody = board.drive._to.value
    try:
        page.locator(f"[id='{element_id(board.drive._to)}']").click()
        page.get_by_role("option", name="chair1").click()
        page.wait_for_function("document.activeElement === document.body")
        until(lambda: board.drive._to.value == "chair1")
    finally:
        # The page is that of all tests here.
        cast(Any, board.drive._to).value = everybody


def test_space_presses_what_was_reached_with_the_tab_key(page: Page, board: Board) -> None:
    page.get_by_role("button", name="Pause").focus()
    page.keyboard.press("Shift+Tab")
    page.keyboard.press("Tab")
    page.keyboard.press("Space")
    board.wait(lambda calls: ("pause",) in calls)


def test_a_key_is_dead_while_nobody_is_selected(page: Page, board: Board) -> None:
    board.show(made_up.snapshot(), replace(made_up.choices(), selected=None))
    page.wait_for_selector("#iw-drive-off", state="attached")
    page.keyboard.press("i")
    page.get_by_role("button", name="Pause").click()
    board.wait(lambda calls: ("pause",) in calls)
    assert board.calls == [("pause",)]


def test_a_row_selects_while_the_table_is_rewritten(page: Page, board: Board) -> None:
    page.get_by_role("tab", name="Agents").click()
    row = page.get_by_test_id("agent-chair3").bounding_box()
    assert row is not None
    page.mouse.move(row["x"] + 60, row["y"] + 10)
    page.mouse.down()
    board.show(replace(made_up.snapshot(), entities=made_up.snapshot().entities[:5]), made_up.choices())
    page.wait_for_selector("[data-testid=agent-chair6]", state="detached")
    page.mouse.up()
    board.wait(lambda calls: ("select", "chair3") in calls)


def test_a_body_in_the_plan_selects(page: Page, board: Board) -> None:
    page.get_by_role("tab", name="Selected").click()
    page.locator("[data-testid=plan] [data-agent=chair4]").click(force=True)
    board.wait(lambda calls: ("select", "chair4") in calls)


def test_disabled_groups_cannot_be_pressed(page: Page, board: Board) -> None:
    board.show(made_up.snapshot(), replace(made_up.choices(), rights=DENIED))
    page.wait_for_function("[...document.querySelectorAll('button')].find(b => b.innerText === 'Reset').disabled")


def test_a_closed_page_sends_a_last_zero_and_then_nothing(chromium: Any) -> None:
    with served(made_up.snapshot(), made_up.choices()) as (server, boards):
        page = opened(chromium, server)
        page.get_by_role("tab", name="Drive").click()
        page.wait_for_function("window.__iwDrive")
        page.keyboard.down("i")
        boards[0].wait(lambda calls: held(calls, GENTLE, 0.0) >= 2)
        page.close()
        boards[0].wait(released)
