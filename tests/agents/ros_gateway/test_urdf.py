"""A robot as URDF, read by another reader: a tree of links whose places are those of the robot."""

from __future__ import annotations

import math
from xml.etree import ElementTree

import pytest

from intellwheels_agents.ros_gateway.urdf import urdf
from intellwheels_maps import names, robot
from intellwheels_schemas.rules import parts_of
from tests.every_case import every_case


def numbers(text: str) -> list[float]:
    return [float(word) for word in text.split()]


@every_case("name", names("robots"))
def test_description_is_a_tree_of_links_with_one_root(name: str) -> None:
    root = ElementTree.fromstring(urdf(robot(name), name))
    links = [link.get("name") for link in root.findall("link")]
    assert len(set(links)) == len(links)
    joints = [joint.get("name") for joint in root.findall("joint")]
    assert len(set(joints)) == len(joints)
    parents = {joint.find("child").get("link"): joint.find("parent").get("link") for joint in root.findall("joint")}  # type: ignore[union-attr]
    assert set(links) - parents.keys() == {"base_link"}
    assert set(parents.values()) <= set(links)
    assert len(parents) == len(joints)
    for joint in root.findall("joint"):
        assert joint.get("type") in {"fixed", "continuous"}
        origin = joint.find("origin")
        assert origin is not None
        assert all(map(math.isfinite, numbers(origin.get("xyz", "") + " " + origin.get("rpy", ""))))


def test_boxes_wheels_and_sensors_are_where_the_robot_has_them() -> None:
    chair = robot("intellwheels")
    root = ElementTree.fromstring(urdf(chair, "my.chair-1"))
    assert root.get("name") == "my_chair_1"
    collisions = root.findall("link[@name='base_link']/collision")
    for part, collision in zip(parts_of(chair), collisions, strict=True):
        box, origin = collision.find("geometry/box"), collision.find("origin")
        assert box is not None
        assert origin is not None
        assert numbers(box.get("size", "")) == pytest.approx([part.length, part.width, part.top - part.bottom])
        assert numbers(origin.get("xyz", "")) == pytest.approx([part.x, part.y, (part.bottom + part.top) / 2.0])
    left = root.find("joint[@name='left_wheel']/origin")
    assert left is not None
    assert numbers(left.get("xyz", "")) == pytest.approx([0.0, chair.track / 2.0, chair.wheel_diameter / 2.0])
    front = root.find("joint[@name='front_left_joint']/origin")
    assert front is not None
    assert numbers(front.get("xyz", "")) == [0.696, 0.33, 0.4]
    assert numbers(front.get("rpy", "")) == pytest.approx([0.0, 0.0, math.pi / 4.0], abs=1e-5)


def test_table_has_no_wheels() -> None:
    assert "wheel" not in urdf(robot("table"), "table")
