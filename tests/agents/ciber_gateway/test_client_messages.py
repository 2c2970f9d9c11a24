"""What clients send: registrations, actions, commands, and what is refused."""

from __future__ import annotations

import contextlib
import random

import pytest

from intellwheels_agents.ciber_gateway.client_messages import (
    IR_ANGLES,
    MAX_BYTES,
    Orders,
    Registration,
    ViewCommand,
    read_command,
    read_orders,
    read_registration,
)
from intellwheels_schemas.errors import WireError
from tests.every_case import every_case

BOMB = b'<!DOCTYPE a [<!ENTITY b "ha"><!ENTITY c "&b;&b;&b;&b;">]><Actions LeftMotor="&c;"/>'


@pytest.mark.parametrize(("data", "expected"), [
    (b'<Robot Id="3" Name="R2" />', Registration("robot", "R2", 3)),
    (b'<Robot Name="R2" Id="0"></Robot>\0', Registration("robot", "R2", 0)),
    (b'<Robot Name="a b"><IRSensor Id="2" Angle="-45.5"/></Robot>\n\0',
     Registration("robot", "a b", 0, (*IR_ANGLES[:2], -45.5, IR_ANGLES[3]))),
    (b"<View/>\n", Registration("viewer")),
])  # fmt: skip
def test_registrations(data: bytes, expected: Registration) -> None:
    assert read_registration(data) == expected


@every_case(("data", "text"), [
    (b"", "datagram: expected well-formed XML"),
    (b'<Robot Name="R2"', "datagram: expected well-formed XML"),
    (b"<Robot/>", "Robot.Name: expected 1 to 64 characters, got none"),
    (b'<Robot Name="R" Id="-1"/>', r"Robot.Id: expected a whole number in \[0, 1000\], got '-1'"),
    (b'<Robot Name="R" Id="99999999999"/>', "Robot.Id: expected a whole number"),
    (b'<Robot Name="R"><IRSensor Id="4" Angle="0"/></Robot>', r"IRSensor.Id: expected a whole number in \[0, 3\]"),
    (b'<Robot Name="R"><IRSensor Angle="0"/></Robot>', "IRSensor.Id: expected a whole number .*, got none"),
    (b'<Robot Name="R"><IRSensor Id="1" Angle="nan"/></Robot>', "IRSensor.Angle: expected a number"),
    (b'<Robot Name="R"><Wheel/></Robot>', "expected elements IRSensor only, got 'Wheel'"),
    (b"<Panel/>", "expected the element Robot or View, got 'Panel'"),
    (BOMB, "expected XML without a document type"),
    (b"<Robot" + b" " * MAX_BYTES + b"/>", "datagram: expected at most 4096 bytes, got 4104"),
])  # fmt: skip
def test_wrong_registrations_are_refused_in_words(data: bytes, text: str) -> None:
    with pytest.raises(WireError, match=text):
        read_registration(data)


@pytest.mark.parametrize(("data", "expected"), [
    (b'<Actions LeftMotor="0.1" RightMotor="-1e-05"/>', Orders(left=0.1, right=-1e-5)),
    (b'<Actions LeftMotor=".5" RightMotor="7."/>\0', Orders(left=0.5, right=7.0)),
    (b'<Actions EndLed="On" ReturningLed="Off" VisitingLed="on"/>', Orders(None, None, True, False, False)),
    (b'<Actions><SensorRequests IRSensor0="Yes" Compass="No" Beacon0="Yes"/><Say><![CDATA[a<b]]></Say></Actions>',
     Orders(requests=("IRSensor0", "Beacon0"), say="a<b")),
    (b"<Actions/>", Orders()),
    (b'<Actions LeftMotor="0.1"><Sync Sync="Yes"/></Actions>', Orders(left=0.1)),
])  # fmt: skip
def test_actions(data: bytes, expected: Orders) -> None:
    assert read_orders(data) == expected


@pytest.mark.parametrize(("said", "text"), [
    (b"x" * 101, "Actions.Say: expected at most 100 characters, got 101"),
    (b"a&#13;b", "Actions.Say: expected text without control characters, got "),
])  # fmt: skip
def test_what_cannot_be_said_leaves_the_powers(said: bytes, text: str) -> None:
    orders = read_orders(b'<Actions LeftMotor="0.1"><Say>' + said + b"</Say></Actions>")
    assert (orders.left, orders.say) == (0.1, None)
    assert orders.unsaid.startswith(text)


@pytest.mark.parametrize(("data", "text"), [
    (b'<Actions LeftMotor="fast"/>', r"Actions.LeftMotor: expected a number in .*, got 'fast'"),
    (b'<Actions LeftMotor="inf"/>', "Actions.LeftMotor: expected a number"),
    (b'<Actions LeftMotor="1_0"/>', "Actions.LeftMotor: expected a number"),
    (b'<Actions LeftMotor="1e999"/>', "Actions.LeftMotor: expected a number"),
    (b"<Actions><Fly/></Actions>", "Actions: expected SensorRequests, Say or Sync, got 'Fly'"),
    (b'<Robot Id="1"/>', "expected the element Actions, got 'Robot'"),
    (BOMB, "expected XML without a document type"),
])  # fmt: skip
def test_wrong_actions_are_refused_in_words(data: bytes, text: str) -> None:
    with pytest.raises(WireError, match=text):
        read_orders(data)


@pytest.mark.parametrize(("data", "expected"), [
    (b"<LabReq/>\0", ViewCommand("lab")), (b"<GridReq/>\0", ViewCommand("grid")), (b"<Start/>", ViewCommand("start")),
    (b"<Stop/>\0", ViewCommand("stop")), (b'<Robot Id="2" Removed="Yes"/>', ViewCommand("remove", 2)),
])  # fmt: skip
def test_commands(data: bytes, expected: ViewCommand) -> None:
    assert read_command(data) == expected


def test_wrong_commands_are_refused() -> None:
    for data in (b'<Robot Id="2"/>', b'<Robot Removed="Yes"/>', b"<Quit/>", b"\xff\xfe"):
        with pytest.raises(WireError):
            read_command(data)


def test_no_bytes_raise_anything_else() -> None:
    generator = random.Random(5)
    good = b'<Actions LeftMotor="0.1"><Say><![CDATA[x]]></Say><SensorRequests GPS="Yes"/></Actions>'
    for _ in range(400):
        data = bytearray(good)
        for _ in range(generator.randint(1, 4)):
            data[generator.randrange(len(data))] = generator.randrange(256)
        for read in (read_registration, read_orders, read_command):
            with contextlib.suppress(WireError):
                read(bytes(data[: generator.randint(0, len(data))]))
