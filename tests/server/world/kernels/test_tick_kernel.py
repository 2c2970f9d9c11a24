import random

import pytest

from intellwheels_schemas.file_records import Join
from intellwheels_schemas.messages import Encoders
from intellwheels_server.world import measures
from intellwheels_server.world.kernels import rows
from tests.server.worlds import box_wall, cart, do, run, world


def test_speed_and_turn_rate_are_what_came_about_not_what_was_wanted() -> None:
    state, _ = run(world({"a": cart()}, [box_wall(0.5, -1.0, 1.0, 1.0)]), 3, {"a": (1.0, 1.0)})
    assert state.numbers[rows.SPEED, 0] == pytest.approx(0.0, abs=1e-9)
    state, _ = run(world({"a": cart()}), 3, {"a": (0.2, 0.6)})
    assert state.numbers[rows.SPEED, 0] == pytest.approx(0.4)
    assert state.numbers[rows.TURN_RATE, 0] == pytest.approx(0.8)


def test_blocked_wheels_stall_and_the_encoders_stand() -> None:
    state = world({"a": cart(acceleration_curve=0.5, encoders=(Encoders(id="w"),))}, [box_wall(0.5, -1.0, 1.0, 1.0)])
    state, _ = run(state, 10, {"a": (1.0, 1.0)})
    assert state.numbers[rows.LEFT_SPEED, 0] == 0.0
    sensors = measures(state, "a").sensors
    assert sensors is not None
    assert (sensors.encoders[0].left, sensors.encoders[0].right) == (0, 0)


def test_slipping_wheels_turn_on_by_their_share() -> None:
    state = world({"a": cart(slip=0.25)}, [box_wall(0.5, -1.0, 1.0, 1.0)])
    state, _ = run(state, 20, {"a": (1.0, 1.0)})
    # A metre wanted, nothing achieved.
    assert state.numbers[rows.LEFT_TRAVEL, 0] == pytest.approx(0.25, abs=1e-6)
    assert state.numbers[rows.RIGHT_TRAVEL, 0] == pytest.approx(0.25, abs=1e-6)
    assert state.numbers[rows.X, 0] == pytest.approx(0.0, abs=1e-9)


def test_more_pairs_than_there_was_room_for_are_all_found() -> None:
    robots = {f"a{k:02d}": cart(0.0, 0.6 * k, top_speed=1.0) for k in range(40)}
    state = world(robots, [box_wall(0.5, -1.0, 1.0, 40.0)])
    state, events = run(state, 1, dict.fromkeys(robots, (1.0, 1.0)))
    assert sorted(event.agent or "" for event in events if event.other == "wall") == sorted(robots)


def test_nobody_drives_beyond_the_edge_of_the_world_and_all_can_come_back() -> None:
    state = world({"a": cart(9_999.9, -9_999.9), "b": cart(0.0, 9_999.9, heading=1.5)})
    state, _ = run(state, 40, {"a": (1.0, 1.0), "b": (1.0, 1.0)})
    assert state.numbers[rows.X].max() <= 10_000.0
    assert abs(state.numbers[rows.Y]).max() <= 10_000.0
    assert state.numbers[rows.LEFT_SPEED, 0] == 0.0
    state, _ = run(state, 40, {"a": (-1.0, -1.0)})
    assert state.numbers[rows.X, 0] < 9_999.0


def test_nobody_is_led_beyond_the_edge_by_what_is_in_the_way() -> None:
    draw = random.Random(1)
    names = [f"b{k}" for k in range(6)]
    for _ in range(12):
        walls = [box_wall(9990.0, 9995.0, 9999.9, 9996.0), box_wall(9998.0, 9980.0, 10_000.0, 9981.0)]
        state = world(walls=walls, period=1.0, command_timeout=100.0)
        for name in names:
            x, y, heading = draw.uniform(9994.0, 10_000.0), draw.uniform(9982.0, 9994.0), draw.uniform(-3.0, 3.0)
            state, _, _ = do(state, Join(agent=name, robot=cart(x, y, heading, top_speed=5.0)))
        for _ in range(20):
            state, _ = run(state, 1, {name: (draw.uniform(-0.3, 1.0), draw.uniform(-0.3, 1.0)) for name in names})
            assert state.numbers[[rows.X, rows.Y]].max() <= 10_000.0
