"""Names of ROS: what is mapped, what is refused."""

from __future__ import annotations

import msgspec
import pytest

from intellwheels_agents.ros_gateway.ros_names import ros_name, sensor_names
from intellwheels_maps import robot
from intellwheels_schemas.errors import WireError


@pytest.mark.parametrize(
    ("text", "name"),
    [("chair1", "chair1"), ("front-left", "front_left"), ("a.b--c", "a_b_c"), ("a_", "a"), ("a__b", "a_b")],
)
def test_forbidden_characters_become_an_underscore(text: str, name: str) -> None:
    assert ros_name(text) == name


def test_sensors_of_the_chair() -> None:
    names = sensor_names(robot("intellwheels"))
    assert names["front-left"] == "front_left"
    assert len(set(names.values())) == 8


@pytest.mark.parametrize(("ids", "text"), [
    (("front-left", "front_left"), "sensor 'front_left': expected an id whose name in ROS is not 'front_left', as that "
     "of sensor 'front-left', got 'front_left'"),
    (("front", "base.link"), "sensor 'base.link': expected an id whose name in ROS is not 'base_link'"),
])  # fmt: skip
def test_two_sensors_with_one_name_are_refused(ids: tuple[str, str], text: str) -> None:
    chair = robot("intellwheels")
    sensors = tuple(msgspec.structs.replace(one, id=name) for one, name in zip(chair.proximity, ids, strict=False))
    with pytest.raises(WireError) as caught:
        sensor_names(msgspec.structs.replace(chair, proximity=sensors))
    assert caught.value.text.startswith(text)
