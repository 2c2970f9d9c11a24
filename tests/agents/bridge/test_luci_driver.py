from __future__ import annotations

import contextlib
import math
import os
import socket
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace

import msgspec
import pytest

from intellwheels_agents.bridge.hardware_driver import Reading
from intellwheels_agents.bridge.luci_driver import LuciDriver
from intellwheels_agents.bridge.luci_schema import AUTONOMOUS_REMOTE, message
from intellwheels_agents.bridge.luci_stand_in import LuciChair, serve
from intellwheels_maps import robot
from intellwheels_schemas import process
from intellwheels_schemas.errors import WireError

pytestmark = pytest.mark.process

DEADLINE = 60.0
CHAIR = msgspec.structs.replace(robot("intellwheels"), proximity=robot("intellwheels").proximity[:1])
WHEEL, TOP = CHAIR.wheel_diameter, CHAIR.top_speed


class Line:
    """A driver at a stand-in's service, both in this process. The stand-in's time passes in the waits of a test."""

    def __init__(self, *, accepted: bool = True) -> None:
        self.luci = LuciChair(WHEEL, TOP)
        self.stop = threading.Event()
        self.waits: list[str] = []
        self.told: list[str] = []
        self.lines: list[str] = []
        self.readings: list[Reading] = []
        self._ended = threading.Event()
        self._server, port = serve(self.luci, "127.0.0.1:0", self._ended)
        self.address, self.port = f"127.0.0.1:{port}", port
        self.driver = self.another()
        self._last = time.monotonic()
        if accepted:
            self.driver.begin_run("a" * 16)
        self.driver.start()

    def another(self) -> LuciDriver:
        return LuciDriver(self.address, CHAIR, self.stop, waiting=self.waits.append, tell=self.told.append)

    def until(self, found: Callable[[], object], what: str, power: tuple[float, float] | None = None) -> None:
        """Let time pass, and write a power, until something is so."""
        deadline = time.monotonic() + DEADLINE
        while not found():
            assert time.monotonic() < deadline, (what, self.waits, self.told, self.lines)
            if power is not None:
                self.driver.write(*power)
            # Threads do the work; this is a slice of a wait with a deadline.
            self.stop.wait(0.01)
            now = time.monotonic()
            self.lines += self.luci.step(min(now - self._last, 0.02))
            self._last = now
            self.readings += self.driver.read()

    def until_read(self, count: int = 1, power: tuple[float, float] | None = None) -> Reading:
        want = len(self.readings) + count
        self.until(lambda: len(self.readings) >= want, "a reading", power)
        return self.readings[-1]

    def until_said(self, word: str, power: tuple[float, float] | None = None) -> None:
        """Wait for a line that begins with a word, after those that came before."""
        before = len(self.lines)
        self.until(lambda: any(line.startswith(word) for line in self.lines[before:]), word, power)

    def vanish(self) -> None:
        self._ended.set()
        self._server.stop(grace=0).wait(DEADLINE)

    def return_(self) -> None:
        self._ended = threading.Event()
        self._server, _ = serve(self.luci, self.address, self._ended)

    def end(self) -> None:
        self.stop.set()
        self.driver.close()
        self.vanish()


@pytest.fixture
def line() -> Iterator[Line]:
    made = Line()
    yield made
    made.end()


def test_streams_become_readings_and_powers_become_overrides(line: Line) -> None:
    line.luci.command("wall 2.696")
    line.luci.command("stick 50 20")
    first = line.until_read()
    assert line.driver.connected.is_set()
    line.until(lambda: line.luci.chair.stick == (0.4, -0.1), "the override", (0.5, 0.3))

    def is_complete() -> bool:
        last = line.readings[-1]
        return (last.forward, last.turn, last.motion) == (0.5, 0.2, (0.0, 0.0, 0.0)) and last.left > first.left + 20

    line.until(is_complete, "all streams", (0.5, 0.3))
    last = line.readings[-1]
    assert last.proximity[0].value == pytest.approx(2.696 - CHAIR.proximity[0].x, abs=0.01)
    assert last.right < last.left
    assert {one.epoch for one in line.readings} == {first.epoch}
    assert [one.seq for one in line.readings] == list(range(1, len(line.readings) + 1))
    line.until_said("stopped", (0.0, 0.0))
    assert line.driver.faults()["garbage"] == 0


def test_without_another_power_the_driver_itself_sends_the_centre(line: Line) -> None:
    line.until_read()
    line.until_said("moving", (0.5, 0.5))
    # The bridge's writer has died; the connection works.
    line.until_said("stopped")
    assert line.luci.chair.stick == (0.0, 0.0)


def test_nothing_is_sent_before_the_simulator_has_accepted_the_bridge() -> None:
    line = Line(accepted=False)
    try:
        line.until_read(30, (0.5, 0.5))
        line.stop.set()
        line.driver.close()
        line.lines += line.luci.step(0.01)
        assert line.lines == []
    finally:
        line.end()


def test_at_the_end_the_user_s_joystick_steers_again(line: Line) -> None:
    line.until_read()
    line.until_said("moving", (0.5, 0.5))
    line.stop.set()
    line.driver.close()
    line.lines += line.luci.step(0.001)
    assert line.lines[-1] == "source removed=1"
    assert line.luci.chair.stick == (0.0, 0.0)


def test_a_unit_that_vanishes_and_returns_is_found_again(line: Line) -> None:
    line.until_read()
    line.until_said("moving", (0.5, 0.5))
    epoch = line.readings[-1].epoch
    line.vanish()
    # Longer than half a turn of a wheel at top speed takes.
    back = line.luci.chair.clock + 0.5 * math.pi * WHEEL / TOP + 0.1
    line.until(lambda: f"nobody answers at {line.address}" in line.waits, "the wait", (0.5, 0.5))
    line.until(lambda: line.luci.chair.stick == (0.0, 0.0), "the stop by the unit's own watchdog", (0.5, 0.5))
    line.until(lambda: line.luci.chair.clock > back, "the gap", (0.5, 0.5))
    line.return_()
    line.until_read(3, (0.5, 0.5))
    line.until(lambda: line.luci.chair.stick != (0.0, 0.0), "the chair's motion", (0.5, 0.5))
    assert line.readings[-1].epoch != epoch  # nobody knows how far it has rolled
    assert line.driver.faults()["reopened"] == 1
    assert line.driver.failure is None


def test_hostile_messages_are_named_once_and_the_next_good_one_is_read(line: Line) -> None:
    line.until_read()
    texts = {
        "garbage": "EncoderData: expected a protobuf message of this kind, got 3 bytes that are none",
        "huge": "EncoderData: expected a message of at most 262144 bytes",
    }
    for fault, text in texts.items():
        line.luci.command(f"{fault} 0.1")
        line.until(lambda text=text: any(one.startswith(text) for one in line.told), "the name")  # type: ignore[misc]
        line.until(lambda fault=fault: not line.luci.has(fault), "the end of the fault")  # type: ignore[misc]
        line.until_read(3)
    assert sum(one.startswith("EncoderData") for one in line.told) == 2
    assert line.driver.failure is None


def test_a_restarted_encoder_board_begins_an_epoch(line: Line) -> None:
    first = line.until_read(5)
    line.luci.command("edge")
    line.until(lambda: line.readings[-1].epoch != first.epoch, "the epoch")
    assert line.readings[-1].stamp < first.stamp + 1.0


def test_a_joystick_with_another_centre_is_found_and_the_chair_let_go(line: Line) -> None:
    line.until_read()
    line.luci.command("centre 0")
    line.until(line.stop.is_set, "the failure", (0.0, 0.0))
    line.driver.close()
    line.lines += line.luci.step(0.01)
    assert line.driver.failure is not None
    assert "which this bridge did not send" in line.driver.failure
    assert line.lines[-1] == "source removed=1"


def test_a_unit_that_refuses_the_bridge_is_told_once() -> None:
    line = Line(accepted=False)

    def refused(source: int) -> None:
        del source
        raise PermissionError("another one steers")

    try:
        line.luci.add_source = refused  # type: ignore[method-assign]
        line.driver.begin_run("a" * 16)
        line.until(lambda: line.told, "the refusal")
        line.until_read(10, (0.5, 0.5))
        (told,) = line.told
        assert told.startswith("AddInputSource: expected the unit to accept it, got unknown: ")
        assert "another one steers" in told
        assert line.lines == []
    finally:
        line.end()


def test_overrides_of_a_broken_connection_do_not_arrive_late(line: Line) -> None:
    line.until_read()
    limits = []
    for path in list(Path("/proc/self/fd").iterdir()):
        if not path.is_socket():
            continue
        with contextlib.suppress(OSError), socket.socket(fileno=os.dup(int(path.name))) as one:
            if one.getpeername()[1:2] == (line.port,):
                limits.append(one.getsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT))
    assert limits == [1000]


def test_python_waits_for_the_threads_that_use_grpc(line: Line) -> None:
    line.until_read()
    waited = {thread.name for thread in process._network_threads if thread.is_alive()}
    assert {"luci", "EncoderStream", "ActiveScalingStream", "overrides"} <= waited


@pytest.mark.parametrize(
    "wrong",
    [
        pytest.param([(361.0, 100.0)] * 2, id="out-of-range"),
        pytest.param([(0.0, 105.0), (0.0, 112.0)], id="magnet"),
    ],
)
def test_after_wrong_angles_the_way_in_between_is_unknown(wrong: list[tuple[float, float]]) -> None:
    driver = LuciDriver("127.0.0.1:1", CHAIR, threading.Event())
    edge = 1000
    for left, right in [(100.0, 100.0), *wrong, (80.0, 130.0)]:
        with contextlib.suppress(WireError):
            driver._on_encoders(message("EncoderData", left_angle=left, right_angle=right, edge_timestamp=edge))
        # Two of them last longer than half a turn of a wheel at top speed; a lost magnet needs no such silence.
        edge += 20 if wrong[0][0] == 0.0 else 500
    first, *_, last = driver.read()
    assert first.epoch != last.epoch


def test_a_single_wrong_angle_loses_no_way() -> None:
    driver = LuciDriver("127.0.0.1:1", CHAIR, threading.Event())
    for edge, angle in ((1000, 100.0), (1020, 361.0), (1040, 110.0)):
        with contextlib.suppress(WireError):
            driver._on_encoders(message("EncoderData", left_angle=angle, right_angle=angle, edge_timestamp=edge))
    first, last = driver.read()
    assert first.epoch == last.epoch
    assert last.left - first.left == round(CHAIR.encoder_ticks * 10.0 / 360.0)


def test_a_chair_that_drives_out_of_range_is_let_go(monkeypatch: pytest.MonkeyPatch) -> None:
    """A unit that takes 150 as it comes drives at full speed: the report is no garbage."""
    now = [100.0]
    monkeypatch.setattr("intellwheels_agents.bridge.luci_driver.time", SimpleNamespace(monotonic=lambda: now[0]))
    driver = LuciDriver("127.0.0.1:1", CHAIR, threading.Event())
    driver.begin_run("a" * 16)
    joystick = message("JoystickData", forward_back=150, left_right=0, source=AUTONOMOUS_REMOTE)
    for _ in range(2):
        driver._on_active_scaling(message("ActiveScaling", joystick=joystick))
        now[0] += 0.3
    assert driver.failure is not None
    assert driver.failure.startswith("the chair drives with forward 1.5 and turn 0, which this bridge did not send")
    assert driver.faults()["garbage"] == 0


def test_a_second_bridge_on_one_unit_is_refused(line: Line) -> None:
    line.until_read()
    for address in (line.address, line.address.replace("127.0.0.1", "localhost")):
        second = LuciDriver(address, CHAIR, threading.Event())
        second.start()
        second.close()
        assert second.failure == f"{address} is in use by another iw-bridge"
    line.until_read(3)
