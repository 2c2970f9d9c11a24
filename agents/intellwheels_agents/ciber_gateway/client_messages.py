"""What clients of the Ciber-Rato simulator send: registrations, actions of robots, commands of viewers. Pure.

Each datagram is one element of XML. Many clients end it with a zero byte.

Source:
    The public tools of the simulator (github.com/iris-ua/ciberRatoTools): its handlers and the libraries of agents.
"""

from __future__ import annotations

import re
from typing import Any, Final, Literal, NamedTuple

from intellwheels_schemas import elements
from intellwheels_schemas.errors import WireError, wrong_value
from intellwheels_schemas.explain import shown
from intellwheels_schemas.messages import TEXT_PATTERN

MAX_BYTES: Final = 4096
"""Longest datagram that is read."""
IR_ANGLES: Final = (0.0, 60.0, -60.0, 180.0)
"""Directions of the obstacle sensors of a robot that does not say them, degrees anticlockwise from ahead."""
MAX_ID: Final = 1000
"""Largest number of a robot."""
LONGEST_SAY: Final = 100
"""Most characters that the simulator takes of what a robot says."""
_NUMBER: Final = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,3})?\Z", re.ASCII)
_WHOLE: Final = re.compile(r"\d{1,9}\Z", re.ASCII)
_TEXT: Final = re.compile(TEXT_PATTERN)


class Registration(NamedTuple):
    """A client that wants to be served.

    Attributes:
        kind: What it is.
        name: Name of a robot, as it shall be shown.
        number: Place in the start grid, from 1; 0 for any.
        angles: Directions of the obstacle sensors, degrees anticlockwise from ahead.
    """

    kind: Literal["robot", "viewer"]
    name: str = ""
    number: int = 0
    angles: tuple[float, ...] = IR_ANGLES


class Orders(NamedTuple):
    """What a robot shall do; None changes nothing.

    Attributes:
        left, right: Powers of the motors: the travel of a wheel in a cycle, in diameters of the robot.
        end_led, returning_led, visiting_led: Whether the LED is on.
        requests: Sensors whose readings are wanted once, such as `IRSensor0`.
        say: What the robot says.
        unsaid: Why what it says does not count; empty if it does.
    """

    left: float | None = None
    right: float | None = None
    end_led: bool | None = None
    returning_led: bool | None = None
    visiting_led: bool | None = None
    requests: tuple[str, ...] = ()
    say: str | None = None
    unsaid: str = ""


class ViewCommand(NamedTuple):
    """What a viewer wants; `number` is the robot to remove."""

    verb: Literal["lab", "grid", "start", "stop", "remove"]
    number: int = 0


def read_registration(data: bytes) -> Registration:
    """Return a registration.

    Raises:
        WireError: It is none that can be served.
    """
    root = _root(data)
    if root.tag == "View":
        return Registration("viewer")
    if root.tag != "Robot":
        raise WireError("field", f"expected the element Robot or View, got {shown(str(root.tag))}")
    name = root.get("Name")
    if name is None or not 0 < len(name) <= 64:
        raise wrong_value("Robot.Name", "1 to 64 characters", _got(name))
    angles = list(IR_ANGLES)
    for sensor in root:
        if sensor.tag != "IRSensor":
            raise WireError("field", f"Robot: expected elements IRSensor only, got {shown(str(sensor.tag))}")
        index = _whole(sensor, "Id", len(angles) - 1, None)
        angles[index] = _number(sensor, "Angle", 720.0, angles[index])
    return Registration("robot", name, _whole(root, "Id", MAX_ID, 0), tuple(angles))


def read_orders(data: bytes) -> Orders:
    """Return the actions of a robot. An element `Sync`, which agents in step with the simulator add, changes nothing.

    Raises:
        WireError: They are none. Nothing of them counts.
    """
    root = _root(data)
    if root.tag != "Actions":
        raise WireError("field", f"expected the element Actions, got {shown(str(root.tag))}")
    requests: tuple[str, ...] = ()
    say, unsaid = None, ""
    for child in root:
        if child.tag == "SensorRequests":
            requests += tuple(str(name) for name, value in child.attrib.items() if value == "Yes")
        elif child.tag == "Say":
            said = child.text or ""
            # The motors obey all the same, as the simulator does it.
            if len(said) > LONGEST_SAY:
                unsaid = f"Actions.Say: expected at most {LONGEST_SAY} characters, got {len(said)}"
            elif _TEXT.match(said) is None:
                unsaid = f"Actions.Say: expected text without control characters, got {shown(said)}"
            else:
                say = said
        elif child.tag != "Sync":
            raise WireError("field", f"Actions: expected SensorRequests, Say or Sync, got {shown(str(child.tag))}")
    return Orders(
        left=_number(root, "LeftMotor", 1e300, None),
        right=_number(root, "RightMotor", 1e300, None),
        end_led=_led(root, "EndLed"),
        returning_led=_led(root, "ReturningLed"),
        visiting_led=_led(root, "VisitingLed"),
        requests=requests,
        say=say,
        unsaid=unsaid,
    )


def read_command(data: bytes) -> ViewCommand:
    """Return the command of a viewer.

    Raises:
        WireError: It is none.
    """
    root = _root(data)
    if root.tag == "LabReq":
        return ViewCommand("lab")
    if root.tag == "GridReq":
        return ViewCommand("grid")
    if root.tag == "Start":
        return ViewCommand("start")
    if root.tag == "Stop":
        return ViewCommand("stop")
    if root.tag == "Robot" and root.get("Removed") == "Yes":
        return ViewCommand("remove", _whole(root, "Id", MAX_ID, None))
    raise WireError("field", f"expected LabReq, GridReq, Start, Stop or a removed Robot, got {shown(str(root.tag))}")


def _root(data: bytes) -> Any:
    if len(data) > MAX_BYTES:
        raise wrong_value("datagram", f"at most {MAX_BYTES} bytes", len(data), "too-long")
    return elements.parse(data.rstrip(b"\0 \r\n\t"), "datagram")


def _where(element: Any, name: str) -> str:
    return f"{element.tag}.{name}"


def _number(element: Any, name: str, largest: float, absent: Any) -> Any:
    """Return an attribute as a number, or `absent`."""
    text = element.get(name)
    if text is None:
        return absent
    # Python takes more than a number: underscores, infinities, what is not one.
    value = float(text) if _NUMBER.match(text.strip()) and len(text) <= 40 else None
    if value is None or not abs(value) <= largest:
        raise wrong_value(_where(element, name), f"a number in [-{largest:g}, {largest:g}]", shown(text))
    return value


def _whole(element: Any, name: str, largest: int, absent: int | None) -> int:
    text = element.get(name)
    if text is None and absent is not None:
        return absent
    if text is None or not _WHOLE.match(text) or int(text) > largest:
        raise wrong_value(_where(element, name), f"a whole number in [0, {largest}]", _got(text))
    return int(text)


def _led(element: Any, name: str) -> bool | None:
    text = element.get(name)
    return None if text is None else text == "On"


def _got(text: str | None) -> str:
    return "none" if text is None else shown(text)
