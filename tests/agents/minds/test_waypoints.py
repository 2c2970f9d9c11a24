"""A chair follows its path to the end, with its own noisy odometry."""

from __future__ import annotations

import math
from itertools import pairwise

import msgspec
import pytest

from intellwheels_agents.minds.waypoints import Mind, equip
from intellwheels_agents.options import OptionError, Options
from intellwheels_maps import robot
from intellwheels_schemas.messages import Goal, Robot, UserInput
from tests.agents.kinematics import Body, Segment, box, context, run

CHAIRS = ["rear-wheel", "mid-wheel", "front-wheel", "intellwheels"]


@pytest.mark.parametrize("name", CHAIRS)
def test_every_chair_gets_round_corners_to_the_end_with_noise(name: str) -> None:
    body = Body(robot(name), motor_noise=0.015, compass_noise=math.radians(0.5))
    mind = Mind(context(body.robot, points="4 0 4 3 0 3"))
    done = run(body, mind, [], 45.0)
    # 0.1 m is the mind's own tolerance, the rest is its drift over 11 m.
    assert math.dist((body.x, body.y), (0.0, 3.0)) < 0.2
    assert done[-1].mode == "arrived"
    assert (done[-1].left_motor, done[-1].right_motor) == (0.0, 0.0)


def test_places_come_from_the_map_and_the_last_is_the_goal() -> None:
    body = Body(robot("intellwheels"))
    done = run(body, Mind(context(body.robot, via="goal2", to="goal1")), [], 20.0)
    assert math.dist((body.x, body.y), (5.0, 1.0)) < 0.15
    assert done[0].goal is not None
    assert (done[0].goal.x, done[0].goal.y) == (5.0, 1.0)


def test_unknown_place_is_refused_with_the_known_ones() -> None:
    with pytest.raises(OptionError, match=r"option to: expected a place of the map \(goal1, goal2\), got 'goal3'"):
        Mind(context(robot("intellwheels"), to="goal3"))


def test_missing_path_is_refused() -> None:
    with pytest.raises(OptionError, match="options: expected at least one of points, via and to, got none"):
        Mind(context(robot("intellwheels")))


def test_path_that_starts_behind_turns_the_chair_first() -> None:
    body = Body(robot("rear-wheel"))
    run(body, Mind(context(body.robot, points="-3 0")), [], 20.0)
    assert math.dist((body.x, body.y), (-3.0, 0.0)) < 0.15


def test_truth_sensor_overrides_the_encoders() -> None:
    document = equip(robot("intellwheels"), Options({"truth": "true"}))
    wrong = msgspec.structs.replace(document, wheel_diameter=0.3)
    body = Body(document)
    mind = Mind(context(wrong, points="6 0", truth="true"))
    run(body, mind, [], 20.0)
    assert math.dist((body.x, body.y), (6.0, 0.0)) < 0.15


def test_robot_without_encoders_needs_the_truth_sensor() -> None:
    with pytest.raises(OptionError, match="option truth: expected true for a robot without encoders"):
        Mind(context(Robot(top_speed=1.0, length=1.0, width=0.6), points="1 1"))


@pytest.mark.parametrize("name", CHAIRS)
def test_chair_waits_at_a_closed_door_and_goes_on_when_it_opens(name: str) -> None:
    jambs = box(5.0, -2.0, 5.1, -0.55) + box(5.0, 0.55, 5.1, 2.0)
    leaf: list[Segment] = [(5.0, -0.5, 5.0, 0.5)]
    body = Body(robot(name))
    mind = Mind(context(body.robot, points="8 0"))
    done = run(body, mind, jambs + leaf, 20.0)
    assert done[-1].mode == "waiting"
    front = max(x for x, _ in body.corners())
    assert 4.3 < front < 4.55
    for _ in range(600):
        body.step(mind.decide(body.measures(jambs)))
        assert not body.touches(jambs)
    assert math.dist((body.x, body.y), (8.0, 0.0)) < 0.15


def test_wall_beyond_the_end_does_not_stop_the_chair_early() -> None:
    body = Body(robot("intellwheels"))
    run(body, Mind(context(body.robot, points="3 0")), box(-5.0, -3.0, 4.0, 3.0), 15.0)
    assert math.dist((body.x, body.y), (3.0, 0.0)) < 0.15


def test_chair_speeds_up_and_slows_down_gently() -> None:
    body = Body(robot("intellwheels"))
    done = run(body, Mind(context(body.robot, points="5 0")), [], 15.0)
    powers = [actions.left_motor or 0.0 for actions in done]
    # 0.35 m/s2 are 0.0175 a tick at a top speed of 1 m/s; it stops from a creep of 0.05 m/s.
    assert max(a - b for a, b in pairwise(powers)) < 0.0501


def test_goal_of_the_user_replaces_the_path_on_the_way_and_at_its_end() -> None:
    body = Body(robot("intellwheels"))
    mind = Mind(context(body.robot, points="6 0"))
    run(body, mind, [], 3.0)
    assert 0.5 < body.x < 3.0
    for x, y in ((3.0, 3.0), (1.0, 1.0), (1.0, 1.02)):
        told = UserInput(goal=Goal(x=x, y=y))
        for _ in range(500):
            actions = mind.decide(msgspec.structs.replace(body.measures([]), user_input=told))
            body.step(actions)
        assert math.dist((body.x, body.y), (x, y)) < 0.2
        assert actions.mode == "arrived"
        assert actions.goal == told.goal


def test_robot_declares_goals() -> None:
    assert equip(robot("rear-wheel"), Options()).user_input == ("goal",)
    assert equip(robot("rear-wheel"), Options({"truth": "true"})).user_input == ("goal",)
