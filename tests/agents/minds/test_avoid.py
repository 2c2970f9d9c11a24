"""A wandering chair touches nothing and does not freeze. `tests.agents.avoid_trials` has the full size."""

from __future__ import annotations

import math

import msgspec
import pytest

from intellwheels_agents.minds.avoid import RAYS, Mind, equip
from intellwheels_agents.options import OptionError, Options
from intellwheels_maps import robot
from intellwheels_schemas.messages import Position
from tests.agents.arena import Arena
from tests.agents.avoid_trials import HEIGHT, at_sensor_height, longest_frozen, scenes, starts, trial
from tests.agents.kinematics import Body, box, context


def test_lidar_is_as_high_as_far_and_as_late_as_the_robots_own_sensors() -> None:
    chair = robot("rear-wheel")
    own = tuple(msgspec.structs.replace(one, z=0.3, max_range=2.5, latency=2, every=3) for one in chair.proximity)
    [lidar] = equip(msgspec.structs.replace(chair, proximity=own), Options({})).lidar
    assert (lidar.z, lidar.max_range, lidar.latency, lidar.every, lidar.fov_deg) == (0.3, 2.5, 2, 3, 360.0)
    [plain] = equip(msgspec.structs.replace(chair, proximity=()), Options({})).lidar
    assert (plain.z, plain.max_range, plain.rays) == (HEIGHT, 4.0, RAYS)
    equipped = equip(chair, Options({}))
    assert equip(equipped, Options({})) == equipped


@pytest.mark.parametrize(
    ("ground", "chairs", "seconds"),
    [
        ("room", 6, 24.0),
        ("ward", 15, 8.0),
        ("lounge", 1, 40.0),
        pytest.param("room", 6, 40.0, marks=pytest.mark.soak),
        pytest.param("ward", 15, 12.0, marks=pytest.mark.soak),
    ],
)
def test_chairs_wander_and_touch_nothing(ground: str, chairs: int, seconds: float) -> None:
    for row in trial(ground, chairs, 1, seconds):
        assert row.contacts == 0, row
        assert row.frozen < 10.0, row
        assert row.travelled > 0.5, row


def test_a_pole_between_the_cones_of_the_robot_itself_is_seen() -> None:
    # 22 degrees off the nose, where the included chairs have no cone of their own.
    arena = Arena("square")
    arena.join("pole", "drive", "person", None, position=Position(x=2.6, y=0.3, heading=0.0))
    arena.join("chair", "avoid", "mid-wheel", None, position=Position(x=0.0, y=0.0, heading=0.0))
    arena.run(20.0)
    assert arena.contacts() == []
    assert longest_frozen(arena.paths["chair"]) * arena.setup.period < 5.0


def test_a_chair_pressed_by_what_it_cannot_see_backs_out() -> None:
    # A table top at 0.7 m: the cones at 0.4 m see only the legs.
    arena = Arena("square")
    arena.join("table", "table", "table", None, position=Position(x=2.4, y=0.0, heading=math.pi / 2.0))
    arena.join("chair", "avoid", "rear-wheel", None, position=Position(x=0.0, y=0.0, heading=0.0))
    arena.run(25.0)
    assert longest_frozen(arena.paths["chair"]) * arena.setup.period < 8.0
    touched = [event for event in arena.contacts() if event.agent == "chair"]
    assert not [event for event in touched if at_sensor_height(event, arena.setup.floor, {"chair": "rear-wheel"})]


def test_a_chair_in_a_niche_finds_its_way_out() -> None:
    # It can turn neither way, with a wall 0.06 m beside it and 0.2 m of room along it.
    arena = Arena("corner")
    niche = Position(x=12.01, y=-0.25, heading=math.pi / 2.0)
    arena.join("chair", "avoid", "front-wheel", None, position=niche)
    arena.run(60.0, until=lambda now: math.dist(now.paths["chair"][-1][:2], (niche.x, niche.y)) > 1.0)
    assert math.dist(arena.paths["chair"][-1][:2], (niche.x, niche.y)) > 1.0
    assert arena.contacts() == []


def test_late_readings_are_put_where_the_chair_was() -> None:
    arena = Arena("room")
    arena.join("chair", "avoid", "front-wheel", "start1", {"Proximity.Latency": "4"})
    arena.run(40.0)
    assert arena.contacts() == []
    assert longest_frozen(arena.paths["chair"]) * arena.setup.period < 5.0


def test_stop_distance_must_be_below_clear() -> None:
    with pytest.raises(OptionError, match=r"option stop: expected less than clear \(1.5\), got 2"):
        Mind(context(robot("rear-wheel"), stop="2"))


def test_it_drives_no_faster_than_its_sensors_let_it_stop() -> None:
    arena = Arena("square")
    slow = {"speed": "5", "clear": "5", "TopSpeed": "5", "AccelerationCurve": "0.95", "AccelerationLimit": "0.5"}
    arena.join("chair", "avoid", "mid-wheel", None, slow, Position(x=0.0, y=0.0, heading=0.0))
    fastest = 0.0
    for _ in range(600):
        arena.step()
        fastest = max(fastest, arena.speed("chair"))
    assert arena.contacts() == []
    assert 0.3 < fastest < 1.5


def test_without_a_lidar_it_uses_the_cones_that_the_robot_has() -> None:
    body = Body(robot("mid-wheel"), x=-2.0)
    mind, walls = Mind(context(body.robot, body.position)), box(-4.0, -3.0, 4.0, 3.0)
    assert not body.robot.lidar
    for _ in range(600):
        body.step(mind.decide(body.measures(walls)))
        assert not body.touches(walls)
    assert min(body.travels) > 1.0


def test_every_map_is_tried_alone_and_the_ward_with_fifteen() -> None:
    found = list(scenes(["corridor15m", "room", "ward"]))
    assert found == [("corridor15m", 1), ("room", 1), ("room", len(starts("room"))), ("ward", 1), ("ward", 15)]
