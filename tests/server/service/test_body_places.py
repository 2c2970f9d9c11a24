from __future__ import annotations

from intellwheels_maps import robot
from intellwheels_server.service.body_places import is_unowned, named, position_of, reserved_places
from tests.server.stage import Stage


def test_places_are_kept_for_others_only_and_only_if_the_map_has_them() -> None:
    stage = Stage(reserved={"chair1": "start1", "chair2": "start2", "chair3": "moon"})
    service = stage.live_run._service
    assert reserved_places(service) == ("start1", "start2")
    assert reserved_places(service, besides="chair1") == ("start2",)


def test_a_body_is_unowned_only_without_the_agent_that_joined_with_it() -> None:
    stage = Stage()
    stage.join("chair1")
    service = stage.live_run._service
    assert not is_unowned(service, "chair1")
    (member,) = service.agents.roster.members("chair1")
    service.agents.roster.remove(member)
    assert is_unowned(service, "chair1")
    assert not is_unowned(service, "nobody")


def test_the_pose_of_a_body_is_where_it_is_now() -> None:
    stage = Stage()
    stage.join("chair1")
    state = stage.live_run.state
    assert position_of(state, "chair1") == state.body_set.models["chair1"].start


def test_a_robot_keeps_its_name_or_gets_that_of_its_agent() -> None:
    chair = robot("rear-wheel")
    assert named(chair, "chair1").name == "chair1"
    assert named(named(chair, "chair2"), "chair1").name == "chair2"
