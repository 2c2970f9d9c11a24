"""A wandering chair touches nothing."""

from __future__ import annotations

import pytest

from intellwheels_agents.minds.avoid import Mind
from intellwheels_agents.options import OptionError
from intellwheels_maps import robot
from tests.agents.kinematics import PERIOD, Body, box, context


@pytest.mark.parametrize("name", ["rear-wheel", "mid-wheel", "front-wheel", "intellwheels"])
def test_chair_wanders_for_a_minute_without_contact(name: str) -> None:
    walls = box(-4.0, -3.0, 4.0, 3.0) + box(1.8, 0.6, 2.6, 1.6)
    body = Body(robot(name), heading=0.3)
    mind = Mind(context(body.robot, body.position))
    travelled = 0.0
    for _ in range(round(60.0 / PERIOD)):
        body.step(mind.decide(body.measures(walls)))
        travelled += sum(body.speeds) / 2.0 * PERIOD
        assert not body.touches(walls), (body.x, body.y, body.heading)
    # The front-wheel chair's long back lets it turn but slowly.
    assert travelled > 4.0


def test_stop_distance_must_be_below_clear() -> None:
    with pytest.raises(OptionError, match=r"option stop: expected less than clear \(1.5\), got 2"):
        Mind(context(robot("rear-wheel"), stop="2"))
