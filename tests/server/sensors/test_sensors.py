"""The sensors of all bodies: what is refused, when they sample, and what survives a change of bodies."""

from __future__ import annotations

import pytest

from intellwheels_schemas.errors import RequestRefusedError
from intellwheels_schemas.messages import GPS, Compass, Encoders, Ground, Lidar, Proximity, Record, Robot, Truth
from intellwheels_server.inputs import Depart, Join
from intellwheels_server.sensors import check_sensors
from intellwheels_server.world import State, measures
from tests.server.worlds import cart, do, run, world


def _late(every: int = 1, latency: int = 0) -> Encoders:
    return Encoders(id="w", every=every, latency=latency)


def _read(state: State, agent: str = "a") -> tuple[int | None, int] | None:
    """Return the tick that the reading carries and how many ticks of 5 cm the wheel has made."""
    sensors = measures(state, agent).sensors
    if sensors is None:
        return None
    return sensors.encoders[0].tick, round(sensors.encoders[0].left / 143)


# 143 ticks are 5 cm, the way of a tick at full power.
_CART = {"wheel_diameter": 0.35, "encoder_ticks": 3145}


def _history(state: State, steps: int) -> list[tuple[int | None, int] | None]:
    found = [_read(state)]
    for _ in range(steps):
        state, _ = run(state, 1, {"a": (1.0, 1.0)})
        found.append(_read(state))
    return found


def test_sensor_with_latency_is_absent_at_first_and_then_late_with_its_own_tick() -> None:
    state = world({"a": cart(encoders=(_late(latency=2),), **_CART)})
    assert _history(state, 4) == [None, None, (0, 0), (1, 1), (2, 2)]


def test_sensor_with_its_own_rate_repeats_its_last_reading_with_its_tick() -> None:
    state = world({"a": cart(encoders=(_late(every=3),), **_CART)})
    assert _history(state, 6) == [(None, 0), (0, 0), (0, 0), (None, 3), (3, 3), (3, 3), (None, 6)]


def test_rate_and_latency_together() -> None:
    state = world({"a": cart(encoders=(_late(every=2, latency=3),), **_CART)})
    assert _history(state, 7) == [None, None, None, (0, 0), (0, 0), (2, 2), (2, 2), (4, 4)]


def test_samples_on_their_way_survive_when_others_come_and_go() -> None:
    robot = cart(encoders=(_late(latency=3),), **_CART)
    quiet = world({"m": robot})
    busy = world({"m": robot})
    for step in range(8):
        quiet, _ = run(quiet, 1, {"m": (1.0, 1.0)})
        busy, _ = run(busy, 1, {"m": (1.0, 1.0)})
        change = (
            Depart(agent=f"a{step - 1}") if step % 2 else Join(agent=f"a{step}", robot=cart(20.0, proximity=(_eye(),)))
        )
        busy, outcome, _ = do(busy, change)
        assert outcome.code == "ok", outcome.text
        assert _read(busy, "m") == _read(quiet, "m")


def test_who_joins_late_is_sampled_from_then_on() -> None:
    state = world({"b": cart(5.0)})
    state, _ = run(state, 4)
    state, _, _ = do(state, Join(agent="a", robot=cart(encoders=(_late(every=2),), **_CART)))
    assert _history(state, 3) == [(None, 0), (4, 0), (None, 2), (6, 2)]


def test_body_without_sensors_has_none_in_its_measures() -> None:
    assert measures(world({"a": cart()}), "a").sensors is None


def test_readings_come_in_the_order_of_declaration() -> None:
    eyes = (_eye("one"), _eye("two", mount="start"), _eye("three"))
    sensors = measures(world({"a": cart(proximity=eyes)}), "a").sensors
    assert sensors is not None
    assert [reading.id for reading in sensors.proximity] == ["one", "two", "three"]


def test_readings_of_a_real_sensor_are_left_to_its_bridge() -> None:
    eyes = (_eye("virtual"), _eye("real", source="real"))
    sensors = measures(world({"a": cart(type="real", proximity=eyes)}), "a").sensors
    assert sensors is not None
    assert [reading.id for reading in sensors.proximity] == ["virtual"]


def _eye(sensor_id: str = "eye", **fields: str) -> Proximity:
    known = {"x": 0.5, "y": 0.0, "z": 0.4, "direction_deg": 0.0, "cone_deg": 30.0, "max_range": 4.0}
    return Proximity(id=sensor_id, **{**known, **fields})  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("field", "declaration"),
    [
        ("lidar", Lidar(id="l", x=0.0, y=0.0, z=0.4, direction_deg=0.0, fov_deg=180.0, rays=181, max_range=8.0)),
        ("gps", GPS(id="g")),
        ("ground", Ground(id="g")),
    ],
)
def test_kind_that_is_not_simulated_yet_is_refused_by_name(field: str, declaration: Record) -> None:
    robot = Robot(**{field: (declaration,)})  # type: ignore[arg-type]
    name = type(declaration).__name__
    with pytest.raises(
        RequestRefusedError, match=rf"Robot.{name}\[0\]: expected one of Proximity, .*not simulated"
    ) as refused:
        check_sensors(robot, truth=True)
    assert refused.value.code == "field"


def test_truth_is_refused_where_it_is_not_allowed() -> None:
    robot = Robot(compass=(Compass(id="c"),), truth=(Truth(id="t"),))
    with pytest.raises(RequestRefusedError, match=r"Robot.Truth\[0\]: truth sensors are not allowed") as refused:
        check_sensors(robot, truth=False)
    assert refused.value.code == "truth"
    check_sensors(robot, truth=True)


def test_real_sensor_of_any_kind_and_model_is_let_in_since_its_bridge_reads_it() -> None:
    sonar = Proximity(
        id="s", x=0.0, y=0.0, z=0.4, direction_deg=0.0, cone_deg=30.0, max_range=4.0, source="real", model="sonar"
    )
    check_sensors(Robot(type="real", gps=(GPS(id="g", source="real"),), proximity=(sonar,)), truth=False)
