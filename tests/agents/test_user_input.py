"""User input becomes the same motor powers as in the simulator."""

from __future__ import annotations

import pytest

from intellwheels_agents.options import Options
from intellwheels_agents.user_input import Goals, mixed, takes_goals, unmixed, wanted
from intellwheels_maps import robot
from intellwheels_schemas.messages import Goal, UserInput
from intellwheels_server.world.kernels.motor_power import user_power
from tests.every_case import every_case


@every_case("forward", [-1.0, -0.3, 0.0, 0.5, 1.0])
@every_case("turn", [-1.0, 0.0, 0.2, 1.0])
def test_powers_match_the_simulators_under_a_lease(forward: float, turn: float) -> None:
    assert mixed(forward, turn) == user_power(forward, turn)


def test_forward_and_turn_of_powers_give_these_powers_again() -> None:
    for powers in ((0.5, 0.4), (-1.0, 1.0), (1.0, 1.0), (0.0, -0.7)):
        assert mixed(*unmixed(*powers)) == pytest.approx(powers)
    assert unmixed(-0.2, 0.2) == (0.0, 0.2)


def test_no_user_wants_nothing() -> None:
    assert wanted(None, 0.5) == (0.0, 0.0)


@pytest.mark.parametrize(
    ("word", "wish"),
    [("forward", (0.5, 0.0)), ("back", (-0.5, 0.0)), ("left", (0.0, 0.5)), ("right", (0.0, -0.5)), ("stop", (0.0, 0.0)),
     ("kitchen", (0.0, 0.0))],
)  # fmt: skip
def test_word_alone_drives(word: str, wish: tuple[float, float]) -> None:
    assert wanted(UserInput(word=word), 0.5) == wish


def test_word_counts_only_while_the_stick_is_centred() -> None:
    assert wanted(UserInput(forward=-0.2, word="forward"), 0.5) == (-0.2, 0.0)


def test_goal_changes_once_and_again_after_it_was_withdrawn() -> None:
    goals, here, there = Goals(), Goal(x=1.0, y=1.0), Goal(x=2.0, y=1.0)
    said = [None, here, here, there, None, there]
    users = [UserInput(goal=goal) for goal in said]
    assert [goals.changed(user) for user in users] == [None, here, None, there, None, there]
    assert goals.changed(None) is None


def test_robot_declares_goals() -> None:
    assert takes_goals(robot("rear-wheel"), Options()).user_input == ("goal",)
