"""The table of bodies."""

from __future__ import annotations

import re
from dataclasses import replace

import msgspec
import viser

from intellwheels_schemas.agent_colours import colour_of, css
from intellwheels_schemas.messages import Entity
from intellwheels_viewer.panels.agents import NOBODY, ROWS, AgentsPanel, agents_first, agents_html, words
from intellwheels_viewer.panels.choices import Choices
from tests.viewer.panels import made_up
from tests.viewer.panels.panel import Calls, enter


def row(page: str, name: str) -> str:
    found = re.search(rf'<tr class="[^"]*" data-agent="{name}".*?</tr>', page)
    assert found is not None
    return found[0]


def test_a_row_has_all_that_is_known_of_an_agent() -> None:
    page = agents_html(made_up.snapshot(), made_up.choices())
    assert all(
        word in row(page, "chair2") for word in ("real", "follow-wall", "stale", ">0.72<", css(colour_of("chair2")))
    )
    assert all(word in row(page, "chair3") for word in ("driven by a program", "touching", ">12<", "iw-red"))
    assert "driven by an operator who took it over" in row(page, "chair5")


def test_who_drives_a_chair_is_said_in_its_row_and_in_full_where_the_row_is_cut() -> None:
    page = agents_html(made_up.snapshot(), replace(made_up.choices(), driven="chair6"))
    assert "driven by a program, \u201cavoid\u201d</div>" in row(page, "chair1")
    assert 'title="real, driven by a program, \u201cfollow-wall\u201d, stale: no recent pose"' in row(page, "chair2")
    assert "driven by you, in this page" in row(page, "chair6")


def test_what_the_columns_mean_is_said() -> None:
    page = agents_html(made_up.snapshot(), made_up.choices())
    assert "red below 0.5 m" in page
    assert 'title="The smallest range that its sensors measure now."' in page


def test_the_selected_row_is_marked_and_no_other() -> None:
    page = agents_html(made_up.snapshot(), made_up.choices())
    assert page.count('class="chosen') == 1
    assert 'class="chosen' in row(page, "chair1")


def test_agents_come_before_what_an_operator_put_there() -> None:
    assert agents_first(made_up.snapshot())[-1].name == "table1"
    assert words(agents_first(made_up.snapshot())[-1], made_up.snapshot().bodies["table1"]) == "table, placed"


def test_age_of_the_commands_of_a_slow_agent_is_said() -> None:
    slow = Entity(name="a", x=0, y=0, heading=0, mode="drive", command_age=0.061)
    assert words(slow, None) == "\u201cdrive\u201d, commands 0.06 s old"
    assert words(msgspec.structs.replace(slow, command_age=0.0), None) == "\u201cdrive\u201d"


def test_no_agents_are_said_in_words() -> None:
    assert "No agents yet" in agents_html(replace(made_up.snapshot(), entities=()), Choices())
    assert "No agents yet" not in agents_html(made_up.nothing("no-router"), Choices())


def test_words_of_a_peer_are_text() -> None:
    page = agents_html(made_up.hostile(), made_up.attacked())
    assert "<img" not in page
    assert 'onerror="' not in page


def test_a_crowd_is_cut_but_the_selected_one_is_there() -> None:
    crowd = tuple(Entity(name=f"c{k}", x=0, y=0, heading=0) for k in range(300))
    page = agents_html(replace(made_up.snapshot(), entities=crowd), Choices(selected="c299"))
    assert page.count("<tr class") == ROWS + 1
    assert "and 259 more" in page
    assert 'data-agent="c299"' in page


def test_list_and_table_select_who_is_there_only(gui: viser.GuiApi, calls: Calls) -> None:
    panel = AgentsPanel(gui, calls.to("select"))
    panel.show(made_up.snapshot(), made_up.choices())
    for name in ("chair2", "stranger", NOBODY):
        enter(panel._list, name)
    enter(panel._pick._field, "chair3")
    enter(panel._pick._field, "stranger")
    assert calls == [("select", "chair2"), ("select", None), ("select", "chair3")]


def test_the_list_follows_who_is_there_and_selected(gui: viser.GuiApi, calls: Calls) -> None:
    panel = AgentsPanel(gui, calls.to("select"))
    panel.show(made_up.snapshot(), made_up.choices())
    assert panel._list.options == (NOBODY, *made_up.CHAIRS, "table1")
    assert panel._list.value == "chair1"
    panel.show(replace(made_up.snapshot(), entities=()), made_up.choices())
    assert panel._list.value == NOBODY
    assert calls == []


def test_in_a_log_that_is_played_who_joined_is_no_thing_that_was_placed() -> None:
    snapshot = made_up.snapshot()
    body = snapshot.bodies["chair1"]
    robot = msgspec.structs.replace(body.robot, instance="a" * 16)
    nobodys = msgspec.structs.replace(body, owner=None, robot=robot)
    assert words(snapshot.entities[0], nobodys).startswith("driven by a program")


def test_agents_are_in_natural_order() -> None:
    base = made_up.snapshot()
    entities = tuple(Entity(name=name, x=0.0, y=0.0, heading=0.0) for name in ("chair10", "chair2", "table1"))
    found = agents_first(replace(base, entities=entities))
    assert [entity.name for entity in found] == ["chair2", "chair10", "table1"]
