"""The sensors of all bodies: what is refused, when they sample, and what survives a change of bodies."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import msgspec
import pytest

from intellwheels_maps import floor
from intellwheels_maps import robot as included_robot
from intellwheels_schemas.codec import Encoding, decode, encode
from intellwheels_schemas.errors import RequestRefusedError
from intellwheels_schemas.file_records import Depart, Inputs, Join
from intellwheels_schemas.messages import (
    GPS,
    IMU,
    Actions,
    Beacon,
    Compass,
    Encoders,
    Ground,
    Lidar,
    Measures,
    Odometry,
    Place,
    Proximity,
    Robot,
    Sensors,
    Truth,
)
from intellwheels_schemas.rules import SENSOR_KINDS
from intellwheels_server.world import Setup, State, advance, apply, begin, digest, measures
from intellwheels_server.world.sensors import check_sensors, reading_bytes_of
from intellwheels_server.world.sensors.catalogue import KINDS, example_sensors
from tests.server.worlds import box_wall, cart, do, floor_of, run, world


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
    return Proximity(**{**_known(sensor_id), **fields})


def _known(sensor_id: str) -> dict[str, Any]:
    known = {"x": 0.5, "y": 0.0, "z": 0.4, "direction_deg": 0.0, "cone_deg": 30.0, "max_range": 4.0}
    return {"id": sensor_id, **known}


def test_beacon_for_a_place_that_the_floor_has_not_is_refused() -> None:
    with pytest.raises(RequestRefusedError, match=r"Robot.Beacon\[0\].Place: expected a place of map 'test', got 'x'"):
        check_sensors(Robot(beacon=(Beacon(id="b", place="x"),)), floor_of(), truth=False, period=0.05)


def test_firing_groups_sample_one_after_the_other_within_their_rate() -> None:
    eyes = tuple(Proximity(**{**_known(f"g{group}"), "every": 3, "group": group}) for group in range(3))
    state = world({"a": cart(proximity=eyes)})
    found = []
    for _ in range(5):
        sensors = measures(state, "a").sensors
        assert sensors is not None
        found.append([(reading.id, reading.tick) for reading in sensors.proximity])
        state, _ = run(state, 1)
    assert found == [
        [("g0", None)],
        [("g0", 0), ("g1", None)],
        [("g0", 0), ("g1", 1), ("g2", None)],
        [("g0", None), ("g1", 1), ("g2", 2)],
        [("g0", 3), ("g1", None), ("g2", 2)],
    ]


_EVERYTHING: dict[str, Any] = {
    "proximity": (
        Proximity(id="ir", x=0.5, y=0.0, z=0.4, direction_deg=0.0, cone_deg=10.0, max_range=4.0, model="infrared"),
        Proximity(
            id="us", x=0.5, y=0.0, z=0.4, direction_deg=0.0, cone_deg=30.0, max_range=4.0, model="sonar", dropout=0.1,
            crosstalk=0.5, every=2, group=1, latency=1,
        ),
    ),
    "lidar": (
        Lidar(id="l", x=0.0, y=0.0, z=0.4, direction_deg=0.0, fov_deg=360.0, rays=24, max_range=8.0, dropout=0.1),
    ),
    "encoders": (Encoders(id="w", drift=1e-4),),
    "odometry": (Odometry(id="o", every=2, latency=1),),
    "compass": (Compass(id="c", noise_deg=1.0, walk_deg=1.0),),
    "gps": (GPS(id="g", noise=0.1, walk=0.1),),
    "imu": (IMU(id="i", noise=0.1, turn_noise=0.1, walk=0.1, turn_walk=0.1),),
    "beacon": (Beacon(id="b", place="goal", noise_deg=1.0, walk_deg=1.0),),
    "ground": (Ground(id="z"),),
}  # fmt: skip
_FLOOR = floor_of([box_wall(4.0, -2.0, 5.0, 2.0)], [Place(name="goal", x=3.0, y=1.0)])


def _everything(seed: str = "1") -> State:
    robots = {"a": cart(**_EVERYTHING), "b": cart(2.0, 2.5, -1.6, **_EVERYTHING)}
    return world(robots, floor=_FLOOR, seed=seed)


def test_same_inputs_give_the_same_readings_and_hashes_of_every_kind() -> None:
    one, two, other = _everything(), _everything(), _everything(seed="2")
    for _ in range(12):
        one, _ = run(one, 1, {"a": (0.5, 0.4), "b": (0.3, 0.4)})
        two, _ = run(two, 1, {"a": (0.5, 0.4), "b": (0.3, 0.4)})
        other, _ = run(other, 1, {"a": (0.5, 0.4), "b": (0.3, 0.4)})
        assert measures(one, "a") == measures(two, "a")
        assert digest(one) == digest(two) != digest(other)
        assert decode(Measures, encode(measures(one, "a"))) == measures(one, "a")


def test_who_comes_and_goes_changes_no_reading_of_sensors_that_remember() -> None:
    quiet, busy = _everything(), _everything()
    for step in range(10):
        change = Depart(agent="far") if step % 2 else Join(agent="far", robot=cart(30.0, **_EVERYTHING))
        busy, outcome, _ = do(busy, change)
        assert outcome.code == "ok", outcome.text
        assert measures(busy, "a") == measures(quiet, "a")
        quiet, _ = run(quiet, 1, {"a": (0.5, 0.4)})
        busy, _ = run(busy, 1, {"a": (0.5, 0.4)})


def test_noise_of_every_kind_is_the_same_whoever_else_is_there() -> None:
    # Without crosstalk, which is the exception.
    calm = dict(_EVERYTHING, proximity=_EVERYTHING["proximity"][:1])
    alone = world({"b": cart(**calm)}, floor=_FLOOR)
    company = world({"a": cart(30.0, **calm), "b": cart(**calm), "c": cart(40.0)}, floor=_FLOOR)
    for _ in range(6):
        assert measures(alone, "b") == measures(company, "b")
        alone, _ = run(alone, 1, {"b": (0.4, 0.5)})
        company, _ = run(company, 1, {"b": (0.4, 0.5)})


def test_what_sensors_remember_is_part_of_the_hash() -> None:
    walking = world({"a": cart(gps=(GPS(id="g", walk=0.1),))})
    faster = world({"a": cart(gps=(GPS(id="g", walk=0.2),))})
    walking, _ = run(walking, 2)
    faster, _ = run(faster, 2)
    assert digest(walking) != digest(faster)


def test_truth_is_refused_where_it_is_not_allowed() -> None:
    robot = Robot(compass=(Compass(id="c"),), truth=(Truth(id="t"),))
    with pytest.raises(RequestRefusedError, match=r"Robot.Truth\[0\]: truth sensors are not allowed") as refused:
        check_sensors(robot, floor_of(), truth=False, period=0.05)
    assert refused.value.code == "truth"
    check_sensors(robot, floor_of(), truth=True, period=0.05)


def test_real_sensor_of_any_kind_and_model_is_let_in_since_its_bridge_reads_it() -> None:
    sonar = Proximity(
        id="s", x=0.0, y=0.0, z=0.4, direction_deg=0.0, cone_deg=30.0, max_range=4.0, source="real", model="sonar"
    )
    check_sensors(
        Robot(type="real", gps=(GPS(id="g", source="real"),), proximity=(sonar,)), floor_of(), truth=False, period=0.05
    )


def _numbers(plain: Any) -> Iterator[float]:
    if isinstance(plain, dict | list | tuple):
        for one in plain.values() if isinstance(plain, dict) else plain:
            yield from _numbers(one)
    elif isinstance(plain, float):
        yield plain


def test_readings_have_six_decimals_at_most_and_what_sensors_remember_has_all() -> None:
    sensors: dict[str, Any] = dict(example_sensors(floor("room")))
    state = world({"a": cart(2.1, 2.3, 0.7, **sensors)}, truth=True, floor=floor("room"))
    state, _ = run(state, 7, {"a": (0.3, 0.7)})
    found = measures(state, "a").sensors
    assert found is not None
    declared = {"Lidar": ["StartDeg", "StepDeg"]}
    plain = msgspec.to_builtins(found)
    for kind, fields in declared.items():
        for reading in plain[kind]:
            for name in fields:
                del reading[name]
    numbers = list(_numbers(plain))
    assert len(numbers) > 20
    assert [number for number in numbers if number != round(number, 6)] == []
    assert [number for number in numbers if number == 0.0 and math.copysign(1.0, number) < 0.0] == []
    remembered = state.samples[state.body_set.plan.memory]
    assert (remembered != remembered.round(6)).any()


def test_heading_that_rounding_takes_out_is_moved_back() -> None:
    state = world({"a": cart(heading=-math.pi + 1e-9, compass=(Compass(id="c"),))})
    found = measures(state, "a").sensors
    assert found is not None
    assert found.compass[0].value == math.pi


@pytest.mark.parametrize("encoding", list(Encoding)[:2])
def test_scan_of_180_rays_fits_the_fragments_of_a_small_controller(encoding: Encoding) -> None:
    lidar = Lidar(id="l", x=0.3, y=0.0, z=0.4, direction_deg=0.0, fov_deg=270.0, rays=180, max_range=30.0, noise=0.01)
    state = world({"a": cart(10.0, 5.0, 0.3, lidar=(lidar,))}, floor=floor("ward"))
    state, _ = run(state, 202, {"a": (0.2, 0.3)})
    message = measures(state, "a")
    assert message.time == 10.1
    assert len(encode(message, encoding)) < 3000


@pytest.mark.parametrize("encoding", [Encoding.JSON, Encoding.XML])
def test_measures_are_not_larger_than_the_bound_of_their_readings(encoding: Encoding) -> None:
    examples: dict[str, Any] = dict(example_sensors(floor("room")))
    rays = Lidar(
        id="i" * 32, x=0.5, y=0.1, z=0.4, direction_deg=0.1, fov_deg=359.9, rays=1440, max_range=20_000.0, noise=1e-5
    )
    robot = msgspec.structs.replace(included_robot("rear-wheel"), **{**examples, "lidar": (rays,)})
    state = begin(Setup(floor=floor("room"), truth=True), "0" * 16)
    state, outputs = apply(state, [Join(agent="a" * 32, robot=robot)])
    assert outputs.outcomes[0].code == "ok", outputs.outcomes[0].text
    for _ in range(3):
        state, _ = advance(state, Inputs(actions={"a" * 32: Actions(left_motor=0.7, right_motor=0.3)}))
    sensors = measures(state, "a" * 32).sensors
    assert sensors is not None
    for field in SENSOR_KINDS:
        declared = getattr(robot, field)
        for declaration, reading in zip(declared, getattr(sensors, field), strict=True):
            stamped = msgspec.structs.replace(reading, tick=2**53 - 1)
            alone = Measures(run="0" * 16, tick=0, time=0.0, sensors=Sensors(**{field: (stamped,)}))
            assert len(encode(alone, encoding)) <= KINDS[type(declaration)].reading_bytes(declaration), field
    assert len(encode(measures(state, "a" * 32), encoding)) <= reading_bytes_of(robot)
