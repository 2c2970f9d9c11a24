"""Goals by message."""

from __future__ import annotations

import pytest

from intellwheels_agents.navigation.goal_orders import GoalOrders
from intellwheels_maps import robot
from intellwheels_schemas.messages import Heard
from tests.agents.kinematics import context


@pytest.mark.parametrize(
    ("text", "goal"),
    [
        ("go goal1", (5.0, 1.0)),
        ("go 1.5 -2", (1.5, -2.0)),
        ("tested: go goal2", (2.0, 0.0)),
        ("other: go goal2", None),
        ("go nowhere", None),
        ("open", None),
    ],
)
def test_message_gives_a_goal(text: str, goal: tuple[float, float] | None) -> None:
    orders = GoalOrders(context(robot("mid-wheel")))
    assert orders.goal(Heard(sender="operator", tick=1, distance=0.0, text=text)) == goal
