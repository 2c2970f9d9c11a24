"""One browser's page: what it selects, wishes, places and drives, from messages as a page would send them."""

from __future__ import annotations

import threading
from dataclasses import replace
from typing import Any, cast

import pytest
import viser

from intellwheels_schemas.messages import (
    Delete,
    OperatorSay,
    Pause,
    Record,
    Reset,
    Resume,
    Step,
    Take,
    Teleport,
)
from intellwheels_viewer.page import MODES
from intellwheels_viewer.snapshot import Snapshot
from tests.viewer.browser import opened
from tests.viewer.opened import SNAPSHOT, Opened
from tests.viewer.panels import made_up
from tests.viewer.wire import body, clock, entity, until

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")

# ---------------------------------------------------------------- selecting and looking


def test_following_needs_somebody_and_says_so(here: Opened) -> None:
    here.page.look("follow")
    assert here.page.camera.mode == "free"
    here.browser.wait(lambda: any("Nothing is selected" in str(message) for message in here.browser.heard))


def test_a_selected_chair_is_followed_and_nobody_ends_it(here: Opened) -> None:
    here.page.select("a")
    here.page.look("follow")
    assert here.page.camera.mode == "follow"
    here.page.select("b")
    assert (here.page.selected, here.page.camera.mode) == ("b", "follow")
    here.page.select(None)
    assert str(here.page.camera.mode) == "free"


def test_every_way_to_look_is_in_the_list_and_all_modes_are_drawn(here: Opened) -> None:
    here.page.select("a")
    for label, mode in MODES.items():
        here.browser.enter("Camera", label)
        until(lambda mode=mode: here.page.camera.mode == mode)  # type: ignore[misc]
        here.show(SNAPSHOT)


def test_a_way_to_look_that_there_is_not_is_free(here: Opened) -> None:
    here.page.select("a")
    here.page.look("plan")
    here.browser.enter("Camera", "<script>")
    until(lambda: here.page.camera.mode == "free")


def test_what_decides_what_is_drawn_is_told(here: Opened) -> None:
    before = here.page.view_state
    here.page.select("a")
    assert here.page.view_state != before


def test_a_selection_outlives_the_one_who_was_selected(here: Opened) -> None:
    here.page.select("a")
    here.page.look("first")
    here.show(replace(SNAPSHOT, entities=(), bodies={}))
    here.show(Snapshot())
    here.show(SNAPSHOT)
    assert here.page.selected == "a"


def test_the_mode_may_change_while_the_panels_are_filled(here: Opened) -> None:
    faults: list[Exception] = []
    done = threading.Event()

    def choose() -> None:
        while not done.is_set():
            for mode in ("first", "free", "follow", "plan"):
                here.page.camera.choose(cast(Any, mode), SNAPSHOT.entities[0])

    choosing = threading.Thread(target=choose)
    choosing.start()
    try:
        for _ in range(40):
            here.show(SNAPSHOT)
    except Exception as fault:
        faults.append(fault)
    done.set()
    choosing.join(10.0)
    assert faults == []


# ---------------------------------------------------------------- wishes


def command(here: Opened, label: str) -> dict[str, Any]:
    """Return a command of the palette, as the page was told."""

    def found() -> dict[str, Any] | None:
        commands = [one for one in here.browser.heard if one["type"] == "RegisterCommandMessage"]
        return next((one for one in commands if one["props"]["label"] == label), None)

    return dict(here.browser.wait(found))


def press(here: Opened, label: str) -> None:
    """Trigger a command of the palette, as its key does."""
    uuid = command(here, label)["uuid"]
    here.browser.send({"type": "CommandTriggerMessage", "uuid": uuid})


def test_space_pauses_resumes_and_runs_again(here: Opened) -> None:
    for state, message in (("running", Pause()), ("paused", Resume()), ("ended", Reset())):
        here.show(replace(SNAPSHOT, clock=clock(state=state)))
        press(here, "Pause, resume or run again")
        until(lambda message=message: here.network.asked and here.network.asked[-1][1] == message)  # type: ignore[misc]


def test_space_after_the_end_says_that_a_new_run_begins(here: Opened) -> None:
    def told() -> bool:
        return any("A new run of the scene begins." in str(message) for message in here.browser.heard)

    for state, notices in (("running", False), ("ended", True)):
        here.show(replace(SNAPSHOT, clock=clock(state=state)))
        before = len(here.network.asked)
        press(here, "Pause, resume or run again")
        until(lambda before=before: len(here.network.asked) > before)  # type: ignore[misc]
        if notices:
            here.browser.wait(told)
        else:
            assert not told()


def test_escape_ends_placing_and_waiting_for_a_goal(here: Opened) -> None:
    here.page._choose("Table")
    assert here.ghost()
    press(here, "Stop placing")
    until(lambda: not here.ghost() and here.page._placing_click.label is None)
    assert command(here, "Stop placing")["props"]["hotkey"] == "escape"


def test_a_drop_is_undone(here: Opened) -> None:
    here.show(SNAPSHOT)
    here.drag("a", ("start", (1.0, 1.0)), ("update", (2.0, 1.5)), ("end", (3.0, 2.0)))
    until(lambda: here.page._undo)
    press(here, "Undo the last move")
    until(lambda: len(here.network.asked) == 2)
    (_, there), (_, back) = here.network.asked
    assert isinstance(there, Teleport)
    assert isinstance(back, Teleport)
    assert (back.agent, back.position.x, back.position.y) == ("a", 1.0, 1.0)


def test_a_placed_body_is_undone(here: Opened) -> None:
    here.show(SNAPSHOT)
    here.page._choose("Table")
    here.page._placing_click.put(2.0, 3.0)
    until(lambda: here.page._undo)
    here.page._undo_newest()
    until(lambda: here.network.asked[-1] == ("delete", Delete(agent="table1")))


def test_a_refused_drop_moves_nothing_and_cannot_be_undone(here: Opened) -> None:
    here.show(SNAPSHOT)
    here.network.refuses = "overlaps a wall"
    here.drag("a", ("start", (1.0, 1.0)), ("update", (2.0, 1.5)), ("end", (3.0, 2.0)))
    until(lambda: here.network.asked)
    here.browser.wait(lambda: any("overlaps a wall" in str(message) for message in here.browser.heard))
    until(lambda: not here.ghost())
    assert not here.page._undo


def test_a_refusal_is_shown_once(here: Opened) -> None:
    here.network.refuses = "taken by somebody else"
    for _ in range(3):
        here.page._run_control.step(1)
    until(lambda: len(here.network.asked) == 3)
    here.page._run_control.pause()
    here.browser.wait(lambda: any("Not paused" in str(message) for message in here.browser.heard))
    notices = [message for message in here.browser.heard if "Not stepped" in str(message)]
    assert len(notices) == 1
    here.show(SNAPSHOT)
    assert "Not stepped" not in here.browser.text()


def test_digits_select_in_natural_order(here: Opened) -> None:
    names = ("chair10", "chair2", "chair1")
    here.show(
        replace(SNAPSHOT, entities=tuple(entity(name) for name in names), bodies={name: body(name) for name in names})
    )
    press(here, "Select agent 2")
    until(lambda: here.page.selected == "chair2")


@pytest.mark.parametrize(
    ("label", "message"), [("Pause", Pause()), ("Resume", Resume()), ("Remove", Delete(agent="a"))]
)
def test_a_button_sends_a_request(here: Opened, label: str, message: Record) -> None:
    here.page.select("a")
    matches = [each for each in here.browser.gui.values() if str(each.get("label", "")).startswith(label)]
    assert matches or here.browser.element(label)
    uuid = next(key for key, each in here.browser.gui.items() if str(each.get("label", "")).startswith(label))
    here.browser.send({"type": "GuiUpdateMessage", "uuid": uuid, "updates": {"value": True}})
    assert here.network.wished() == message


def test_a_refusal_is_shown_with_its_reason(here: Opened) -> None:
    here.network.refuses = made_up.ATTACK
    here.page._run_control.step(1)
    assert here.network.wished() == Step(count=1)
    here.browser.wait(lambda: any("Not stepped" in str(message) for message in here.browser.heard))


def test_no_text_of_an_agent_is_markup(here: Opened) -> None:
    here.page.select(made_up.ATTACK)
    here.show(made_up.hostile())
    here.browser.wait(lambda: "&lt;img src=x:" in here.browser.text())
    assert "<img src=x:" not in here.browser.text()


def test_words_are_said_to_one_or_all(here: Opened) -> None:
    here.page._say("hello", None)
    assert here.network.wished() == OperatorSay(text="hello")
    until(lambda: here.network.speech == [("hello", None)])


def test_what_was_refused_was_not_said(here: Opened) -> None:
    here.network.refuses = "too long"
    here.page._say("hello", "a")
    until(lambda: here.network.asked)
    here.browser.wait(lambda: any("too long" in str(message) for message in here.browser.heard))
    assert here.network.speech == []


# ---------------------------------------------------------------- driving


def test_the_stick_drives_who_is_selected_and_a_closed_page_stops(here: Opened) -> None:
    here.page._stick(0.5, 0.0, 1)
    assert here.network.puts == []
    here.page.select("a")
    until(lambda: here.page._stick(0.5, 0.0, 2) or here.network.puts)  # type: ignore[func-returns-value]
    assert here.network.puts[0][0] == "a"
    here.page.select("b")
    assert (here.network.puts[-1][0], here.network.puts[-1][1].forward) == ("a", 0.0)
    until(lambda: here.page._stick(0.5, 0.0, 3) or here.network.puts[-1][0] == "b")  # type: ignore[func-returns-value]
    here.page.close()
    assert here.network.puts[-1][1].forward == 0.0
    here.page.join(5.0)
    assert here.network.asked[-1] == ("take", Take(agent="b", lease="0" * 16, seconds=0.0))


# ---------------------------------------------------------------- the end


@pytest.mark.process
def test_a_page_that_has_left_can_still_be_drawn_to(pages: viser.ViserServer) -> None:
    with opened(pages.get_port()) as browser:
        made = Opened(pages, browser)
    until(lambda: not pages.get_clients())
    made.show(replace(SNAPSHOT, tick=SNAPSHOT.tick + 1))
    made.page.close()
    made.page.join(5.0)
    made.show(SNAPSHOT)
