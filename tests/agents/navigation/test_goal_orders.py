"""Goals by message."""

from __future__ import annotations

import dataclasses

import msgspec
import pytest

from intellwheels_agents.navigation.goal_orders import GoalOrders
from intellwheels_maps import robot
from intellwheels_schemas.messages import Heard, SiteOffset
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


def test_coordinates_are_those_of_the_site() -> None:
    there = context(robot("mid-wheel"))
    moved = msgspec.structs.replace(there.map, offset=SiteOffset(x=489000.0, y=4412000.0, epsg="EPSG:32629"))
    orders = GoalOrders(dataclasses.replace(there, fetch_map=lambda: moved))
    text = "go 489001.5 4412002"
    assert orders.goal(Heard(sender="operator", tick=1, distance=0.0, text=text)) == (1.5, 2.0)
    assert orders.goal(Heard(sender="operator", tick=1, distance=0.0, text="go 1.5 2")) is None
