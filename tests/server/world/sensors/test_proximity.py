"""Proximity sensors in a world: what they see of bodies, from where, and what is refused."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from intellwheels_schemas.errors import RequestRefusedError
from intellwheels_schemas.messages import Part, Position, Proximity, Robot
from intellwheels_server.world import State, measures
from intellwheels_server.world.sensors import check_sensors
from intellwheels_server.world.sensors.proximity import ProximityKind
from tests.every_case import every_case
from tests.server.worlds import ROUNDED, box_wall, cart, floor_of, run, world

# The paper's example: a top from 0.69 to 0.72 m on four legs of 5 cm.
_TABLE = Robot(
    kind="table",
    part=(
        Part(x=0.0, y=0.0, length=1.2, width=0.8, bottom=0.69, top=0.72),
        *(Part(x=x, y=y, length=0.05, width=0.05, bottom=0.0, top=0.69) for x in (-0.55, 0.55) for y in (-0.35, 0.35)),
    ),
    position=Position(x=3.0, y=0.0, heading=0.0),
)


def _eye(sensor_id: str = "eye", **fields: Any) -> Proximity:
    known: dict[str, Any] = {
        "x": 0.5,
        "y": 0.0,
        "z": 0.4,
        "direction_deg": 0.0,
        "cone_deg": 30.0,
        "min_range": 0.02,
        "max_range": 4.0,
    }
    return Proximity(id=sensor_id, **{**known, **fields})


def _seen(state: State, agent: str = "a") -> list[float | str]:
    sensors = measures(state, agent).sensors
    assert sensors is not None
    return [reading.status if reading.value is None else reading.value for reading in sensors.proximity]


def test_sensor_at_0_4_m_sees_only_the_legs_of_a_table_and_one_at_0_7_m_its_top() -> None:
    eyes = tuple(_eye(f"z{z}", z=z) for z in (0.4, 0.69, 0.7, 0.72))
    state = world({"a": cart(proximity=eyes), "table": _TABLE})
    legs, bottom, top, above = _seen(state)
    # The nearest corner of a leg, 0.325 to the side, is inside the cone; the top's edge is straight ahead.
    assert legs == pytest.approx(math.hypot(2.425 - 0.5, 0.325), abs=ROUNDED)
    assert bottom == top == pytest.approx(1.9, abs=1e-12)
    assert above == "none"


def test_narrow_cone_under_the_table_looks_through_between_the_legs() -> None:
    state = world({"a": cart(proximity=(_eye(cone_deg=10.0),)), "table": _TABLE}, [box_wall(4.2, -2.0, 4.4, 2.0)])
    assert _seen(state) == [pytest.approx(3.7, abs=1e-12)]


def test_sensor_does_not_see_its_own_body_wherever_it_is_mounted() -> None:
    own = (_eye("inside", x=0.0), _eye("all-round", x=-1.0, cone_deg=360.0), _eye("frame", x=-1.0, mount="start"))
    state = world({"a": cart(proximity=own)})
    assert _seen(state) == ["none", "none", "none"]


def test_sensor_left_at_the_start_stays_while_its_body_drives_away() -> None:
    eyes = (_eye("body"), _eye("start", mount="start"))
    state = world({"a": cart(heading=math.pi / 2, proximity=eyes)}, [box_wall(-2.0, 3.0, 2.0, 4.0)])
    assert _seen(state) == pytest.approx([2.5, 2.5], abs=1e-12)
    state, _ = run(state, 20, {"a": (1.0, 1.0)})
    assert _seen(state) == pytest.approx([1.5, 2.5], abs=1e-9)


def test_sensor_inside_a_solid_is_too_near_to_tell() -> None:
    state = world({"a": cart(proximity=(_eye(x=2.0, min_range=0.0),))}, [box_wall(1.0, -1.0, 3.0, 1.0)])
    assert _seen(state) == ["near"]


def test_bodies_see_one_another_across_the_same_gap() -> None:
    state = world({"a": cart(proximity=(_eye(),)), "b": cart(3.0, heading=math.pi, proximity=(_eye(),))})
    assert _seen(state, "a") == _seen(state, "b") == [pytest.approx(2.0, abs=1e-12)]


@every_case(
    ("fields", "text"),
    [
        ({"dropout": 0.1}, r"Dropout: expected 0 with the model ideal, got 0.1"),
        ({"model": "infrared", "crosstalk": 0.1}, r"Crosstalk: expected 0 with the model infrared, got 0.1"),
        ({"model": "ideal", "ping_delay": 0.01}, r"PingDelay: expected 0 with the model ideal, got 0.01"),
        ({"model": "ideal", "device": "srf08"}, r"Device: expected none with the model ideal, got 'srf08'"),
        ({"model": "sonar", "group": 2, "every": 2}, r"Group: expected less than Every 2, got 2"),
        ({"model": "sonar", "device": "srf08"}, r"ConeDeg: expected 55 of srf08, got 30"),
        (
            {"model": "sonar", "device": "srf08", "cone_deg": 55.0},
            r"MinRange: expected at least 0.03 of srf08, got 0.02",
        ),
        (
            {"model": "sonar", "device": "srf04", "cone_deg": 55.0, "min_range": 0.03},
            r"MaxRange: expected at most 3 of srf04, got 4",
        ),
    ],
)
def test_error_that_a_model_has_not_is_refused(fields: dict[str, Any], text: str) -> None:
    with pytest.raises(RequestRefusedError, match=rf"Robot.Proximity\[2\].{text}") as refused:
        ProximityKind().check_fields("Robot.Proximity[2]", _eye(**fields))
    assert refused.value.code == "value"
    # The same of a real sensor, though nothing simulates it.
    for source in ("simulated", "real"):
        robot = Robot(type="real", proximity=(_eye("a"), _eye("b"), _eye(source=source, **fields)))
        with pytest.raises(RequestRefusedError, match=rf"Robot.Proximity\[2\].{text}"):
            check_sensors(robot, floor_of(), truth=False, period=0.05)


@every_case(
    ("fields", "period", "text"),
    [
        # Sound goes 8 m to the end of the range and back.
        ({}, 0.05, r"Latency: expected at least 1, as the last echo is back after 0.0231 s, got 0"),
        ({"latency": 2}, 0.01, r"Latency: expected at least 3, as the last echo is back after 0.0231 s, got 2"),
        (
            {"latency": 1, "ping_delay": 0.01, "second_ping_delay": 0.04},
            0.05,
            r"Latency: expected at least 2, as the last echo is back after 0.0631 s, got 1",
        ),
        (
            {"latency": 1, "ping_delay": 0.02},
            0.05,
            r"Every: expected at least 2, as a sonar pings once in 0.07 s, got 1",
        ),
        (
            {"latency": 3, "max_range": 20.0},
            0.05,
            r"Every: expected at least 3, as a sonar pings once in 0.116 s, got 1",
        ),
        ({"latency": 2}, 0.02, r"Every: expected at least 3, as a sonar pings once in 0.05 s, got 1"),
        (
            {"latency": 1, "device": "srf08", "cone_deg": 55.0},
            0.05,
            r"Every: expected at least 2, as srf08 pings once in 0.065 s, got 1",
        ),
        (
            {"latency": 3, "device": "srf08", "cone_deg": 55.0, "every": 6},
            0.01,
            r"Every: expected at least 7, as srf08 pings once in 0.065 s, got 6",
        ),
    ],
)
def test_sonar_that_pings_too_soon_or_answers_at_once_is_refused(
    fields: dict[str, Any], period: float, text: str
) -> None:
    eye = _eye(**{"model": "sonar", "min_range": 0.03, **fields})
    robot = Robot(proximity=(eye,))
    with pytest.raises(RequestRefusedError, match=rf"Robot.Proximity\[0\].{text}") as refused:
        check_sensors(robot, floor_of(), truth=False, period=period)
    assert refused.value.code == "value"


def test_sonar_may_ping_once_in_its_period_and_answer_when_the_last_echo_is_back() -> None:
    eyes = (
        _eye("a", model="sonar", latency=3, every=5),
        _eye("b", model="sonar", latency=3, device="srf08", cone_deg=55.0, min_range=0.03, every=7),
    )
    check_sensors(Robot(proximity=eyes), floor_of(), truth=False, period=0.01)
    check_sensors(Robot(proximity=eyes[:1]), floor_of(), truth=False, period=0.05)


def test_sonar_answers_a_tick_later_and_says_when_it_pinged() -> None:
    fields: dict[str, Any] = {"model": "sonar", "device": "srf08", "cone_deg": 55.0, "min_range": 0.03, "latency": 1}
    eyes = tuple(_eye(f"g{group}", **fields, every=4, group=2 * group) for group in range(2))
    state = world({"a": cart(proximity=eyes)}, [box_wall(2.5, -9.0, 3.0, 9.0)])
    found = []
    for _ in range(8):
        sensors = measures(state, "a").sensors
        found.append([] if sensors is None else [(one.id, one.tick) for one in sensors.proximity])
        state, _ = run(state, 1)
    first = [[], [("g0", 0)], [("g0", 0)]]
    then = [[("g0", 0), ("g1", 2)]] * 2
    assert found == [*first, *then, *[[("g0", 4), ("g1", 2)]] * 2, [("g0", 4), ("g1", 6)]]


def _infrared_errors(distance: float, count: int = 64, ticks: int = 25, **fields: Any) -> list[float]:
    """Return what so many infrared sensors tell too much of a wall ahead, m."""
    eyes = tuple(_eye(f"e{k}", model="infrared", cone_deg=5.0, **fields) for k in range(count))
    state = world({"a": cart(proximity=eyes)}, [box_wall(0.5 + distance, -2.0, 3.0 + distance, 2.0)])
    found = []
    for _ in range(ticks):
        found += [value - distance for value in _seen(state) if not isinstance(value, str)]
        state, _ = run(state, 1)
    return found


def test_infrared_error_grows_with_the_square_of_the_distance() -> None:
    distances = (0.3, 0.5, 0.8, 1.2, 1.5)
    deviations = [float(np.std(_infrared_errors(distance))) for distance in distances]
    slope = float(np.polyfit(np.log(distances), np.log(deviations), 1)[0])
    assert slope == pytest.approx(2.0, abs=0.1)
    # MODEL.md: 2 mm and 48 mm of 10 mV; four standard errors of 1600 draws.
    assert deviations[0] == pytest.approx(0.0019, rel=0.08)
    assert deviations[-1] == pytest.approx(0.048, rel=0.08)


def test_infrared_tells_nothing_beyond_its_range_and_fails_by_its_share() -> None:
    assert max(_infrared_errors(1.4, max_range=1.45)) <= 0.05 + 1e-12
    assert len(_infrared_errors(1.0, dropout=0.25)) == pytest.approx(1200, abs=90)
    assert _infrared_errors(4.5) == []


def test_failing_sensor_says_fault() -> None:
    eyes = (_eye(model="infrared", dropout=1.0), _eye("b", model="sonar", dropout=1.0, latency=1))
    state, _ = run(world({"a": cart(proximity=eyes)}), 1)
    assert _seen(state) == ["fault", "fault"]


def test_sonar_beside_an_ideal_sensor_leaves_that_as_it_is() -> None:
    eyes = (
        _eye("sonar", model="sonar", latency=1),
        _eye("ideal"),
        _eye("fixed", model="sonar", mount="start", latency=1),
    )
    state, _ = run(world({"a": cart(proximity=eyes)}, [box_wall(2.5, -2.0, 3.0, 2.0)]), 1)
    found = _seen(state)
    assert found[1] == pytest.approx(2.0, abs=1e-12)
    assert [found[0], found[2]] == pytest.approx([2.0, 2.0], abs=0.00865 + ROUNDED)


def test_real_robot_has_no_sensor_that_is_fixed_in_the_world() -> None:
    with pytest.raises(RequestRefusedError, match=r"Mount: expected body for a real robot, got 'start'") as refused:
        check_sensors(Robot(type="real", proximity=(_eye(mount="start"),)), floor_of(), truth=False, period=0.05)
    assert refused.value.code == "mount"
