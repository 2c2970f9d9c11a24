""" "Go there": for minds that take goals, by a put that follows what can be refused."""

from __future__ import annotations

from dataclasses import replace

import pytest

from intellwheels_schemas.messages import Take
from intellwheels_viewer.goal_click import takes_goals
from tests.viewer.opened import SNAPSHOT, Opened
from tests.viewer.wire import body, until

TAKES = replace(SNAPSHOT, bodies={"a": body("a", user_input=("goal",)), "b": body("b")})

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")


def test_only_a_mind_that_takes_goals_is_offered_one(here: Opened) -> None:
    assert [takes_goals(TAKES, name) for name in ("a", "b", "nobody", None)] == [True, False, False, False]
    here.show(TAKES)
    for name, shown in (("a", True), ("b", False), ("a", True), (None, False)):
        here.page.select(name)
        here.show(TAKES)
        parts = here.page._controls._parts
        assert parts is not None
        assert parts.goal.visible is shown


def test_a_click_for_nobody_or_for_a_mind_that_takes_none_sets_nothing(here: Opened) -> None:
    here.page._aim()
    here.browser.wait(lambda: any("Nothing is selected" in str(message) for message in here.browser.heard))
    here.page.select("a")
    here.page._aim()
    here.browser.wait(lambda: any("does not take goals" in str(message) for message in here.browser.heard))
    here.page._goal_click.put(1.0, 1.0)
    assert (here.network.asked, here.network.puts) == ([], [])


def test_a_goal_is_told_once_the_body_was_taken_and_given_back(here: Opened) -> None:
    here.page.select("a")
    here.show(TAKES)
    here.page._aim()
    here.page._goal_click.put(2.5, 1.5)
    until(lambda: here.network.puts)
    ((agent, request),) = here.network.puts
    assert (agent, request.lease) == ("a", None)
    assert request.goal is not None
    assert (request.goal.x, request.goal.y) == (2.5, 1.5)
    taken, given = here.network.asked
    assert taken[0] == "take"
    assert given == ("take", Take(agent="a", lease="0" * 16, seconds=0.0))
    here.page._goal_click.put(3.0, 3.0)  # one click, one goal
    assert len(here.network.puts) == 1


def test_a_goal_outside_the_floor_is_refused_and_the_next_click_counts(here: Opened) -> None:
    here.page.select("a")
    here.show(TAKES)
    here.page._aim()
    here.page._goal_click.put(900.0, 1.5)
    here.browser.wait(lambda: any("outside the map" in str(message) for message in here.browser.heard))
    assert (here.network.asked, here.network.puts) == ([], [])
    here.page._goal_click.put(2.5, 1.5)
    until(lambda: here.network.puts)


def test_who_places_does_not_aim(here: Opened) -> None:
    here.page.select("a")
    here.show(TAKES)
    here.page._aim()
    here.page._choose("Table")
    here.page._goal_click.put(2.5, 1.5)
    assert here.network.puts == []


def test_a_refused_goal_says_why(here: Opened) -> None:
    here.network.refuses = "taken by somebody else"
    here.page.select("a")
    here.show(TAKES)
    here.page._aim()
    here.page._goal_click.put(2.5, 1.5)
    here.browser.wait(lambda: any("taken by somebody else" in str(message) for message in here.browser.heard))
    assert here.network.puts == []
