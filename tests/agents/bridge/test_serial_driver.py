from __future__ import annotations

import errno
import fcntl
import os
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from intellwheels_agents.bridge.firmware_stand_in import Terminal
from intellwheels_agents.bridge.hardware_driver import Reading
from intellwheels_agents.bridge.line_protocol import (
    LineSplitter,
    PositionFix,
    PowerLine,
    Telemetry,
    decode_line,
    encode_line,
)
from intellwheels_agents.bridge.serial_driver import SerialDriver
from intellwheels_agents.bridge.wrapping_counter import to_signed, to_unsigned
from intellwheels_maps import robot
from intellwheels_schemas.messages import ProximityReading

DEADLINE = 10.0
SONARS = robot("intellwheels").proximity[:3]


class Line:
    """A port at a terminal, and the other end of it."""

    def __init__(self, folder: Path, *, accepted: bool = True) -> None:
        self.terminal = Terminal(folder / "tty")
        self.stop = threading.Event()
        self.waits: list[str] = []
        self.driver = SerialDriver(str(folder / "tty"), 115_200, SONARS, self.stop, self.waits.append)
        self.readings: list[Reading] = []
        self._link = folder / "tty"
        self._seq = 0
        if accepted:
            self.driver.begin_run("a" * 16)
        self.driver.start()

    def link_to(self, name: str) -> None:
        """Make the driver's device that terminal."""
        new = self._link.with_name("new")
        new.symlink_to(name)
        new.replace(self._link)

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
            self.terminal.write(before + encode_line(told))
            self.readings += self.driver.read()
            return len(self.readings) >= want

        self.until(found, what)

    def end(self) -> None:
        self.stop.set()
        self.driver.close()
        self.terminal.unplug()


@pytest.fixture
def line(tmp_path: Path) -> Iterator[Line]:
    made = Line(tmp_path)
    yield made
    made.end()


def test_telemetry_becomes_readings_in_metres_and_volts(line: Line) -> None:
    line.told(2)
    assert line.driver.connected.is_set()
    first = line.readings[0]
    assert (first.epoch, first.left - first.seq, first.right) == ("4", 100, -5)
    assert first.stamp == pytest.approx(0.02 * first.seq)
    assert (first.battery, first.forward, first.turn) == (24.8, 0.5, -0.25)
    assert first.proximity == (
        ProximityReading(id=SONARS[0].id, value=1.25),
        ProximityReading(id=SONARS[1].id, status="none"),
        ProximityReading(id=SONARS[2].id, status="fault"),
    )


def readings_of(line: Line, epoch: str, count: int) -> list[Reading]:
    """Wait for so many readings of an epoch."""
    found: list[Reading] = []

    def is_done() -> bool:
        found.extend(one for one in line.driver.read() if one.epoch == epoch)
        return len(found) >= count

    line.until(is_done, f"{count} readings of epoch {epoch}")
    return found


@pytest.mark.parametrize("direction", [1, -1])
def test_counters_that_wrap_give_readings_that_do_not(line: Line, direction: int) -> None:
    line.told(1)
    for step in range(6):
        count = direction * (100 * step - 250)  # every counter wraps on the way
        left, right = to_signed(2**31 + count), to_signed(2**31 - count)
        telemetry = Telemetry(9, to_unsigned(step - 3), to_unsigned(20 * step - 45), left, right, 24_800, None, ())
        line.terminal.write(encode_line(telemetry))
    readings = readings_of(line, "9", 6)
    first = readings[0]
    assert [one.seq - first.seq for one in readings] == list(range(6))
    assert [one.stamp - first.stamp for one in readings] == pytest.approx([0.02 * step for step in range(6)])
    assert [one.left - first.left for one in readings] == [direction * 100 * step for step in range(6)]
    assert [one.right - first.right for one in readings] == [-direction * 100 * step for step in range(6)]


def test_a_restarted_controller_starts_its_counters_again(line: Line) -> None:
    line.told(1)
    line.terminal.write(encode_line(Telemetry(5, 2**32 - 1, 2**32 - 1, 2**31 - 1, 0, 24_800, None, ())))
    line.terminal.write(encode_line(Telemetry(6, 0, 0, 0, 0, 24_800, None, ())))
    (reading,) = readings_of(line, "6", 1)
    assert (reading.seq, reading.left, reading.stamp) == (0, 0, 0.0)


def test_a_position_comes_with_the_next_telemetry(line: Line) -> None:
    line.told(1)
    line.told(3, before=encode_line(PositionFix(4, 1, 4000, -1500, 50)))
    fix = line.readings[-1].fix
    assert fix is not None
    assert (fix.x, fix.y, fix.sd) == (4.0, -1.5, 0.05)


def test_garbage_is_counted_and_loses_only_its_own_line(line: Line) -> None:
    line.told(1)
    line.told(6, before=b"\xff\x00garbage*1234\n")
    assert line.driver.faults()["garbage"] >= 4


def test_powers_are_sent_as_lines(line: Line) -> None:
    line.told(1)
    line.driver.write(0.5, -1.0)
    splitter, got = LineSplitter(), []

    def found() -> bool:
        got.extend(splitter.feed(line.terminal.read()))
        return bool(got)

    line.until(found, "a power")
    assert decode_line(got[0]) == PowerLine(500, -1000)


def test_a_lost_line_is_opened_again(line: Line) -> None:
    line.told(1)
    line.terminal.unplug()
    line.driver.write(0.5, 0.5)
    line.terminal.plug()
    line.until(lambda: line.driver.faults()["reopened"] == 1, "the line opened again")
    line.told(1, "a reading on the new line")


def test_the_last_power_written_is_zero(line: Line) -> None:
    line.told(1)
    line.driver.write(0.5, 0.5)
    line.stop.set()
    line.driver.close()
    splitter = LineSplitter()
    told: list[object] = []

    def found() -> bool:
        told.extend(decode_line(one) for one in splitter.feed(line.terminal.read()))
        return len(told) >= 2

    line.until(found, "two powers")
    assert told == [PowerLine(500, 500), PowerLine(0, 0)]


def test_writing_while_the_line_is_lost_raises_nothing(line: Line) -> None:
    """Seen: pyserial closed under the writer's hands raises errors of Python's, not of a line."""
    for _ in range(3):
        line.told(1)
        line.terminal.unplug()
        until = time.monotonic() + 0.3
        while time.monotonic() < until:
            line.driver.write(0.5, 0.5)
        line.terminal.plug()


def test_without_a_line_writing_does_nothing(tmp_path: Path) -> None:
    stop = threading.Event()
    driver = SerialDriver(str(tmp_path / "nowhere"), 115_200, SONARS, stop)
    driver.start()
    driver.write(0.5, 0.5)
    assert driver.read() == []
    stop.set()
    driver.close()


def test_nothing_is_written_before_the_simulator_has_accepted_the_bridge(tmp_path: Path) -> None:
    line = Line(tmp_path, accepted=False)
    try:
        line.told(1)
        line.driver.write(0.5, 0.5)
        line.stop.set()
        line.driver.close()
        assert line.terminal.read() == b""
    finally:
        line.end()


def test_a_device_in_use_is_refused_and_its_user_is_not_disturbed(line: Line, tmp_path: Path) -> None:
    line.told(1)
    stop = threading.Event()
    second = SerialDriver(str(tmp_path / "tty"), 115_200, SONARS, stop)
    second.begin_run("b" * 16)
    second.start()
    assert stop.wait(DEADLINE)
    second.write(1.0, 1.0)
    second.close()
    assert second.failure == f"{tmp_path / 'tty'} is in use by another program, perhaps by another iw-bridge"
    assert line.terminal.read() == b""
    line.told(2, "readings after the refusal")
    line.driver.write(0.5, -1.0)
    line.until(lambda: line.terminal.read() == encode_line(PowerLine(500, -1000)), "the first driver's power")


def test_a_line_that_another_program_takes_when_it_is_back_is_waited_for(line: Line) -> None:
    """As ModemManager does, which probes each new device for some seconds."""
    line.told(1)
    line.terminal.unplug()
    taken = Terminal(None)
    with Path(taken.name).open("rb+", buffering=0) as other:
        fcntl.flock(other, fcntl.LOCK_EX)
        # The new line is taken before the driver's link points at it.
        line.link_to(taken.name)
        line.until(lambda: line.waits and os.strerror(errno.EAGAIN) in line.waits[-1], "the wait for the line")
    line.terminal, unplugged = taken, line.terminal
    line.told(1, "a reading on the released line")
    unplugged.unplug()
    assert line.driver.failure is None
    assert line.driver.failure is None


def test_a_missing_device_is_reported_once_and_at_once(tmp_path: Path) -> None:
    stop, waits, port = threading.Event(), list[str](), str(tmp_path / "nowhere")

    def on_wait(reason: str) -> None:
        waits.append(reason)
        stop.set()

    driver = SerialDriver(port, 115_200, SONARS, stop, on_wait)
    driver.start()
    assert stop.wait(DEADLINE)
    driver.close()
    assert waits == [f"cannot open {port}: No such file or directory"]


def test_an_open_line_without_telemetry_is_reported_once(line: Line) -> None:
    line.until(lambda: line.waits, "the report")
    line.terminal.write(b"garbage\n" * 3)
    line.told(1)
    assert len(line.waits) == 1
    assert line.waits[0].endswith("is open, but no valid telemetry comes; check controller and --baud")


def test_a_url_that_pyserial_does_not_know_is_refused() -> None:
    stop = threading.Event()
    driver = SerialDriver("ftp://chair", 115_200, SONARS, stop)
    driver.start()
    assert stop.wait(DEADLINE)
    assert driver.failure is not None
    assert driver.failure.startswith("--port: expected a device or a pyserial URL, got 'ftp://chair'")
