"""Proximity sensors in a world: what they see of bodies, from where, and what is refused."""

from __future__ import annotations

import math

import pytest

from intellwheels_schemas.errors import RequestRefusedError
from intellwheels_schemas.messages import Part, Position, Proximity, Robot
from intellwheels_server.sensors import check_sensors
from intellwheels_server.sensors.proximity import ProximityKind, unit_vector
from intellwheels_server.world import State, measures
from tests.server.worlds import box_wall, cart, run, world

# The paper's example: a top from 0.69 to 0.72 m on four legs of 5 cm.
_TABLE = Robot(
    kind="table",
    part=(
        Part(x=0.0, y=0.0, length=1.2, width=0.8, bottom=0.69, top=0.72),
        *(Part(x=x, y=y, length=0.05, width=0.05, bottom=0.0, top=0.69) for x in (-0.55, 0.55) for y in (-0.35, 0.35)),
    ),
    position=Position(x=3.0, y=0.0, heading=0.0),
)


def _eye(sensor_id: str = "eye", **fields: float | str) -> Proximity:
    known = {"x": 0.5, "y": 0.0, "z": 0.4, "direction_deg": 0.0, "cone_deg": 30.0, "min_range": 0.02, "max_range": 4.0}
    return Proximity(id=sensor_id, **{**known, **fields})  # type: ignore[arg-type]


def _seen(state: State, agent: str = "a") -> list[float | str]:
    sensors = measures(state, agent).sensors
    assert sensors is not None
    return [reading.status if reading.value is None else reading.value for reading in sensors.proximity]


def test_sensor_at_0_4_m_sees_only_the_legs_of_a_table_and_one_at_0_7_m_its_top() -> None:
    eyes = tuple(_eye(f"z{z}", z=z) for z in (0.4, 0.69, 0.7, 0.72))
    state = world({"a": cart(proximity=eyes), "table": _TABLE})
    legs, bottom, top, above = _seen(state)
    # The nearest corner of a leg, 0.325 to the side, is inside the cone; the top's edge is straight ahead.
    assert legs == pytest.approx(math.hypot(2.425 - 0.5, 0.325), abs=1e-12)
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


def test_direction_to_the_side_is_exactly_to_the_side() -> None:
    assert [unit_vector(degrees) for degrees in (0.0, 90.0, -90.0, 180.0, -180.0, 360.0)] == [
        (1.0, 0.0), (0.0, 1.0), (0.0, -1.0), (-1.0, 0.0), (-1.0, 0.0), (1.0, 0.0),
    ]  # fmt: skip
    assert unit_vector(30.0) == pytest.approx((math.sqrt(0.75), 0.5), abs=1e-15)


def test_model_that_is_not_simulated_yet_is_refused() -> None:
    with pytest.raises(
        RequestRefusedError, match=r"Robot.Proximity\[2\].Model: expected ideal, got 'sonar'"
    ) as refused:
        ProximityKind().check("Robot.Proximity[2]", _eye(model="sonar"), Robot())
    assert refused.value.code == "value"


def test_real_robot_has_no_sensor_that_is_fixed_in_the_world() -> None:
    with pytest.raises(RequestRefusedError, match=r"Mount: expected body for a real robot, got 'start'") as refused:
        check_sensors(Robot(type="real", proximity=(_eye(mount="start"),)), truth=False)
    assert refused.value.code == "mount"
