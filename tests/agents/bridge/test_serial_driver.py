from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from intellwheels_agents.bridge.firmware_stand_in import Terminal
from intellwheels_agents.bridge.hardware_driver import Reading
from intellwheels_agents.bridge.line_protocol import Located, PowerLine, Splitter, Telemetry, read, written
from intellwheels_agents.bridge.serial_driver import SerialDriver
from intellwheels_maps import robot
from intellwheels_schemas.messages import ProximityReading

DEADLINE = 10.0
SONARS = robot("intellwheels").proximity[:3]


class Line:
    """A port at a terminal, and the other end of it."""

    def __init__(self, folder: Path) -> None:
        self.terminal = Terminal(folder / "tty")
        self.stop = threading.Event()
        self.port = SerialDriver(str(folder / "tty"), 115_200, SONARS, self.stop)
        self.readings: list[Reading] = []
        self._seq = 0
        self.port.start()

    def until(self, found: Callable[[], object], what: str) -> None:
        deadline = time.monotonic() + DEADLINE
        while not found():
            assert time.monotonic() < deadline, what
            # Its thread does the work; this is a slice of a wait with a deadline.
            self.stop.wait(0.005)

    def told(self, count: int, what: str = "a reading", before: bytes = b"") -> None:
        """Say telemetry until so many readings more are here: what is said before the line is open is lost."""
        want = len(self.readings) + count

        def found() -> bool:
            self._seq += 1
            told = Telemetry(4, self._seq, 20 * self._seq, 100 + self._seq, -5, 24_800, (500, -250), (1250, "n", "f"))
            self.terminal.write(before + written(told))
            self.readings += self.port.read()
            return len(self.readings) >= want

        self.until(found, what)

    def end(self) -> None:
        self.stop.set()
        self.port.close()
        self.terminal.unplug()


@pytest.fixture
def line(tmp_path: Path) -> Iterator[Line]:
    made = Line(tmp_path)
    yield made
    made.end()


def test_telemetry_becomes_readings_in_metres_and_volts(line: Line) -> None:
    line.told(2)
    assert line.port.heard.is_set()
    first = line.readings[0]
    assert (first.era, first.left - first.seq, first.right) == ("4", 100, -5)
    assert first.taken == pytest.approx(0.02 * first.seq)
    assert (first.battery, first.forward, first.turn) == (24.8, 0.5, -0.25)
    assert first.proximity == (
        ProximityReading(id=SONARS[0].id, value=1.25),
        ProximityReading(id=SONARS[1].id, status="none"),
        ProximityReading(id=SONARS[2].id, status="fault"),
    )


def test_a_position_comes_with_the_next_telemetry(line: Line) -> None:
    line.told(1)
    line.told(3, before=written(Located(4, 1, 4000, -1500, 50)))
    fix = line.readings[-1].fix
    assert fix is not None
    assert (fix.x, fix.y, fix.sd) == (4.0, -1.5, 0.05)


def test_garbage_is_counted_and_costs_its_own_line_only(line: Line) -> None:
    line.told(1)
    line.told(6, before=b"\xff\x00garbage*1234\n")
    assert line.port.faults()["garbage"] >= 4


def test_powers_go_out_as_lines(line: Line) -> None:
    line.told(1)
    line.port.write(0.5, -1.0)
    splitter, got = Splitter(), []

    def found() -> bool:
        got.extend(splitter.feed(line.terminal.read()))
        return bool(got)

    line.until(found, "a power")
    assert read(got[0]) == PowerLine(500, -1000)


def test_a_line_that_is_gone_is_opened_again(line: Line) -> None:
    line.told(1)
    line.terminal.unplug()
    line.port.write(0.5, 0.5)
    line.terminal.plug()
    line.told(1, "a reading on the new line")
    assert line.port.faults()["reopened"] == 1


def test_its_last_word_is_zero(line: Line) -> None:
    line.told(1)
    line.port.write(0.5, 0.5)
    line.stop.set()
    line.port.close()
    splitter = Splitter()
    told: list[object] = []

    def found() -> bool:
        told.extend(read(one) for one in splitter.feed(line.terminal.read()))
        return len(told) >= 2

    line.until(found, "two powers")
    assert told == [PowerLine(500, 500), PowerLine(0, 0)]


def test_writing_to_a_line_that_breaks_breaks_nothing(line: Line) -> None:
    """Seen: pyserial closed under the writer's hands raises errors of Python's, not of a line."""
    for _ in range(3):
        line.told(1)
        line.terminal.unplug()
        until = time.monotonic() + 0.3
        while time.monotonic() < until:
            line.port.write(0.5, 0.5)
        line.terminal.plug()


def test_without_a_line_nothing_is_told_and_nothing_breaks(tmp_path: Path) -> None:
    stop = threading.Event()
    port = SerialDriver(str(tmp_path / "nowhere"), 115_200, SONARS, stop)
    port.start()
    port.write(0.5, 0.5)
    assert port.read() == []
    stop.set()
    port.close()
