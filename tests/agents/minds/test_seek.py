"""A chair reaches its place around the obstacles that its sensors see, and reports its goal."""

from __future__ import annotations

import math

import pytest

from intellwheels_agents.minds.seek import BACKING_TIME, STUCK_TIME, Mind, equip
from intellwheels_agents.options import OptionError, Options
from intellwheels_maps import robot
from intellwheels_schemas.messages import Goal, UserInput
from tests.agents.arena import Arena
from tests.agents.kinematics import Body, box, context, run

NOISY = {"to": "goal", "MotorNoise": "0.015"}


def test_chair_passes_both_blocks_of_the_corridor_without_touching() -> None:
    arena = Arena("corridor15m")
    arena.join("chair", "seek", "corridor-chair", "start", NOISY)
    arena.run(60.0, until=lambda now: math.dist(now.paths["chair"][-1][:2], (15.0, 0.0)) < 0.3)
    assert math.dist(arena.paths["chair"][-1][:2], (15.0, 0.0)) < 0.3
    assert arena.contacts() == []


def test_chair_drives_around_a_table_in_its_way() -> None:
    arena = Arena("lounge")
    arena.join("table", "table", "table", "table")
    arena.join("chair", "seek", "corridor-chair", "start", {**NOISY, "Proximity.Z": "0.7"})
    arena.run(60.0, until=lambda now: math.dist(now.paths["chair"][-1][:2], (7.6, 2.5)) < 0.4)
    assert math.dist(arena.paths["chair"][-1][:2], (7.6, 2.5)) < 0.4
    assert arena.contacts() == []


def test_chair_at_its_goal_stops_and_reports_it() -> None:
    body = Body(robot("corridor-chair"))
    done = run(body, Mind(context(body.robot, to="goal1")), [], 25.0)
    assert done[-1].mode == "arrived"
    assert (done[-1].left_motor, done[-1].right_motor) == (0.0, 0.0)
    assert done[0].goal is not None


def test_chair_without_a_way_backs_up_after_a_while() -> None:
    body = Body(robot("corridor-chair"))
    # A pen: walls all round, nearer than the chair is long, but with room behind.
    pen = [*box(0.9, -0.6, 1.0, 0.6), *box(-2.5, 0.5, 1.0, 0.6), *box(-2.5, -0.6, 1.0, -0.5)]
    done = run(body, Mind(context(body.robot, to="goal1")), pen, STUCK_TIME + 10.0)
    first = next(k for k, one in enumerate(done) if one.mode == "backing")
    assert first * 0.05 >= STUCK_TIME
    assert done[first + round(BACKING_TIME / 0.05) + 1].mode == "autonomous"


def test_place_is_required() -> None:
    with pytest.raises(OptionError, match="option to: expected a place of the map, got none"):
        Mind(context(robot("corridor-chair")))


def test_goal_of_the_user_replaces_the_place() -> None:
    arena = Arena("room")
    arena.join("chair", "seek", "corridor-chair", "start1", {"to": "start1"})
    arena.run(1.0)
    x, y, _ = arena.paths["chair"][-1]
    arena.users["chair"] = UserInput(goal=Goal(x=x + 2.0, y=y))
    arena.step()
    del arena.users["chair"]  # it outlives the user's silence
    arena.run(20.0, until=lambda now: math.dist(now.paths["chair"][-1][:2], (x + 2.0, y)) < 0.25)
    assert math.dist(arena.paths["chair"][-1][:2], (x + 2.0, y)) < 0.25
    assert arena.contacts() == []


def test_robot_declares_goals() -> None:
    assert equip(robot("corridor-chair"), Options()).user_input == ("goal",)
