"""Every driver has what a bridge asks of one, and a reading says no more than was measured."""

from __future__ import annotations

import inspect
import threading

from intellwheels_agents.bridge.hardware_driver import Driver, Fix, Reading, RealHardware
from intellwheels_agents.bridge.luci_driver import LuciDriver
from intellwheels_agents.bridge.rnet_driver import RnetDriver
from intellwheels_agents.bridge.serial_driver import SerialDriver
from intellwheels_agents.bridge.world_driver import WorldDriver
from tests.every_case import every_case

ASKED = [name for name, _ in inspect.getmembers(Driver, inspect.isfunction) if not name.startswith("_")]


@every_case("driver", [WorldDriver, SerialDriver, LuciDriver, RnetDriver])
@every_case("method", ASKED)
def test_a_driver_takes_what_the_bridge_gives_it(driver: type, method: str) -> None:
    wanted = inspect.signature(getattr(Driver, method)).parameters.values()
    offered = inspect.signature(getattr(driver, method)).parameters.values()
    assert [(one.name, one.kind) for one in offered] == [(one.name, one.kind) for one in wanted]


def test_what_was_not_measured_is_none() -> None:
    reading = Reading(epoch="1", seq=0, stamp=0.0, received=0.0, left=0, right=0)
    assert (reading.tick, reading.proximity, reading.fix) == (None, (), None)
    assert (reading.battery, reading.forward, reading.turn, reading.motion) == (None, None, None, None)


def test_a_position_without_an_offset_is_that_of_the_centre_of_movement() -> None:
    fix = Fix(1.0, 2.0, 0.1)
    assert (fix.offset_x, fix.offset_y) == (0.0, 0.0)


class Waiting(RealHardware):
    """Hardware that a test plays."""

    def __init__(self, stop: threading.Event, told: list[str]) -> None:
        super().__init__(stop, told.append, most_readings=2)

    def arrive(self, *numbers: int) -> None:
        """Let readings arrive."""
        self._readings.extend(Reading(epoch="1", seq=seq, stamp=0.0, received=0.0, left=0, right=0) for seq in numbers)
        self._reason = ""

    def wait_for(self, *reasons: str) -> None:
        """Wait for something."""
        for reason in reasons:
            self._wait_for(reason)

    def fail(self, reason: str) -> None:
        """Give up."""
        self._fail(reason)


def test_the_newest_readings_are_read_once() -> None:
    hardware = Waiting(threading.Event(), [])
    hardware.arrive(1, 2, 3)
    assert [reading.seq for reading in hardware.read()] == [2, 3]
    assert hardware.read() == []


def test_what_is_waited_for_is_told_once_until_it_has_come() -> None:
    told: list[str] = []
    hardware = Waiting(threading.Event(), told)
    hardware.wait_for("a line", "a line", "telemetry")
    hardware.arrive(1)
    hardware.wait_for("telemetry")
    assert told == ["a line", "telemetry", "telemetry"]


def test_who_gives_up_says_why_and_ends_the_bridge() -> None:
    stop = threading.Event()
    hardware = Waiting(stop, [])
    hardware.fail("in use")
    assert hardware.failure == "in use"
    assert stop.is_set()
