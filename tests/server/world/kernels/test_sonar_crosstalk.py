"""What sonars hear of the pings of others: by timing and geometry, never at one point."""

from __future__ import annotations

import math
from typing import Any

import pytest
from msgspec import structs

from intellwheels_maps import robot
from intellwheels_schemas.messages import Part, Position, Robot, Wall
from intellwheels_server.world import State
from tests.server.world.sonars import heard, many, readings, solid, sonar, told
from tests.server.worlds import box_wall, cart, run, world


def _facing(crosstalk: float, walls: list[Wall] | None = None, period: float = 0.05, **fields: Any) -> State:
    """Return two carts whose sonars are 3 m apart and face each other."""
    # The last echo is back after 29 ms, or later by the delay.
    timing: dict[str, Any] = {"every": math.ceil(0.05 / period), "latency": math.ceil(0.029 / period)}
    robots = {
        "a": cart(proximity=(sonar(x=0.5, crosstalk=crosstalk, **timing),)),
        "b": cart(4.0, heading=math.pi, proximity=(sonar(x=0.5, **{**timing, **fields}),)),
    }
    return world(robots, walls or [], period=period)


def test_ping_of_a_sonar_that_looks_back_counts_as_half_the_way() -> None:
    assert heard(_facing(0.0)) == told(3.0)
    assert heard(_facing(1.0)) == told(1.5)
    assert heard(_facing(1.0), "b") == told(3.0)
    assert heard(_facing(1.0, direction_deg=90.0)) == told(3.0)


def test_ping_is_not_heard_through_a_wall_nor_half_a_tenth_of_a_second_later() -> None:
    assert heard(_facing(1.0, [box_wall(2.2, -1.0, 2.4, 1.0)])) == told(1.7)
    # In the first tick group 1 is silent, and in the second the sound of the other has gone 17 m.
    state = _facing(1.0, every=2, group=1)
    assert heard(state) == told(3.0)
    state, _ = run(state, 1)
    assert heard(state) == told(1.5)


@pytest.mark.parametrize(("delay", "distance"), [(0.002, 1.846), (0.004, 2.192), (0.01, 3.0)])
def test_ping_that_is_made_later_seems_farther(delay: float, distance: float) -> None:
    """1.5 m and half of the way of sound in the delay, 173 m/s; beyond 3 m is the echo of the other cart."""
    assert heard(_facing(1.0, period=0.06, ping_delay=delay)) == told(distance)


def test_ping_of_another_tick_is_heard_if_it_arrives_in_time() -> None:
    # Ticks of 5 ms: the other pings a tick before, or after; 0.865 m less or more.
    for group, distance in ((0, 1.5), (1, 2.365), (2, 3.0), (9, 0.635)):
        state, _ = run(_facing(1.0, period=0.005, every=10, group=group), 10)
        assert heard(state, latency=6) == told(distance)


def test_delays_that_alternate_make_crosstalk_jump_and_leave_echoes_as_they_are() -> None:
    crossed, quiet = (_facing(share, period=0.06, second_ping_delay=0.004) for share in (1.0, 0.0))
    for k in range(6):
        crossed, _ = run(crossed, 1)
        quiet, _ = run(quiet, 1)
        assert readings(crossed) == [told(1.5 + (k % 2) * 0.692)]
        assert readings(quiet) == [told(3.0)]


def test_share_of_pings_that_is_taken_for_an_echo() -> None:
    robots = {
        "a": cart(proximity=many(40, x=0.5, crosstalk=0.3)),
        "b": cart(4.0, heading=math.pi, proximity=(sonar(x=0.5),)),
    }
    state, taken = world(robots), 0
    for _ in range(10):
        state, _ = run(state, 1)
        taken += sum(value == told(1.5) for value in readings(state))
    assert taken == pytest.approx(120, abs=37)  # four standard deviations


def test_pings_of_two_others_are_drawn_each_by_itself() -> None:
    """The first that is taken counts: 1 - 0.7 * 0.7 of the pings."""
    robots = {"a": cart(proximity=many(64, x=0.5, crosstalk=0.3))}
    robots.update({
        name: cart(4.0, y, heading=math.pi, proximity=(sonar(x=0.5),)) for name, y in (("b", 0.5), ("c", -0.5))
    })  # fmt: skip
    state, taken = world(robots), 0
    for _ in range(10):
        state, _ = run(state, 1)
        taken += sum(value != "none" and float(value) < 2.0 for value in readings(state))
    assert taken == pytest.approx(0.51 * 640, abs=51)  # four standard deviations


@pytest.mark.parametrize(("device", "cone", "disturbs"), [("srf235", 15.0, False), ("srf08", 55.0, True)])
def test_ping_of_another_frequency_is_not_heard(device: str, cone: float, *, disturbs: bool) -> None:
    fields: dict[str, Any] = {"min_range": 0.1, "max_range": 1.2, "every": 2, "x": 0.5}
    robots = {
        "a": cart(proximity=(sonar(device="srf08", **{**fields, "cone_deg": 55.0}, crosstalk=1.0),)),
        "b": cart(2.1, heading=math.pi, proximity=(sonar(device=device, **{**fields, "cone_deg": cone}),)),
    }
    assert heard(world(robots)) == told(0.55 if disturbs else 1.1)


def test_ping_is_heard_by_way_of_a_wall() -> None:
    """Two sonars side by side look at a wall at 45 degrees: the way is that from the image, 2 sqrt(2) long."""
    wall = box_wall(2.0, -9.0, 3.0, 9.0)
    robots = {
        "a": cart(proximity=(sonar(x=1.0, y=-1.0, direction_deg=45.0, cone_deg=40.0, crosstalk=1.0),)),
        "b": cart(-3.0, proximity=(sonar(x=4.0, y=1.0, direction_deg=-45.0, cone_deg=40.0),)),
    }
    state = world(robots, [wall])
    assert heard(state) == told(math.sqrt(2.0))
    assert heard(state, "b") == "none"
    post = solid((1.5, -0.6), (1.6, -0.6), (1.6, -0.3), (1.5, -0.3))
    assert heard(world(robots, [wall, post])) != told(math.sqrt(2.0))


def test_ping_is_heard_from_beyond_the_range_of_the_listener() -> None:
    """It hears over 1.2 m, and the other is 4 m away, but had pinged 5 ms, 1.73 m, before: (4 - 1.73) / 2 = 1.135 m."""
    timing: dict[str, Any] = {"every": 10, "latency": 6}
    robots = {
        "a": cart(proximity=(sonar(x=0.5, max_range=1.2, crosstalk=1.0, **timing),)),
        "b": cart(5.0, heading=math.pi, proximity=(sonar(x=0.5, **timing, group=9),)),
    }
    state, _ = run(world(robots, period=0.005), 10)
    assert heard(state, latency=6) == told(1.135)
    # What stands between them is beyond the range too, and hides it.
    state, _ = run(world(robots, [box_wall(3.0, -1.0, 3.2, 1.0)], period=0.005), 10)
    assert heard(state, latency=6) == "none"


def test_ping_comes_by_a_wall_beyond_the_range_of_the_listener() -> None:
    """Side by side, 2 m apart, 3 m before a wall: a way of 2 sqrt(10) m, less 3.46 m as it is 10 ms earlier."""
    timing: dict[str, Any] = {"every": 10, "latency": 6, "cone_deg": 60.0}
    robots = {
        "a": cart(proximity=(sonar(y=0.3, max_range=1.5, crosstalk=1.0, **timing),)),
        "b": cart(0.0, 2.6, proximity=(sonar(y=-0.3, **timing, group=8),)),
    }
    state, _ = run(world(robots, [box_wall(3.0, -9.0, 4.0, 9.0)], period=0.005), 10)
    assert heard(state, latency=6) == told(0.5 * (2.0 * math.sqrt(10.0) - 3.46))


def test_sonar_does_not_listen_before_its_shortest_distance() -> None:
    assert heard(_facing(1.0, period=0.06)) == told(1.5)
    robots = {
        "a": cart(proximity=(sonar(x=0.5, crosstalk=1.0, min_range=1.6),)),
        "b": cart(4.0, heading=math.pi, proximity=(sonar(x=0.5),)),
    }
    assert heard(world(robots)) == told(3.0)


def test_each_ping_of_another_is_drawn_by_itself() -> None:
    """Two pings arrive while the sonar listens: 0.3 of the first count, and 0.3 of the rest of the second."""
    part = Part(x=0.0, y=0.0, length=0.5, width=0.5, bottom=0.6, top=1.0)
    other = sonar(x=0.5, every=10, latency=10)
    robots = {
        "a": cart(proximity=many(64, x=0.5, max_range=12.0, latency=15, crosstalk=0.3, every=20)),
        # It does not hear the body below which the other is.
        "b": Robot(part=(part,), position=Position(x=4.0, y=0.0, heading=math.pi), proximity=(other,)),
    }
    state, found = world(robots, period=0.005), []
    for _ in range(10):
        state, _ = run(state, 20)
        found += readings(state)
    near, far = (sum(one == told(way) for one in found) for way in (1.5, 1.5 + 8.65))
    # Four standard deviations of 640 draws.
    assert (near, far) == (pytest.approx(0.3 * 640, abs=47), pytest.approx(0.21 * 640, abs=42))


def test_sonars_at_one_point_do_not_disturb_each_other() -> None:
    turns = range(0, 360, 20)
    for delay in (0.0, 0.01):
        fan = tuple(
            sonar(f"s{k}", direction_deg=float(turn), crosstalk=1.0, ping_delay=delay * (k % 2))
            for k, turn in enumerate(turns)
        )
        state, _ = run(world({"a": cart(proximity=fan)}, period=0.06), 1)
        assert readings(state) == ["none"] * len(fan)


@pytest.mark.parametrize("cone", [20.0, 55.0, 72.0])
def test_corridor_chair_alone_in_an_empty_world_hears_nothing(cone: float) -> None:
    chair = robot("corridor-chair")
    sonars = tuple(
        structs.replace(one, model="sonar", crosstalk=1.0, latency=1, cone_deg=cone) for one in chair.proximity
    )
    chair = structs.replace(chair, proximity=sonars, position=Position(x=0.0, y=0.0, heading=0.3))
    state, _ = run(world({"a": chair}), 1)
    assert readings(state) == ["none"] * len(sonars)
