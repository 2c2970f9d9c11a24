"""An agent and a viewer of the Ciber-Rato simulator, written from its public description, without the gateway's code.

The agent behaves as the public client libraries do: it registers at one port, sends everything else to the port that
the reply came from, cuts the last byte of each datagram, reads at most 1024 bytes of the reply and 4096 of measures,
and fails on XML that is not as it expects.
"""

from __future__ import annotations

import socket
from dataclasses import dataclass, field
from xml.etree import ElementTree

TIMEOUT = 25.0

LAB = b"""<Lab Name="Small Lab" Height="8" Width="12">
  <Beacon X="10" Y="6" Height="2"/>
  <Target X="10" Y="6" Radius="1.5"/>
  <Wall Height="3"><Corner X="5" Y="0"/><Corner X="5.5" Y="0"/><Corner X="5.5" Y="5"/><Corner X="5" Y="5"/></Wall>
  <Wall Height="1"><Corner X="7" Y="7"/><Corner X="7.5" Y="7"/><Corner X="7.5" Y="8"/><Corner X="7" Y="8"/></Wall>
</Lab>
"""
GRID = b'<Grid><Position X="2" Y="2" Dir="0"/><Position X="2" Y="6" Dir="0"/><Position X="2" Y="4" Dir="90"/></Grid>'


@dataclass
class Sensed:
    """Measures, as an agent keeps them."""

    time: int
    obstacles: dict[int, float] = field(default_factory=dict)
    compass: float | None = None
    ground: int | None = None
    collision: bool | None = None
    beacons: dict[int, float | None] = field(default_factory=dict)
    gps: tuple[float, float] | None = None
    heard: list[tuple[int, str]] = field(default_factory=list)
    leds: dict[str, bool] = field(default_factory=dict)
    start: bool = False
    stop: bool = False


def cut(data: bytes) -> ElementTree.Element:
    assert data[-1:] == b"\0"
    return ElementTree.fromstring(data[:-1])


class Agent:
    """One agent."""

    def __init__(self, name: str, number: int, port: int, angles: list[float] | None = None) -> None:
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.settimeout(TIMEOUT)
        text = f'<Robot Id="{number}" Name="{name}">'
        text += "".join(f'<IRSensor Id="{i}" Angle="{angle}" />' for i, angle in enumerate(angles or []))
        self.socket.sendto(f"{text}</Robot>".encode(), ("127.0.0.1", port))
        data, self.address = self.socket.recvfrom(1024)
        assert self.address[1] != port or b"Refused" in data
        reply = cut(data)
        assert reply.tag == "Reply"
        self.accepted = reply.attrib["Status"] == "Ok"
        found = reply.find("Parameters")
        self.parameters = {} if found is None else dict(found.attrib)

    def read(self) -> Sensed:
        """Wait for measures."""
        root = cut(self.socket.recvfrom(4096)[0])
        assert root.tag == "Measures"
        sensed = Sensed(int(root.attrib["Time"]))
        sensors = root.find("Sensors")
        assert sensors is not None
        if "Compass" in sensors.attrib:
            sensed.compass = float(sensors.attrib["Compass"])
        if "Collision" in sensors.attrib:
            sensed.collision = sensors.attrib["Collision"] == "Yes"
        if "Ground" in sensors.attrib:
            sensed.ground = int(sensors.attrib["Ground"])
        for element in sensors:
            attributes = element.attrib
            if element.tag == "IRSensor":
                sensed.obstacles[int(attributes["Id"])] = float(attributes["Value"])
            elif element.tag == "BeaconSensor":
                value = attributes["Value"]
                sensed.beacons[int(attributes["Id"])] = None if value == "NotVisible" else float(value)
            elif element.tag == "GPS":
                sensed.gps = float(attributes["X"]), float(attributes["Y"])
            elif element.tag == "Message":
                sensed.heard.append((int(attributes["From"]), element.text or ""))
        leds, buttons = root.find("Leds"), root.find("Buttons")
        assert leds is not None
        assert buttons is not None
        sensed.leds = {name: leds.attrib[name] == "On" for name in ("EndLed", "ReturningLed", "VisitingLed")}
        sensed.start, sensed.stop = buttons.attrib["Start"] == "On", buttons.attrib["Stop"] == "On"
        return sensed

    def send(self, text: str | bytes) -> None:
        """Send a datagram."""
        self.socket.sendto(text if isinstance(text, bytes) else text.encode(), self.address)

    def drive(self, left: float, right: float) -> None:
        """Set the powers of the motors."""
        self.send(f'<Actions LeftMotor="{left}" RightMotor="{right}"/>')

    def close(self) -> None:
        """End, as agents do: without a word."""
        self.socket.close()


class Viewer:
    """A viewer: it registers, asks for the lab and the grid, and keeps what it sees of each robot."""

    def __init__(self, port: int) -> None:
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.settimeout(TIMEOUT)
        self.socket.sendto(b"<View/>\n", ("127.0.0.1", port))
        data, self.address = self.socket.recvfrom(65_535)
        assert cut(data).attrib["Status"] == "Ok"
        self.lab: ElementTree.Element | None = None
        self.grid: ElementTree.Element | None = None
        self.robots: dict[int, dict[str, str]] = {}
        self.restarts = 0
        # The public viewer ends these with a zero byte.
        self.send(b"<LabReq/>\0")
        self.send(b"<GridReq/>\0")

    def send(self, data: bytes) -> None:
        """Send a command."""
        self.socket.sendto(data, self.address)

    def read(self) -> str:
        """Wait for a message, and return what it is."""
        root = cut(self.socket.recvfrom(65_535)[0])
        if root.tag == "Lab":
            self.lab = root
        elif root.tag == "Grid":
            self.grid = root
        elif root.tag == "Robot":
            position = root.find("Position")
            assert position is not None
            self.robots[int(root.attrib["Id"])] = {**root.attrib, **position.attrib}
        return root.tag

    def close(self) -> None:
        """End."""
        self.socket.close()
