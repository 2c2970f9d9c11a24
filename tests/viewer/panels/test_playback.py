"""The time line of a log."""

from __future__ import annotations

import math
from dataclasses import replace

import viser

from intellwheels_schemas.messages import Pose
from intellwheels_viewer.panels.choices import Choices
from intellwheels_viewer.panels.playback import HOLD_AFTER_DRAG, PlaybackPanel, playback_html
from tests.viewer.panels import made_up
from tests.viewer.panels.made_up import LOOKS_ONLY
from tests.viewer.panels.panel import Calls, enter, press


class Wall:
    """A wall clock that stands until it is moved."""

    def __init__(self) -> None:
        self.time = 100.0

    def __call__(self) -> float:
        return self.time


def panel(gui: viser.GuiApi, calls: Calls, wall: Wall) -> PlaybackPanel:
    return PlaybackPanel(
        gui, on_seek=calls.to("seek"), on_pause=calls.to("pause"), on_resume=calls.to("resume"),
        on_speed=calls.to("speed"), now=wall,
    )  # fmt: skip


LOG = replace(made_up.snapshot(), last_tick=3400)


def test_how_far_the_log_is() -> None:
    assert "84.35 of 170.00 s, tick 1687 of 3400" in playback_html(LOG)


def test_a_simulated_world_has_no_time_line(gui: viser.GuiApi, calls: Calls) -> None:
    shown = panel(gui, calls, Wall())
    shown.show(made_up.snapshot(), Choices())
    assert playback_html(made_up.snapshot()) == ""
    assert not any(one.visible for one in (shown._words, shown._line, shown._pause, shown._resume, shown._speed))


def test_the_line_follows_the_log(gui: viser.GuiApi, calls: Calls) -> None:
    shown = panel(gui, calls, Wall())
    shown.show(LOG, Choices())
    assert (shown._line.visible, shown._line.max, shown._line.value) == (True, 3400, 1687)
    assert (shown._pause.visible, shown._resume.visible) == (True, False)
    assert calls == []


def test_the_line_does_not_move_under_a_hand(gui: viser.GuiApi, calls: Calls) -> None:
    wall = Wall()
    shown = panel(gui, calls, wall)
    shown.show(LOG, Choices())
    enter(shown._line, 20)
    shown.show(LOG, Choices())
    assert shown._line.value == 20
    wall.time += HOLD_AFTER_DRAG
    shown.show(LOG, Choices())
    assert shown._line.value == 1687
    assert calls == [("seek", 20)]


def test_a_tick_that_no_log_has_is_bounded(gui: viser.GuiApi, calls: Calls) -> None:
    shown = panel(gui, calls, Wall())
    shown.show(LOG, Choices())
    enter(shown._line, 10**9)
    enter(shown._line, -5)
    assert calls == [("seek", 3400), ("seek", 0)]


def test_buttons_call_and_are_disabled_without_rights(gui: viser.GuiApi, calls: Calls) -> None:
    shown = panel(gui, calls, Wall())
    press(shown._pause)
    press(shown._resume)
    enter(shown._speed.pick._field, "2")
    assert calls == [("pause",), ("resume",), ("speed", 2.0)]
    shown.show(LOG, Choices(rights=LOOKS_ONLY))
    assert shown._line.disabled


def test_how_far_a_real_chair_was_from_where_it_said_it_was() -> None:
    one = LOG.entities[0]
    pose = Pose(tick=LOG.tick, x=one.x + 0.3, y=one.y - 0.4, heading=one.heading + math.radians(2.0))
    words = playback_html(replace(LOG, reported={one.name: pose, "gone": pose}))
    assert f"pose reported by {one.name}, off by 0.50 m and 2.0\u00b0" in words
    assert "gone" not in words
