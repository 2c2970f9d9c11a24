"""The driver on a bus inside this process. `tests/e2e/test_chairs.py` has one between processes."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator

import can
import pytest

from intellwheels_agents.bridge.hardware_driver import Reading
from intellwheels_agents.bridge.rnet_driver import RnetDriver
from intellwheels_agents.bridge.rnet_frames import Frame, joystick_frame
from intellwheels_maps import robot
from intellwheels_schemas.names import new_hex

pytestmark = pytest.mark.process

DEADLINE = 60.0
CHAIR = robot("intellwheels")
REST = joystick_frame(1, 0.0, 0.0)


class Line:
    """A driver on a bus, and the bus."""

    def __init__(self, *, inject: bool, accepted: bool = True) -> None:
        self.channel = f"test-{new_hex()}"
        self.bus = can.Bus(interface="virtual", channel=self.channel)
        self.stop = threading.Event()
        self.waits: list[str] = []
        self.told: list[str] = []
        self.status: list[str] = []
        self.readings: list[Reading] = []
        self.sent: list[Frame] = []
        self.driver = RnetDriver(
            "virtual", self.channel, CHAIR, self.stop, inject=inject, waiting=self.waits.append,
            tell=self.told.append, status=self.status.append,
        )  # fmt: skip
        if accepted:
            self.driver.begin_run("a" * 16)
        self.driver.start()

    def put(self, frame: Frame, *, remote: bool = False) -> None:
        data = None if remote else frame.data
        self.bus.send(can.Message(arbitration_id=frame.identifier, is_remote_frame=remote, data=data))

    def until(
        self,
        found: Callable[[], object],
        what: str,
        stick: Frame | None = REST,
        power: tuple[float, float] | None = None,
    ) -> None:
        """Put a joystick frame every 10 ms, and write a power, until something is so."""
        deadline = time.monotonic() + DEADLINE
        while not found():
            assert time.monotonic() < deadline, (what, self.waits, self.told)
            if power is not None:
                self.driver.write(*power)
            if stick is not None:
                self.put(stick)
            # Its thread does the work; this is a slice of a wait with a deadline.
            self.stop.wait(0.01)
            while (got := self.bus.recv(0.0)) is not None:
                self.sent.append(Frame(got.arbitration_id, bytes(got.data)))
            self.readings += self.driver.read()

    def until_read(self, count: int, **how: object) -> Reading:
        want = len(self.readings) + count
        self.until(lambda: len(self.readings) >= want, "readings", **how)  # type: ignore[arg-type]
        return self.readings[-1]

    def end(self) -> None:
        self.stop.set()
        self.driver.close()
        self.bus.shutdown()


@pytest.fixture
def listening() -> Iterator[Line]:
    made = Line(inject=False)
    yield made
    made.end()


@pytest.fixture
def driving() -> Iterator[Line]:
    made = Line(inject=True)
    yield made
    made.end()


def test_the_joystick_moves_the_chair_and_nothing_is_sent(listening: Line) -> None:
    line = listening
    first = line.until_read(2, power=(0.5, 0.5))
    line.put(Frame(0x0A040100, b"\x32"))
    line.put(Frame(0x14300100, b"\xe8\x02"))
    line.put(Frame(0x1C0C0100, b"\x57"))
    last = line.until_read(20, stick=joystick_frame(1, 0.8, 0.3), power=(0.5, 0.5))
    assert (last.forward, last.turn) == (0.8, 0.3)
    assert last.right - first.right > last.left - first.left > 0
    line.until(lambda: line.status, "the status")
    assert line.status == ["battery=87 speed=50 current_max=744"]
    assert line.sent == []
    assert line.driver.faults() == {"garbage": 0, "reopened": 0, "unwritten": 0, "injected": 0}


def test_powers_follow_the_frames_of_a_joystick_at_rest(driving: Line) -> None:
    line = driving
    line.until_read(2, stick=joystick_frame(3, 0.0, 0.0))
    before = line.readings[-1]
    line.until(lambda: len(line.sent) >= 20, "injected frames", joystick_frame(3, 0.0, 0.0), (0.6, 0.4))
    assert set(line.sent) == {joystick_frame(3, 0.5, -0.1)}
    assert line.until_read(2, stick=joystick_frame(3, 0.0, 0.0)).left > before.left


@pytest.mark.parametrize("power", [None, (0.0, 0.0)])
def test_a_stop_is_silence(driving: Line, power: tuple[float, float] | None) -> None:
    """Without a new power for 0.2 s, or with power 0, the joystick's own frames are in force."""
    line = driving
    line.until(lambda: line.sent, "injected frames", power=(0.5, 0.5))

    def is_silent() -> bool:
        count = len(line.sent)
        line.until_read(3, power=power)
        return len(line.sent) == count

    line.until(is_silent, "silence", power=power)


def test_a_joystick_module_that_is_gone_stops_the_chair(driving: Line) -> None:
    line = driving
    line.until(lambda: line.sent, "injected frames", power=(0.5, 0.5))
    line.until(lambda: line.waits, "the wait", None, (0.5, 0.5))
    assert line.waits == [
        f"{line.channel} is open, but no joystick frames come; is the chair on, at 125 kbit/s?"
    ]  # fmt: skip
    count = len(line.sent)
    line.driver.write(0.5, 0.5)
    assert line.bus.recv(0.05) is None
    line.until(lambda: len(line.sent) > count, "frames when it is back", power=(0.5, 0.5))


def test_a_person_who_moves_the_joystick_drives(driving: Line) -> None:
    line = driving
    line.until(lambda: line.sent, "injected frames", power=(0.5, 0.5))
    line.until_read(3, stick=joystick_frame(1, -0.5, 0.0), power=(0.5, 0.5))
    count, let_go = len(line.sent), time.monotonic()
    line.until_read(3, stick=joystick_frame(1, -0.5, 0.0), power=(0.5, 0.5))
    assert len(line.sent) == count
    line.until(lambda: len(line.sent) > count, "frames again", power=(0.5, 0.5))
    # Not at once: a second after the joystick was let go.
    assert time.monotonic() - let_go > 0.9


def test_nothing_is_sent_before_the_simulator_has_accepted_the_bridge() -> None:
    line = Line(inject=True, accepted=False)
    try:
        line.until_read(10, power=(0.5, 0.5))
        assert line.sent == []
    finally:
        line.end()


def test_wrong_frames_are_named_and_do_not_count_as_a_joystick(driving: Line) -> None:
    line = driving
    line.until_read(2)
    line.put(Frame(0x02000100, b"\x00"))
    line.put(Frame(0x02000100, b"\x00\x80"))
    line.put(Frame(0x0A040100, b"\xff"))
    line.put(Frame(0x02000100, b""), remote=True)
    line.until_read(2)
    assert line.driver.faults()["garbage"] == 4
    assert line.told == [
        "R-Net joystick: expected 2 bytes, got 1",
        "R-Net speed: expected a percentage in [0, 100], got 255",
    ]
    assert {one.forward for one in line.readings} == {0.0}


def test_a_second_bridge_on_one_bus_is_refused(listening: Line) -> None:
    second = RnetDriver("virtual", listening.channel, CHAIR, threading.Event())
    second.start()
    second.close()
    assert second.failure == f"{listening.channel} is in use by another iw-bridge"


def test_an_adapter_that_python_can_does_not_know_is_refused() -> None:
    stop = threading.Event()
    driver = RnetDriver("nothing", new_hex(), CHAIR, stop)
    driver.start()
    assert stop.wait(DEADLINE)
    driver.close()
    assert driver.failure is not None
    assert driver.failure.startswith("--interface, --can-option: python-can cannot use nothing: ")


class Recorded:
    """A bus on which some frames have arrived already. The process stops after them."""

    def __init__(self, stop: threading.Event, *frames: Frame | Exception) -> None:
        self.sent: list[Frame] = []
        self._stop = stop
        self._frames = list(frames)

    def recv(self, _timeout: float) -> can.Message | None:
        if not self._frames:
            # The driver has taken the frames when it asks again with nothing in hand.
            if _timeout > 0.0:
                self._stop.set()
            return None
        frame = self._frames.pop(0)
        if isinstance(frame, Exception):
            raise frame
        return can.Message(arbitration_id=frame.identifier, data=frame.data)

    def send(self, message: can.Message, timeout: float) -> None:
        del timeout
        self.sent.append(Frame(message.arbitration_id, bytes(message.data)))


@pytest.mark.parametrize(
    ("last", "count"), [(REST, 1), (joystick_frame(1, -0.5, 0.0), 0), (joystick_frame(2, 1, 0), 0)]
)
def test_after_a_pause_old_frames_at_rest_are_not_followed_by_a_power(last: Frame, count: int) -> None:
    stop = threading.Event()
    driver = RnetDriver("virtual", new_hex(), CHAIR, stop, inject=True)
    driver.begin_run("a" * 16)
    driver.write(0.5, 0.5)
    bus = Recorded(stop, *[REST] * 20, last)
    driver._use(bus)  # type: ignore[arg-type]
    assert bus.sent == [joystick_frame(1, 0.5, 0.0)] * count
    assert driver.faults()["injected"] == count


def test_no_error_of_an_adapter_s_library_ends_the_driver() -> None:
    stop, told = threading.Event(), list[str]()
    driver = RnetDriver("virtual", new_hex(), CHAIR, stop, tell=told.append)
    driver._use(Recorded(stop, REST, AttributeError("strange bytes"), REST))  # type: ignore[arg-type]
    assert told == ["CAN bus: strange bytes"]
    assert driver.connected.is_set()


def test_an_adapter_whose_library_is_missing_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    def lacking(**_: object) -> None:
        raise ImportError("please install it")

    monkeypatch.setattr(can, "Bus", lacking)
    stop = threading.Event()
    driver = RnetDriver("neovi", new_hex(), CHAIR, stop)
    driver.start()
    assert stop.wait(DEADLINE)
    driver.close()
    assert driver.failure == "--interface, --can-option: python-can cannot use neovi: please install it"


def test_frames_that_cannot_be_sent_are_told_once(monkeypatch: pytest.MonkeyPatch) -> None:
    stop, told = threading.Event(), list[str]()
    driver = RnetDriver("virtual", "can0", CHAIR, stop, inject=True, tell=told.append)
    driver.begin_run("a" * 16)
    driver.write(0.5, 0.5)
    bus = Recorded(stop)

    def refused(*_: object, **__: object) -> None:
        raise can.CanOperationError("no buffer")

    monkeypatch.setattr(bus, "send", refused)
    for _ in range(2):
        rest = can.Message(arbitration_id=REST.identifier, data=REST.data)
        driver._on_batch(bus, [rest], time.monotonic())  # type: ignore[arg-type]
    assert told == ["a frame could not be sent; is can0 in listen-only mode? no buffer"]
    assert (driver.faults()["unwritten"], driver.faults()["injected"]) == (2, 0)


def test_a_missing_bus_is_reported_once() -> None:
    stop, waits = threading.Event(), list[str]()

    def on_wait(reason: str) -> None:
        waits.append(reason)
        stop.set()

    driver = RnetDriver("socketcan", "nowhere0", CHAIR, stop, waiting=on_wait)
    driver.start()
    assert stop.wait(DEADLINE)
    driver.close()
    assert len(waits) == 1
    assert waits[0].startswith("cannot open nowhere0: ")
