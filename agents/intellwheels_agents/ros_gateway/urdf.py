"""A robot as URDF, the description that ROS tools read. Pure.

Frames and joints have the names that the gateway publishes, without the name of the chair: `robot_state_publisher` adds
it with the parameter `frame_prefix`. The contract has no masses, so no link has an inertia.
"""

from __future__ import annotations

import math
from typing import Final

from lxml import etree

from intellwheels_agents.ros_gateway.robot_frames import sensor_frames
from intellwheels_agents.ros_gateway.ros_names import BASE, WHEELS, ros_name
from intellwheels_schemas.messages import Robot
from intellwheels_schemas.rules import parts_of

WHEEL_WIDTH: Final = 0.05
"""Width of a drawn wheel, m; the contract has none."""


def urdf(robot: Robot, name: str) -> str:
    """Return the description of a robot as an XML document.

    Args:
        robot: The robot: its boxes, its driven wheels if it has motors, and the frames of its sensors.
        name: Its name.

    Raises:
        WireError: Two sensors would have the same name.
    """
    root = etree.Element("robot", name=ros_name(name) or "robot")
    base = etree.SubElement(root, "link", name=BASE)
    for part in parts_of(robot):
        for kind in ("visual", "collision"):
            shape = etree.SubElement(base, kind)
            _origin(shape, part.x, part.y, (part.bottom + part.top) / 2.0)
            size = f"{_text(part.length)} {_text(part.width)} {_text(part.top - part.bottom)}"
            etree.SubElement(etree.SubElement(shape, "geometry"), "box", size=size)
    if robot.top_speed > 0.0:
        for joint, side in zip(WHEELS, (1.0, -1.0), strict=True):
            _wheel(root, joint, side * robot.track / 2.0, robot.wheel_diameter / 2.0)
    for frame in sensor_frames(robot).values():
        etree.SubElement(root, "link", name=frame.name)
        joint_element = _joint(root, f"{frame.name}_joint", "fixed", frame.name)
        _origin(joint_element, frame.pose.x, frame.pose.y, frame.height, yaw=frame.pose.heading)
    etree.indent(root)
    document: bytes = etree.tostring(root, xml_declaration=True, encoding="utf-8")
    return document.decode() + "\n"


def _wheel(root: etree._Element, joint: str, y: float, radius: float) -> None:
    link = etree.SubElement(root, "link", name=f"{joint}_link")
    visual = etree.SubElement(link, "visual")
    # A cylinder of URDF stands on z; the axle of a wheel is y.
    _origin(visual, 0.0, 0.0, 0.0, roll=math.pi / 2.0)
    cylinder = {"radius": _text(radius), "length": _text(WHEEL_WIDTH)}
    etree.SubElement(etree.SubElement(visual, "geometry"), "cylinder", cylinder)
    element = _joint(root, joint, "continuous", f"{joint}_link")
    _origin(element, 0.0, y, radius)
    etree.SubElement(element, "axis", xyz="0 1 0")


def _joint(root: etree._Element, name: str, kind: str, child: str) -> etree._Element:
    joint = etree.SubElement(root, "joint", name=name, type=kind)
    etree.SubElement(joint, "parent", link=BASE)
    etree.SubElement(joint, "child", link=child)
    return joint


def _origin(parent: etree._Element, x: float, y: float, z: float, *, roll: float = 0.0, yaw: float = 0.0) -> None:
    place, turn = f"{_text(x)} {_text(y)} {_text(z)}", f"{_text(roll)} 0 {_text(yaw)}"
    etree.SubElement(parent, "origin", xyz=place, rpy=turn)


def _text(value: float) -> str:
    return f"{round(value, 6) + 0.0:.6g}"
