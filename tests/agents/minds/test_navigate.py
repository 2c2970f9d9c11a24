"""A chair reaches places of the ward around all that is in its way, and touches nothing."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import pytest

from intellwheels_agents.minds.navigate import Mind, equip
from intellwheels_agents.options import OptionError, Options
from intellwheels_maps import floor, robot
from intellwheels_schemas.messages import Position
from tests.agents.arena import Arena
from tests.agents.kinematics import context
from tests.agents.navigate_trials import Timed, trial
from tests.agents.navigation.rooms import room


def near(arena: Arena, name: str, x: float, y: float, within: float = 0.3) -> bool:
    return math.dist(arena.paths[name][-1][:2], (x, y)) <= within


@pytest.mark.parametrize("scene", [3, pytest.param(5, marks=pytest.mark.soak)])
def test_chair_reaches_a_place_of_the_ward(scene: int) -> None:
    (row,) = trial(scene, 1, 120.0, {})
    assert row.reached
    assert row.contacts == 0


def test_chairs_meet_and_reach_their_places() -> None:
    arena = Arena("ward")
    arena.join("chair1", "navigate", "rear-wheel", "corridor-west", {"points": "12 0", "truth": "true"})
    arena.join(
        "chair2",
        "navigate",
        "front-wheel",
        None,
        {"points": "2 0", "truth": "true"},
        Position(x=10.0, y=0.0, heading=math.pi),
    )
    arena.run(60.0, until=lambda now: near(now, "chair1", 12.0, 0.0) and near(now, "chair2", 2.0, 0.0))
    assert near(arena, "chair1", 12.0, 0.0)
    assert near(arena, "chair2", 2.0, 0.0)
    assert arena.contacts() == []


@pytest.mark.parametrize("lidar", ["true", "false"])
def test_chair_finds_its_pose_by_its_sensors(lidar: str) -> None:
    arena = Arena("ward")
    options = {"to": "room1-door", "lidar": lidar, "WheelRatio": "1.01", "MotorNoise": "0.015"}
    arena.join("chair", "navigate", "rear-wheel", "room2-b", options)
    arena.run(90.0, until=lambda now: near(now, "chair", 4.4, 2.6))
    assert near(arena, "chair", 4.4, 2.6)
    assert arena.contacts() == []


def test_chair_asks_a_door_to_open_and_passes() -> None:
    arena = Arena("door")
    arena.join("door", "door", "door", "hinge", {"swing": "left"})
    arena.join("chair", "navigate", "rear-wheel", "start", {"to": "goal", "truth": "true"})
    goal = next(place for place in arena.setup.floor.grid.position if place.name == "goal")  # type: ignore[union-attr]
    arena.run(90.0, until=lambda now: near(now, "chair", goal.x, goal.y))
    assert near(arena, "chair", goal.x, goal.y)
    assert arena.contacts() == []
    assert "open" in {text for _, text in arena.said["chair"]}


def test_chair_plans_around_what_is_not_on_the_map() -> None:
    # Two gaps lead to the goal, and a crate that no map shows stands in the near one.
    arena = Arena(room((3.9, 0.0, 4.1, 1.0), (3.9, 2.4, 4.1, 5.4), size=7.0))
    arena.join("crate", "table", "crate", None, {}, Position(x=4.0, y=1.7, heading=1.57))
    start = Position(x=1.5, y=2.0, heading=0.0)
    player = arena.join("chair", "navigate", "mid-wheel", None, {"points": "5.5 2", "truth": "true"}, start)
    timed = player.mind = Timed(player.mind)
    modes = set()
    while arena.state.tick < 1200 and not near(arena, "chair", 5.5, 2.0):
        arena.step()
        modes.add(timed.mode)
    assert near(arena, "chair", 5.5, 2.0)
    assert max(y for _, y, _ in arena.paths["chair"]) > 5.5
    # It does not stand to plan the way round.
    assert "planning" not in modes
    assert arena.contacts() == []


def test_run_repeats() -> None:
    paths = []
    for _ in range(2):
        arena = Arena("ward")
        arena.join("chair", "navigate", "mid-wheel", "day2", {"to": "room1-door"})
        arena.run(2.0)
        paths.append(arena.paths["chair"])
    assert paths[0] == paths[1]


def test_map_can_be_a_file(tmp_path: Path) -> None:
    import intellwheels_maps

    file = Path(intellwheels_maps.__file__).parent / "floors" / "room.xml"
    body = equip(robot("mid-wheel"), Options())
    mind = Mind(context(body, Position(x=2.0, y=2.0, heading=0.0), points="3 2", map=str(file)))
    assert mind is not None
    assert floor(file).name == "room"


def test_robot_gets_what_the_options_ask_for() -> None:
    body = equip(robot("mid-wheel"), Options({"truth": "true"}))
    assert [lidar.id for lidar in body.lidar] == ["scan-front", "scan-back"]
    assert body.truth
    assert body.user_input == ("goal",)
    own = equip(robot("mid-wheel"), Options({"lidar": "false"}))
    assert own.lidar == ()
    assert own.truth == ()


def test_robot_without_a_pose_is_refused() -> None:
    with pytest.raises(OptionError, match="option truth: expected true for a robot without encoders and odometry"):
        Mind(context(robot("crate"), points="3 2"))
    with pytest.raises(OptionError, match="option truth: expected false for a robot without a truth sensor"):
        Mind(context(robot("mid-wheel"), points="3 2", truth="true"))


def test_missing_numpy_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [name for name in sys.modules if name.startswith("intellwheels_agents.navigation")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "numpy", None)
    with pytest.raises(OptionError, match="mind navigate: expected the extra navigate"):
        Mind(context(robot("mid-wheel"), points="3 2"))


@pytest.mark.soak
@pytest.mark.parametrize("chairs", [1, 5])
def test_most_chairs_of_the_ward_arrive(chairs: int) -> None:
    rows = [row for scene in range(1, 6) for row in trial(scene, chairs, 180.0, {})]
    assert sum(row.reached for row in rows) >= 0.9 * len(rows)
    assert sum(row.contacts for row in rows) == 0
