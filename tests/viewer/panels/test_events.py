"""The list of events."""

from __future__ import annotations

import re
from dataclasses import replace

import viser

from intellwheels_schemas.messages import Event
from intellwheels_viewer.panels.events import ALL, FILTERS, SHOWN, EventsPanel, events_html
from intellwheels_viewer.snapshot import USER, Utterance
from tests.viewer.panels import made_up
from tests.viewer.panels.panel import enter


def test_newest_first_with_times() -> None:
    page = events_html(made_up.snapshot())
    assert re.findall(r"<li data-code[^>]*><span>([\d.]+)<", page)[:3] == ["80.05", "65.00", "60.15"]


def test_a_contact_is_red_and_nothing_else() -> None:
    page = events_html(made_up.snapshot())
    assert page.count("iw-red") == 2
    assert '<span class="iw-red">chair1 hit chair3 at 0.11 m/s</span>' in page


def test_another_run_begins_below_a_line() -> None:
    page = events_html(made_up.snapshot())
    assert page.count("previous run") == 1
    assert page.index("previous run") < page.index("A new run started")


def test_a_long_list_is_cut_and_says_so() -> None:
    many = tuple(Event(run=made_up.RUN, tick=k, number=k, code="late", agent="a") for k in range(SHOWN + 7))
    page = events_html(replace(made_up.snapshot(), events=many))
    assert page.count("<li") == SHOWN
    assert "and 7 older" in page


def test_no_events_are_said_in_words() -> None:
    assert "Nothing has happened yet" in events_html(replace(made_up.snapshot(), events=()))


def test_words_of_a_peer_are_text() -> None:
    assert "<img" not in events_html(made_up.hostile())


def test_panel_shows_the_list(gui: viser.GuiApi) -> None:
    panel = EventsPanel(gui)
    panel.show(made_up.snapshot())
    assert panel._list.content == events_html(made_up.snapshot())


def test_what_a_user_said_is_an_event_at_its_time() -> None:
    base = made_up.snapshot()
    speech = (
        Utterance(USER, 61.0, "<b>stop</b>", "chair1"),
        Utterance(USER, 70.0, "hello"),
        Utterance("chair1", 71.0, "I hear"),
    )
    page = events_html(replace(base, utterances=speech))
    times = re.findall(r"<li data-code[^>]*><span>([\d.]+)<", page)
    assert times[:5] == ["80.05", "70.00", "65.00", "61.00", "60.15"]
    assert "A user said to everybody: \u201chello\u201d" in page
    assert "A user said to chair1: \u201c&lt;b&gt;stop&lt;/b&gt;\u201d" in page
    assert "I hear" not in page
    assert "hello" in events_html(replace(base, utterances=speech, events=()))


def test_the_list_can_be_limited_to_one_kind(gui: viser.GuiApi) -> None:
    snapshot = replace(made_up.snapshot(), utterances=(Utterance(USER, 61.0, "stop"),))
    codes = {only: set(re.findall(r'data-code="([a-z]+)"', events_html(snapshot, only))) for only in FILTERS}
    assert codes["Contacts"] == {"contact", "parted"}
    assert codes["Run"] == {"reset", "resumed"}
    assert codes["Words"] == {"said"}
    assert codes[ALL] == codes["Contacts"] | codes["Agents"] | codes["Run"] | codes["Words"]
    panel = EventsPanel(gui)
    panel.show(snapshot)
    enter(panel._filter.pick._field, "Contacts")
    assert panel._filter.active == "Contacts"
    assert panel._list.content == events_html(snapshot, "Contacts")


def test_a_kind_of_which_nothing_happened_says_so() -> None:
    assert "Contacts: nothing yet." in events_html(replace(made_up.snapshot(), events=()), "Contacts")
