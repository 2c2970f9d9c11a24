from __future__ import annotations

from typing import Any

import msgspec
import pytest

from intellwheels_maps import robot
from intellwheels_schemas import defaults
from intellwheels_schemas.codec import MAX_BYTES
from intellwheels_schemas.messages import Clock, Lidar, Proximity, Refused, Robot, Spawn
from intellwheels_server.service.sensor_budget import MAX_READING_BYTES, costliest, total_rays
from intellwheels_server.world.sensors import rays_of
from tests.server.stage import Stage

PERIOD = defaults.PERIOD


def lidar(name: str, rays: int = 1440, **more: Any) -> Lidar:
    return Lidar(id=name, x=0.5, y=0.0, z=0.4, direction_deg=0.0, fov_deg=360.0, rays=rays, max_range=10.0, **more)


def with_lidars(count: int, rays: int = 1440, **more: Any) -> Robot:
    sensors = tuple(lidar(f"l{k}", rays, **more) for k in range(count))
    return msgspec.structs.replace(robot("rear-wheel"), proximity=(), lidar=sensors)


def refusal(stage: Stage, agent: str, wanted: Robot) -> Refused:
    reply, ok = stage.try_join(agent, wanted)
    assert not ok
    assert isinstance(reply, Refused)
    return reply


def test_body_with_too_many_rays_is_refused_in_words() -> None:
    stage = Stage(pace="realtime")
    refused = refusal(stage, "chair1", with_lidars(14))
    assert refused.code == "limit"
    assert refused.text.startswith("Robot: expected sensors of at most 400,000 rays a second, got 403,200; use fewer")
    stage.join("chair1", with_lidars(13))
    assert refusal(stage, "chair2", with_lidars(64)).code == "limit"


def test_lidar_that_scans_less_often_costs_less() -> None:
    assert rays_of(with_lidars(1, 1000, every=4)) == 250.0
    stage = Stage(pace="realtime")
    stage.join("chair1", with_lidars(16, every=2))


def test_wedges_count_as_several_rays_and_real_sensors_as_none() -> None:
    def wedge(**more: Any) -> Proximity:
        return Proximity(id="a", x=0.5, y=0.0, z=0.4, direction_deg=0.0, cone_deg=30.0, max_range=4.0, **more)

    def cost(sensor: Proximity | Lidar, **more: Any) -> float:
        field = "lidar" if isinstance(sensor, Lidar) else "proximity"
        bare = msgspec.structs.replace(robot("rear-wheel"), proximity=(), **more)
        return rays_of(msgspec.structs.replace(bare, **{field: (sensor,)}))

    assert cost(wedge()) == 2.0
    assert cost(wedge(model="infrared")) == 2.0
    assert cost(wedge(model="sonar")) == 10.0
    assert cost(wedge(model="sonar", crosstalk=0.5)) == 25.0
    assert cost(lidar("l", source="real"), type="real") == 0.0


def test_world_that_is_full_refuses_more_rays_but_not_bodies_without_any() -> None:
    stage = Stage(pace="realtime", world_rays=60_000)
    stage.join("chair1", with_lidars(1))
    stage.join("chair2", with_lidars(1), instance="b" * 16)
    reply, ok = stage.try_join("chair3", with_lidars(1), instance="c" * 16)
    assert not ok
    assert isinstance(reply, Refused)
    assert reply.code == "full"
    assert reply.text.startswith(
        "Robot: expected sensors of at most 60,000 rays a second in the whole world, got 28,800 in addition to 57,600"
    )
    stage.join("table1", "table", instance="d" * 16)
    stage.result("delete", b'{"Agent":"chair2"}')
    stage.join("chair3", with_lidars(1), instance="c" * 16)


def test_body_that_is_replaced_does_not_count_twice() -> None:
    stage = Stage(pace="realtime", world_rays=60_000)
    stage.join("chair1", with_lidars(2))
    session = stage.sessions["chair1"]
    stage.join("chair1", with_lidars(2, 1439), parameters={"session": session})
    assert total_rays(stage.live_run.state) == 2 * 1439


def test_operator_sets_the_limit_of_an_agent() -> None:
    stage = Stage(pace="realtime", agent_rays=1_000_000)
    stage.join("chair1", with_lidars(16))


@pytest.mark.parametrize("pace", ["lockstep", "free"])
def test_run_that_takes_its_time_has_no_limit_of_rays(pace: str) -> None:
    stage = Stage(pace=pace, open_loop=True)
    # Otherwise the stage would run some hundred ticks of 21,600 rays meanwhile.
    assert stage.result("pause").code == "ok"
    stage.join("chair1", with_lidars(15))


@pytest.mark.parametrize("pace", ["lockstep", "realtime"])
def test_robot_whose_readings_would_not_fit_one_message_is_refused(pace: str) -> None:
    stage = Stage(pace=pace, agent_rays=10**9, world_rays=10**9)
    refused = refusal(stage, "chair1", with_lidars(17))
    assert refused.code == "limit"
    assert refused.text.startswith(
        "Robot: expected sensors whose readings fit into 786,432 bytes, got up to 793,600 bytes"
    )
    stage.join("chair1", with_lidars(16))


def test_limits_leave_room_in_a_message() -> None:
    assert MAX_READING_BYTES == 786_432  # KEYS.md says it too
    assert MAX_READING_BYTES < MAX_BYTES


def test_spawned_body_is_checked_too() -> None:
    stage = Stage(pace="realtime")
    wanted = msgspec.structs.replace(with_lidars(15), name="chair1", format=None)
    stage.result("spawn", Spawn(robot=wanted))
    stage = Stage(pace="realtime", agent_rays=28_799)
    result = stage.result("spawn", Spawn(robot=msgspec.structs.replace(with_lidars(1), name="chair1", format=None)))
    assert result.code == "failed"
    assert result.text is not None
    assert result.text.startswith("Spawn.Robot: expected sensors of at most 28,799 rays a second, got 28,800")


def test_thousand_chairs_with_eight_wedges_fit_by_default() -> None:
    chair = rays_of(robot("rear-wheel"))
    assert 0.0 < chair <= 16.0
    assert 1000 * 16.0 / PERIOD <= defaults.WORLD_RAYS


def test_clock_says_whose_sensors_cost_most() -> None:
    stage = Stage(pace="realtime")
    assert costliest(stage.live_run.state) is None
    stage.join("chair1", with_lidars(1, 100))
    stage.join("chair2", with_lidars(1, 300), instance="b" * 16)
    stage.join("table1", "table", instance="c" * 16)
    stage.live_run.spend(0.4, stage.now + 0.4)
    stage.now += 1.0
    clock = stage.ask("clock", "")[0][0]
    assert isinstance(clock, Clock)
    assert (clock.rays, clock.costliest, clock.load) == (400, "chair2", 0.4)
