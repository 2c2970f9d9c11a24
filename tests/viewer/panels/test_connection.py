"""The connection's state in words."""

from __future__ import annotations

from dataclasses import replace
from typing import get_args

import pytest
import viser

from intellwheels_viewer.panels.choices import Choices
from intellwheels_viewer.panels.connection import (
    GREYED,
    NO_WORLD,
    ConnectionPanel,
    connection_html,
    empty_scene_text,
    state,
)
from intellwheels_viewer.snapshot import Phase, Snapshot
from tests.viewer.panels import made_up
from tests.viewer.panels.made_up import LOOKS_ONLY
from tests.viewer.panels.panel import Calls, enter


@pytest.mark.parametrize("phase", get_args(Phase))
def test_every_phase_has_words(phase: str) -> None:
    tone, title, text = state(made_up.nothing(phase), Choices())
    assert tone in {"good", "wait", "bad"}
    assert title
    assert text


@pytest.mark.parametrize(
    ("phase", "words"),
    [
        (
            "no-router",
            [
                "Nothing at tcp/127.0.0.1:7447",
                "<code>iw-run figure6 --pace realtime --listen tcp/127.0.0.1:7447</code>",
            ],
        ),
        (
            "no-world",
            ["No world is running", "<code>iw-run figure6 --pace realtime --connect tcp/127.0.0.1:7447</code>"],
        ),
        ("silent", ["Simulator silent for 7 s", "This is the last picture"]),
        ("gone", ["World main has gone"]),
    ],
)
def test_what_is_wrong_comes_with_what_to_do(phase: str, words: list[str]) -> None:
    page = connection_html(made_up.nothing(phase, world="main"), Choices(quiet=7.2))
    assert all(one in page for one in words)


def test_who_may_only_look_is_told() -> None:
    snapshot = made_up.snapshot()
    assert "View only" in connection_html(snapshot, Choices(rights=LOOKS_ONLY))
    assert "View only" not in connection_html(snapshot, Choices())
    assert "As guest this page may steer chair2" in connection_html(snapshot, Choices(rights=made_up.DENIED))
    unseen = replace(snapshot, phase="no-world", world="ward")
    assert "guest may not read state/* in world ward" in connection_html(unseen, Choices(rights=made_up.DENIED))


def test_a_run_that_is_over_and_whose_processes_have_ended_says_so() -> None:
    over = replace(made_up.snapshot(), phase="gone", clock=made_up.clock("ended"))
    page = connection_html(over, Choices())
    assert "The run is over" in page
    assert "Its processes have ended" in page
    assert GREYED in page
    assert "The run is over" not in connection_html(replace(over, clock=made_up.clock("running")), Choices())


def test_words_of_a_peer_are_text() -> None:
    assert "<img" not in connection_html(made_up.hostile(), made_up.attacked())


def test_worlds_are_offered_where_there_are_several(gui: viser.GuiApi, calls: Calls) -> None:
    panel = ConnectionPanel(gui, calls.to("world"))
    panel.show(replace(made_up.snapshot(), worlds=("main",)), Choices())
    assert not panel._worlds.visible
    panel.show(made_up.nothing("choose", worlds=("lab", "main")), Choices())
    assert panel._worlds.visible
    assert (panel._worlds.value, panel._worlds.options) == (NO_WORLD, (NO_WORLD, "lab", "main"))
    panel.show(made_up.snapshot(), Choices())
    assert (panel._worlds.value, panel._worlds.options) == ("main", ("lab", "main"))
    assert calls == []


def test_only_a_world_that_is_there_can_be_chosen(gui: viser.GuiApi, calls: Calls) -> None:
    panel = ConnectionPanel(gui, calls.to("world"))
    panel.show(Snapshot(phase="choose", worlds=("lab", "main")), Choices())
    for world in ("elsewhere", NO_WORLD, "lab"):
        enter(panel._worlds, world)
    assert calls == [("world", "lab")]


def test_a_world_that_was_named_and_is_not_there_is_told_apart_from_a_choice() -> None:
    waiting = connection_html(made_up.nothing("choose", worlds=("lab",), world="ward"), Choices())
    assert "World ward is not running" in waiting
    assert "1 world is running" in connection_html(made_up.nothing("choose", worlds=("lab",)), Choices())
    assert "2 worlds are running" in connection_html(made_up.nothing("choose", worlds=("lab", "ward")), Choices())


def test_where_the_world_has_gone_the_only_other_one_is_offered(gui: viser.GuiApi, calls: Calls) -> None:
    panel = ConnectionPanel(gui, calls.to("world"))
    panel.show(made_up.nothing("gone", worlds=("lab",), world="ward"), Choices())
    assert panel._worlds.visible
    enter(panel._worlds, "lab")
    assert calls == [("world", "lab")]


@pytest.mark.parametrize("phase", get_args(Phase))
def test_an_old_picture_is_greyed_and_the_text_says_so(phase: str) -> None:
    page = connection_html(made_up.nothing(phase), Choices())
    assert (GREYED in page) == ("the last picture" in page)


def test_an_empty_scene_says_why_and_one_with_a_floor_says_nothing() -> None:
    words = empty_scene_text(made_up.nothing("no-router"), Choices())
    assert words == (
        "Nothing at tcp/127.0.0.1:7447\nStart a scene:\niw-run figure6 --pace realtime --listen tcp/127.0.0.1:7447\n"
        "This page shows it as soon as it runs."
    )
    assert empty_scene_text(made_up.snapshot(), Choices()) == ""
