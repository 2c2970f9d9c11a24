"""The services of `simulation_interfaces`, with a world that only notes what it is asked."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from intellwheels_agents.ros_gateway.plane_pose import PlanePose
from intellwheels_agents.ros_gateway.ros_messages import pose_message
from intellwheels_agents.ros_gateway.ros_types import blank, decode_message, encode_message
from intellwheels_agents.ros_gateway.simulation_control import FEATURES, SimulationControl
from intellwheels_agents.ros_gateway.simulation_types import SERVICES
from intellwheels_maps import floor, robot
from intellwheels_schemas.codec import Encoding, encode
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.keys import Verb
from intellwheels_schemas.messages import Body, Clock, Entity, Map, Record, Result, ResultCode, Robot
from tests.agents.ros_gateway.made_up import RUN


class World:
    """Two chairs in the ward."""

    def __init__(self) -> None:
        self.asked: list[tuple[str, Record]] = []
        self.code: ResultCode = "ok"
        self.state = "running"
        self.tick = 20
        self.gone = False

    def control(self, verb: Verb, message: Record) -> Result:
        if self.gone:
            raise ConnectionError("no simulator")
        self.asked.append((verb, message))
        return Result(run=RUN, tick=0, code=self.code, text=None if self.code == "ok" else "why")

    def clock(self) -> Clock:
        return Clock(
            run=RUN, tick=self.tick, time=1.0, state=self.state, pace="realtime", hash=RUN, stamp=0.0  # type: ignore[arg-type]
        )  # fmt: skip

    def bodies(self) -> Sequence[Body]:
        names = {"chair1": robot("intellwheels"), "nurse": robot("person")}
        return [Body(run=RUN, tick=0, robot=msgspec.structs.replace(of, name=name)) for name, of in names.items()]

    def entities(self) -> tuple[float, Sequence[Entity]]:
        return 1.0, [
            Entity(name="chair1", x=1.0, y=2.0, heading=0.0, speed=0.5),
            Entity(name="nurse", x=9.0, y=2.0, heading=0.0),
        ]

    def floor(self) -> Map:
        if self.gone:
            raise ConnectionError("no simulator")
        return floor("ward")


@pytest.fixture
def world() -> World:
    return World()


def call(world: World, service: str, **fields: Any) -> Any:
    """Call a service with fields of its request, and return the response as its bytes say."""
    snake = "".join(f"_{letter.lower()}" if letter.isupper() else letter for letter in service)[1:]
    kind, answer = SimulationControl(world).services()[f"/{snake}"]
    request = blank(f"{kind}_Request")
    for path, value in fields.items():
        *parts, last = path.split("__")
        target = request
        for part in parts:
            target = getattr(target, part)
        setattr(target, last, value)
    return decode_message(f"{kind}_Response", encode_message(answer(request)))


def test_every_service_that_is_declared_is_served() -> None:
    services = SimulationControl(World()).services()
    assert {kind for kind, _ in services.values()} == {f"simulation_interfaces/srv/{name}" for name in SERVICES}
    assert "/get_simulator_features" in services


def test_features(world: World) -> None:
    features = call(world, "GetSimulatorFeatures").features
    assert tuple(features.features.tolist()) == FEATURES
    assert features.spawn_formats == ["iw.v1"]


@pytest.mark.parametrize(("state", "number"), [("running", 1), ("paused", 2), ("waiting", 0), ("ended", 0)])
def test_state_of_the_simulation(world: World, state: str, number: int) -> None:
    world.state = state
    assert call(world, "GetSimulationState").state.state == number


@pytest.mark.parametrize(("wanted", "verbs"), [(2, ["pause"]), (0, ["pause", "reset"]), (3, ["quit"])])
def test_setting_the_state(world: World, wanted: int, verbs: list[str]) -> None:
    assert call(world, "SetSimulationState", state__state=wanted).result.result == 1
    assert [verb for verb, _ in world.asked] == verbs


def test_setting_the_state_it_has_is_told(world: World) -> None:
    assert call(world, "SetSimulationState", state__state=1).result.result == 101
    world.state, world.tick = "paused", 0
    assert call(world, "SetSimulationState", state__state=0).result.result == 101
    assert call(world, "SetSimulationState", state__state=4).result.result == 0
    assert world.asked == []


def test_steps(world: World) -> None:
    assert call(world, "StepSimulation", steps=7).result.result == 1
    assert world.asked[0][1].count == 7  # type: ignore[attr-defined]
    assert call(world, "StepSimulation", steps=0).result.result == 4
    assert call(world, "StepSimulation", steps=2**63).result.result == 4
    world.code = "incorrect-state"
    found = call(world, "StepSimulation", steps=1).result
    assert (found.result, found.error_message) == (3, "why")


def test_reset_of_everything_only(world: World) -> None:
    assert [call(world, "ResetSimulation", scope=scope).result.result for scope in (0, 255, 1)] == [1, 1, 0]


def test_spawnables_are_the_included_robots(world: World) -> None:
    response = call(world, "GetSpawnables")
    assert "mid-wheel" in [one.entity_resource.uri for one in response.spawnables]
    assert call(world, "GetSpawnables", sources=["x"]).result.result == 0


def spawn(world: World, **fields: Any) -> Any:
    given = {
        "name": "crate1",
        "entity_resource__uri": "crate",
        "initial_pose__pose": pose_message(PlanePose(1.0, 2.0, 0.5)),
    }
    return call(world, "SpawnEntity", **{**given, **fields})


def test_spawning_by_name_and_from_a_document(world: World) -> None:
    response = spawn(world)
    assert (response.result.result, response.entity_name) == (1, "crate1")
    text = encode(robot("crate"), Encoding.XML).decode()
    assert (
        spawn(world, name="crate2", entity_resource__uri="", entity_resource__resource_string=text).result.result == 1
    )
    for _, message in world.asked:
        assert message.position.x == 1.0  # type: ignore[attr-defined]
        assert message.robot.kind == robot("crate").kind  # type: ignore[attr-defined]


def test_spawning_may_rename(world: World) -> None:
    assert spawn(world, name="chair1", allow_renaming=True).entity_name == "chair1-1"
    assert spawn(world, name="", allow_renaming=True).entity_name == f"{robot('crate').kind}-1"


@pytest.mark.parametrize(("fields", "code"), [
    ({"name": "chair1"}, 101), ({"name": "No Name"}, 102), ({"name": ""}, 102),
    ({"name": "No Name", "allow_renaming": True}, 102),
    ({"entity_resource__uri": "x.sdf"}, 103), ({"entity_resource__uri": ""}, 104), ({"entity_namespace": "/a"}, 105),
    ({"entity_resource__uri": "", "entity_resource__resource_string": "<robot/>"}, 106),
    ({"initial_pose__header__frame_id": "chair1/base_link"}, 109),
    ({"initial_pose__pose__orientation__w": 0.0, "initial_pose__pose__orientation__z": 0.0}, 109),
])  # fmt: skip
def test_spawning_says_what_is_wrong(world: World, fields: dict[str, Any], code: int) -> None:
    result = spawn(world, **fields).result
    assert result.result == code
    assert result.error_message
    assert world.asked == []


def test_deleting(world: World) -> None:
    assert call(world, "DeleteEntity", entity="chair1").result.result == 1
    assert call(world, "DeleteEntity", entity="*").result.result == 2
    world.code = "not-found"
    assert call(world, "DeleteEntity", entity="chair9").result.result == 2


def test_bodies_and_their_states(world: World) -> None:
    assert call(world, "GetEntities", filters__filter="^n").entities == ["nurse"]
    assert call(world, "GetEntities", filters__filter="(a+)+").result.result == 0
    response = call(world, "GetEntitiesStates")
    assert (response.entities, [state.pose.position.x for state in response.states]) == (
        ["chair1", "nurse"],
        [1.0, 9.0],
    )
    assert call(world, "GetEntityState", entity="chair1").state.twist.linear.x == 0.5
    assert call(world, "GetEntityState", entity="nobody").result.result == 2
    info = call(world, "GetEntityInfo", entity="nurse").info
    assert (info.category.category, info.tags) == (2, ["person"])
    assert call(world, "GetEntityInfo", entity="nobody").result.result == 2


def test_setting_a_pose_is_a_teleport(world: World) -> None:
    pose = pose_message(PlanePose(4.0, 5.0, 1.0))
    assert call(world, "SetEntityState", entity="chair1", set_pose=True, state__pose=pose).result.result == 1
    (_, message), = world.asked  # fmt: skip
    assert message.position.heading == pytest.approx(1.0)  # type: ignore[attr-defined]
    assert call(world, "SetEntityState", entity="chair1", set_twist=True).result.result == 0
    assert call(world, "SetEntityState", entity="chair1", set_pose=True).result.result == 101


def test_places_are_named_poses(world: World) -> None:
    grid = floor("ward").grid
    assert grid is not None
    assert [pose.name for pose in call(world, "GetNamedPoses").poses] == [place.name for place in grid.position]
    goals = call(world, "GetNamedPoses", tags__tags=["goal"]).poses
    assert [pose.name for pose in goals] == [place.name for place in grid.position if "goal" in place.kinds]


def test_worlds(world: World) -> None:
    assert "ward" in [one.name for one in call(world, "GetAvailableWorlds").worlds]
    assert call(world, "GetAvailableWorlds", additional_sources=["x"]).result.result == 0
    assert call(world, "GetCurrentWorld").world.world_resource.uri == "ward"
    assert call(world, "LoadWorld", world_resource__uri="room").result.result == 1
    text = encode(floor("room"), Encoding.XML).decode()
    assert call(world, "LoadWorld", world_resource__resource_string=text).result.result == 1
    assert [message.name for _, message in world.asked] == ["room", None]  # type: ignore[attr-defined]
    assert call(world, "LoadWorld").result.result == 102
    assert call(world, "LoadWorld", world_resource__uri="nowhere").result.result == 2
    assert call(world, "LoadWorld", world_resource__resource_string="<sdf/>").result.result == 103


@pytest.mark.parametrize("service", SERVICES)
@settings(max_examples=60, deadline=None, database=None)
@given(st.data())
def test_any_bytes_are_refused_or_answered(service: str, data: st.DataObject) -> None:
    kind = f"simulation_interfaces/srv/{service}"
    start = encode_message(blank(f"{kind}_Request"))
    cut = data.draw(st.integers(0, len(start)))
    raw = start[:cut] + data.draw(st.binary(max_size=80)) + data.draw(st.sampled_from([b"", start[cut:]]))
    try:
        request = decode_message(f"{kind}_Request", raw)
    except WireError:
        return
    answers = dict(SimulationControl(World()).services().values())
    assert encode_message(answers[kind](request))


def test_world_that_is_gone_is_a_failed_operation(world: World) -> None:
    world.gone = True
    assert call(world, "GetCurrentWorld").result.error_message == "no simulator"
    assert call(world, "StepSimulation", steps=1).result.result == 4


def test_robot_of_a_request_has_no_other_role(world: World) -> None:
    strange = encode(Robot(name="x", role="mind"), Encoding.XML).decode()
    result = spawn(world, entity_resource__uri="", entity_resource__resource_string=strange).result
    assert result.result in (1, 4, 106)
