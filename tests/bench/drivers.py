"""What the drivers of real chairs cost: reading a message, and the way of a power to the chair, without a network."""

from __future__ import annotations

import statistics
import threading
import time
from collections.abc import Callable

import can

from intellwheels_agents.bridge.luci_driver import LuciDriver
from intellwheels_agents.bridge.luci_readings import WheelTurns, nearest, points_of
from intellwheels_agents.bridge.luci_schema import message, parsed
from intellwheels_agents.bridge.luci_stand_in import LuciChair, serve
from intellwheels_agents.bridge.rnet_driver import RnetDriver
from intellwheels_agents.bridge.rnet_frames import Frame, Stick, decode_frame, joystick_frame
from intellwheels_agents.bridge.stick_motion import StickMotion
from intellwheels_maps import robot
from intellwheels_schemas.names import new_hex
from tests.bench.rows import Row

POINTS = 100
"""Points of a radar message."""
CHAIR = robot("intellwheels")


def bench(*, rounds: int = 2000, powers: int = 40) -> list[Row]:
    """Return the rows: `rounds` messages of each kind, `powers` powers on their way."""
    return [
        Row("drivers", "luci", "encoder message, 8 sonars", _encoder_message(rounds), "µs"),
        Row("drivers", "luci", f"radar message, {POINTS} points", _radar_message(rounds), "µs"),
        Row("drivers", "luci", "power to chair, median", 1000.0 * _luci_power(powers), "ms"),
        Row("drivers", "rnet", "joystick frame", _joystick_frame(rounds), "µs"),
        Row("drivers", "rnet", "joystick frame to injected frame, median", 1000.0 * _injection(powers), "ms"),
    ]


def _each(rounds: int, work: Callable[[int], object]) -> float:
    """Return what a round costs, in microseconds: the best of five."""
    best = float("inf")
    for _ in range(5):
        began = time.perf_counter()
        for number in range(rounds):
            work(number)
        best = min(best, time.perf_counter() - began)
    return 1e6 * best / rounds


def _encoder_message(rounds: int) -> float:
    turns, points = WheelTurns(CHAIR.encoder_ticks), [(1.0 + 0.01 * n, 0.01 * n) for n in range(10)]
    told = [
        message("EncoderData", left_angle=(n % 360) + 0.5, right_angle=(n % 360) + 0.5, edge_timestamp=10 * n + 1)
        for n in range(rounds)
    ]
    data = [one.SerializeToString() for one in told]

    def read(number: int) -> None:
        heard = parsed("EncoderData", data[number])
        turns.update(heard.left_angle, heard.right_angle)
        nearest(CHAIR.proximity, points)

    return _each(rounds, read)


def _radar_message(rounds: int) -> float:
    radar = message("RadarPoints", points=[message("RadarPoint", x=0.01 * n, y=1.0) for n in range(POINTS)])
    data = radar.SerializeToString()
    return _each(rounds, lambda _number: points_of(parsed("RadarPoints", data), "RadarPoints"))


def _joystick_frame(rounds: int) -> float:
    motion, frame = StickMotion(CHAIR), joystick_frame(1, 0.5, 0.1)
    clock = [0.0]

    def read(_number: int) -> None:
        content = decode_frame(frame)
        assert isinstance(content, Stick)
        motion.obey(content.forward, content.turn)
        clock[0] += 0.01
        motion.advance(clock[0])

    return _each(rounds, read)


def _luci_power(powers: int) -> float:
    """Return the median time from a changed power to the chair's motors, in seconds."""
    luci, stop, ended = LuciChair(CHAIR.wheel_diameter, CHAIR.top_speed), threading.Event(), threading.Event()
    server, port = serve(luci, "127.0.0.1:0", ended)
    driver = LuciDriver(f"127.0.0.1:{port}", CHAIR, stop)
    driver.begin_run("0" * 16)
    driver.start()
    try:
        driver.connected.wait(60.0)
        delays = []
        for number in range(powers + 1):
            wanted = 0.5 if number % 2 else 0.3
            began = time.perf_counter()
            driver.write(wanted, wanted)
            while luci.chair.stick[0] != wanted and time.perf_counter() - began < 10.0:
                stop.wait(0.0002)
            delays.append(time.perf_counter() - began)
        return statistics.median(delays[1:])
    finally:
        stop.set()
        driver.close()
        ended.set()
        server.stop(grace=0).wait(5.0)


def _injection(powers: int) -> float:
    """Return the median time from a joystick frame on the bus to the frame that follows it, in seconds."""
    channel, stop, delays = f"bench-{new_hex()}", threading.Event(), list[float]()
    with can.Bus(interface="virtual", channel=channel) as bus:
        driver = RnetDriver("virtual", channel, CHAIR, stop, inject=True)
        driver.begin_run("0" * 16)
        driver.start()
        rest = joystick_frame(1, 0.0, 0.0)
        try:
            while len(delays) < powers:
                driver.write(0.5, 0.5)
                began = time.perf_counter()
                bus.send(can.Message(arbitration_id=rest.identifier, is_extended_id=True, data=rest.data))
                got = bus.recv(1.0)
                if got is not None and Frame(got.arbitration_id, bytes(got.data)) != rest:
                    delays.append(time.perf_counter() - began)
                stop.wait(0.002)
        finally:
            stop.set()
            driver.close()
    return statistics.median(delays)
