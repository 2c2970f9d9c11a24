"""What a page has outside its panels, as far as it goes without a page; `test_page` presses it."""

from __future__ import annotations

import html
import re
from dataclasses import replace

import pytest
import viser

from intellwheels_viewer.page import MODES
from intellwheels_viewer.panels.choices import Choices
from intellwheels_viewer.panels.page_shell import (
    KEYS,
    PageShell,
    Window,
    link_html,
    script_html,
    status_html,
    tools_html,
    window_of,
)
from tests.viewer.panels import made_up
from tests.viewer.panels.panel import Calls, enter


def test_the_handler_stays_in_its_attribute() -> None:
    inner = script_html("one-id", "other-id").partition('onerror="')[2]
    assert inner.endswith('">')
    assert not {'"', "<"} & set(inner[:-2])
    script = html.unescape(inner[:-2])
    assert "one-id" in script
    assert "other-id" in script
    assert not re.findall(r"%[A-Z]+%", script)


def test_every_key_of_a_camera_is_in_the_list_of_keys() -> None:
    listed = " ".join(key for key, _ in KEYS)
    assert all(label[-2] in listed for label in MODES)


@pytest.mark.parametrize("state", ["running", "paused", "ended", "waiting"])
def test_the_bar_says_state_and_time(state: str) -> None:
    said = status_html(replace(made_up.snapshot(), clock=made_up.clock(state)), Choices())
    assert 'data-time="84.3 s"' in said or 'data-time="84.4 s"' in said
    assert f'data-tone="{"good" if state == "running" else "wait"}"' in said
    assert 'data-drives="1"' in said


def test_a_playback_and_a_page_that_only_looks_have_no_stick() -> None:
    assert 'data-drives=""' in status_html(replace(made_up.snapshot(), last_tick=9), Choices())
    assert 'data-drives=""' in status_html(made_up.snapshot(), Choices(rights=made_up.LOOKS_ONLY))
    assert 'data-state="No run"' in status_html(made_up.nothing("no-world"), Choices())


def test_a_recording_that_runs_is_seen() -> None:
    assert "aria-pressed" not in tools_html(recording=False)
    assert tools_html(recording=True).count("aria-pressed") == 1


def test_a_link_is_a_string_of_the_script() -> None:
    inner = link_html('?a="</script>').partition('onerror="')[2]
    assert not {'"', "<"} & set(inner[:-2])


def test_a_page_can_say_anything_of_its_window() -> None:
    assert window_of('{"width":390,"height":844,"dark":true,"covered":0.1,"query":""}') == Window(390, 844, True, 0.1)
    for text in (
        "",
        "{",
        "[]",
        '{"width":"wide"}',
        '{"covered":2}',
        '{"aspect":-1}',
        '{"width":-1}',
        "\ud800",
        f'{{"query":"{"x" * 3000}"}}',
    ):
        assert window_of(text) is None


def test_acts_and_windows_are_told_and_nothing_else(gui: viser.GuiApi, calls: Calls) -> None:
    shell = PageShell(gui, calls.to("act"), calls.to("window"))
    enter(shell._act, "record 123")
    enter(shell._act, "delete everything")
    enter(shell._window, "{}")
    enter(shell._window, "nonsense")
    assert calls == [("act", "record"), ("window", Window())]
    shell.copy_link("?agent=a")
    assert "?agent=a" in shell._link.content
