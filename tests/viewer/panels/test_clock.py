"""The run's clock and its buttons."""

from __future__ import annotations

from dataclasses import replace

import msgspec
import pytest
import viser

from intellwheels_schemas.messages import Event, Identity, May
from intellwheels_viewer.page_rights import PageRights
from intellwheels_viewer.panels.choices import Choices
from intellwheels_viewer.panels.clock import ClockPanel, clock_html
from intellwheels_viewer.snapshot import Snapshot
from tests.viewer.panels import made_up
from tests.viewer.panels.made_up import LOOKS_ONLY
from tests.viewer.panels.panel import Calls, enter, press


def at(state: str, **changes: object) -> Snapshot:
    return replace(made_up.snapshot(), clock=made_up.clock(state, **changes))


def panel(gui: viser.GuiApi, calls: Calls) -> ClockPanel:
    return ClockPanel(
        gui, on_pause=calls.to("pause"), on_resume=calls.to("resume"), on_step=calls.to("step"),
        on_reset=calls.to("reset"), on_speed=calls.to("speed"),
    )  # fmt: skip


def test_a_run_shows_time_tick_factor_and_late_ticks() -> None:
    page = clock_html(at("running"))
    assert all(
        word in page
        for word in (
            "Running",
            ">84.35<",
            ">1687<",
            ">1.00<",
            "in real time, 3 ticks began late",
            "because the machine is busy",
        )
    )


@pytest.mark.parametrize("state", ["paused", "waiting", "ended"])
def test_a_run_that_stands_says_so_in_place_of_a_factor(state: str) -> None:
    page = clock_html(at(state))
    assert f">{state}<" in page
    assert "0.00" not in page


def test_who_is_waited_for_is_named_but_not_all() -> None:
    assert "Waiting for a, b, c and 2 more" in clock_html(at("waiting", waiting=("a", "b", "c", "d", "e")))


def test_one_late_tick_and_none_are_written_as_spoken() -> None:
    assert "1 tick began late" in clock_html(at("running", late=1))
    assert "no tick began late" in clock_html(at("running", late=0))


def test_busy_simulator_says_so_and_whose_sensors_cost_most() -> None:
    page = clock_html(at("running", load=0.93, world=0.6, wire=0.33, rays=23_040, costliest="chair2"))
    assert "Busy 93 %: world 60 %, messages 33 %. Ticks may be late." in page
    assert "23,040 rays per tick, most of them those of chair2" in page
    assert "rays" not in clock_html(at("running", load=0.93))
    for calm in (at("running", load=0.5), at("running", load=0.93, pace="free")):
        assert "Busy" not in clock_html(calm)


def test_who_floods_is_named_in_a_line_that_is_there_always() -> None:
    assert "chair3 sends too many messages." in clock_html(at("running", flooding="chair3"))
    for shown in (at("running"), at("running", load=0.93, costliest="chair2"), at("running", flooding="chair3")):
        page = clock_html(shown)
        assert page.count('class="iw-small') == 2, "nothing below may move"
        assert "iw-note" not in page


def test_another_speed_is_shown() -> None:
    assert "speed 0.5 \u00d7" in clock_html(at("running", speed=0.5))


def test_the_speed_in_use_is_marked(gui: viser.GuiApi, calls: Calls) -> None:
    shown = panel(gui, calls)
    shown.show(at("running", speed=2.0), Choices())
    assert shown._speed.active == "2"
    shown.show(at("running", pace="free"), Choices())
    assert shown._speed.active is None


def test_words_of_a_peer_are_text() -> None:
    assert "<img" not in clock_html(made_up.hostile())


def test_buttons_call(gui: viser.GuiApi, calls: Calls) -> None:
    shown = panel(gui, calls)
    press(shown._pause)
    press(shown._resume)
    enter(shown._step, "10")
    enter(shown._speed.pick._field, "0.5")
    enter(shown._reset, "Reset")
    assert calls == [("pause",), ("resume",), ("step", 10), ("speed", 0.5), ("reset",)]


def test_either_pause_or_resume_is_there(gui: viser.GuiApi, calls: Calls) -> None:
    shown = panel(gui, calls)
    shown.show(at("running"), Choices())
    assert (shown._pause.visible, shown._resume.visible) == (True, False)
    shown.show(at("paused"), Choices())
    assert (shown._pause.visible, shown._resume.visible) == (False, True)


def disabled(shown: ClockPanel) -> list[bool]:
    step, reset = (group._impl.props.disabled for group in (shown._step, shown._reset))  # type: ignore[attr-defined]
    return [shown._pause.disabled, step, shown._speed.disabled, reset]


def test_what_cannot_act_is_disabled(gui: viser.GuiApi, calls: Calls) -> None:
    shown = panel(gui, calls)
    shown.show(at("running"), Choices())
    assert disabled(shown) == [False] * 4
    shown.show(at("running"), Choices(rights=LOOKS_ONLY))
    assert disabled(shown) == [True] * 4
    assert not any(one.visible for one in (shown._pause, shown._resume, shown._step, shown._speed, shown._reset))
    shown.show(replace(at("running"), phase="silent"), Choices())
    assert disabled(shown) == [True] * 4
    shown.show(at("running", pace="lockstep"), Choices())
    assert disabled(shown) == [False, False, True, False]


def test_verb_that_is_denied_is_disabled_and_named(gui: viser.GuiApi, calls: Calls) -> None:
    may = (May(role="operator", verbs=("pause", "resume")),)
    shown = panel(gui, calls)
    shown.show(at("running"), Choices(rights=PageRights(holders=(Identity(name="helper", may=may),))))
    assert disabled(shown) == [False, True, True, True]
    assert "helper may not ask for ctl/step, ctl/speed, ctl/reset in world main" in shown._clock.content


def test_a_log_has_its_buttons_beside_its_time_line(gui: viser.GuiApi, calls: Calls) -> None:
    shown = panel(gui, calls)
    shown.show(replace(at("running"), last_tick=2000), Choices())
    assert not any(one.visible for one in (shown._pause, shown._resume, shown._speed, shown._reset))


def test_a_run_that_is_over_offers_to_run_again(gui: viser.GuiApi, calls: Calls) -> None:
    shown = panel(gui, calls)
    shown.show(at("running"), Choices())
    assert not shown._again.visible
    shown.show(at("ended"), Choices())
    assert shown._again.visible
    assert not shown._again.disabled
    assert shown._resume.label == "Continue this run"
    assert "The run is over" in clock_html(at("ended"))
    press(shown._again)
    assert calls == [("reset",)]
    shown.show(replace(at("ended"), last_tick=3400), Choices())
    assert not shown._again.visible
    assert "The run is over" not in clock_html(replace(at("ended"), last_tick=3400))


def test_a_run_that_went_on_after_its_end_says_when_that_was() -> None:
    ended = Event(run=made_up.RUN, tick=1500, number=20, code="ended")
    beyond = replace(at("running"), events=(*made_up.events(), ended))
    assert beyond.judged == pytest.approx(75.0)
    page = clock_html(beyond)
    assert "Running" in page
    assert "The end condition was met at 75.00 s. The world has gone on since then." in page
    assert "gone on" not in clock_html(at("running"))
    # A run that has just ended stands still, and the event of another run is not of this one.
    over = replace(at("ended"), events=(msgspec.structs.replace(ended, tick=made_up.TICK),))
    assert over.judged is None
    assert "stands still; speeds are its last ones" in clock_html(over)
    other = replace(at("running"), events=(msgspec.structs.replace(ended, run="0" * 16),))
    assert other.judged is None


def test_awaited_agents_are_in_natural_order() -> None:
    assert "Waiting for chair2, chair10" in clock_html(at("waiting", waiting=("chair10", "chair2")))
