"""`iw-bridge`: brings a real chair into a simulation."""

from __future__ import annotations

import argparse
import sys
import threading
from collections.abc import Sequence

from intellwheels_agents.agent_peer import run_agent
from intellwheels_agents.bridge import bridge_options
from intellwheels_agents.bridge.chair_joystick import ChairJoystick
from intellwheels_agents.bridge.driver_choice import DRIVERS, check_usage, check_values, real_driver
from intellwheels_agents.bridge.event_notices import EventNotices
from intellwheels_agents.bridge.hardware_driver import Driver
from intellwheels_agents.bridge.line_faults import Faults
from intellwheels_agents.bridge.motor_deadman import MotorDeadman
from intellwheels_agents.bridge.motor_writer import MotorWriter
from intellwheels_agents.bridge.pose_source import Calibration, PoseSource
from intellwheels_agents.bridge.real_chair import RealChair
from intellwheels_agents.bridge.resume_gate import ResumeGate
from intellwheels_agents.bridge.sensor_merge import SensorMerge
from intellwheels_agents.bridge.terminal_lines import read_lines
from intellwheels_agents.bridge.world_driver import WorldDriver, with_receiver
from intellwheels_agents.joystick.joystick_peer import operate
from intellwheels_agents.mind import Make
from intellwheels_agents.options import OptionError
from intellwheels_agents.robot_document import equipped, joining
from intellwheels_maps import robot as robot_file
from intellwheels_schemas.codec import Encoding, decode, encoding_of
from intellwheels_schemas.command_parser import naming
from intellwheels_schemas.endpoint_form import check_endpoint
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.link import Link, add_link_options, link_of, open_session
from intellwheels_schemas.messages import Body, Event, Robot
from intellwheels_schemas.names import check_agent, check_name, check_word, new_hex
from intellwheels_schemas.process import SLICE, THREADS_END, add_process_options, start_network_thread, stop_on_signals
from intellwheels_schemas.zenoh_inbox import Arrival, Inbox, Put


def parser() -> argparse.ArgumentParser:
    """Return the command line."""
    result = bridge_options.parser()
    add_link_options(result)
    add_process_options(result)
    return result


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code: 0 done, 1 refused or failed, 2 wrong usage."""
    command = parser()
    given = command.parse_args(arguments)
    lacking = check_usage(command, given)
    if lacking is not None:
        _log(lacking)
        return 2
    # First, because a signal may arrive while the other arguments are read.
    stop = stop_on_signals(given.lifeline)
    try:
        return _BridgeProcess(given, stop).run()
    except (OptionError, WireError) as error:
        _log(str(error))
        return 2
    except ConnectionError as error:
        _log(str(error))
        return 1


class _BridgeProcess:
    """The parts of one bridge, from its start to its end."""

    def __init__(self, given: argparse.Namespace, stop: threading.Event) -> None:
        self._given = given
        self._stop = stop
        self._agent = check_agent(given.name, "--name")
        self._where = link_of(given)
        self._encoding = Encoding.XML if given.encoding == "xml" else Encoding.JSON
        for option, place in (("--place", given.place), ("--lab-place", given.lab_place)):
            if place is not None:
                check_word(place, option)
        check_values(given)
        kind = DRIVERS[given.driver]
        robot = _changed(_robot("--robot", given.robot), "--option", given.option)
        chair = _robot("--robot", given.robot) if given.chair is None else _robot("--chair", given.chair)
        chair = _changed(chair, "--chair-option", given.chair_option)
        faults = Faults(given.delay, given.jitter, given.loss, f"{given.seed}/{self._agent}")
        hardware = given.hardware or kind.hardware
        resume = given.resume or ("confirm" if hardware == "real" else "auto")
        self._gate = ResumeGate(self._agent, confirm=resume == "confirm", tell=_print, prompt=_log)
        self._motors = MotorDeadman(faults, gate=self._gate)
        self._driver = self._world_driver(chair) if given.driver == "world" else real_driver(given, chair, stop, _print)
        calibration = Calibration(given.wheel_ratio, given.wheel_scale, given.track_ratio)
        self._source = PoseSource(
            chair,
            given.pose,
            calibration,
            drift=kind.drift if given.drift is None else given.drift,
            restarts_at_start=self._driver.restarts_at_start,
        )
        merge = SensorMerge(robot, chair, given.sensors, hardware, has_motion=kind.has_motion)
        self._joystick = ChairJoystick(stop)
        self._chair = RealChair(
            self._driver, self._source, self._motors, merge, faults=faults, on_reading=self._joystick.on_reading,
            clock_offset=given.clock_offset,
        )  # fmt: skip
        instance = new_hex()
        self._notices = EventNotices(self._agent, instance)
        self._body = joining(
            merge.robot, agent=self._agent, role="body", instance=instance, place=given.place, barrier=None
        )

    def run(self) -> int:
        """Run until the process must stop, and return the exit code."""
        given, stop = self._given, self._stop
        self._driver.start()
        writer = MotorWriter(self._motors, self._driver, lambda: self._chair.lockstep)
        threads = [threading.Thread(target=writer.run, args=(stop,), name="motors")]
        if self._gate.confirm:
            threads.append(threading.Thread(target=self._read_confirmations, name="confirm", daemon=True))
        try:
            if not self._await_hardware():
                return 1 if self._driver.failure or not stop.is_set() else 0
            for thread in threads:
                thread.start()
            threads.append(start_network_thread("events", self._watch_events))
            if given.joystick:
                threads.append(start_network_thread("joystick", self._operate))
            code = run_agent(
                self._body, self._chair.begin, {}, where=self._where, encoding=self._encoding,
                retry_for=given.retry_for, stop=stop, tell=self._tell, on_presence=self._on_presence,
                on_instance=self._notices.renew,
            )  # fmt: skip
            return 1 if self._driver.failure else code
        finally:
            stop.set()
            for thread in threads:
                if thread.is_alive():
                    thread.join(timeout=THREADS_END)
            self._driver.close()
            if self._driver.failure:
                _log(self._driver.failure)
            _print(self._summary())

    def _await_hardware(self) -> bool:
        """Wait for the first reading of the chair; return whether it came."""
        waited, pause = 0.0, 0.1
        while not self._driver.connected.wait(pause):
            waited += pause
            if self._stop.is_set():
                return False
            if waited >= self._given.retry_for:
                _log(f"the chair sent nothing for {waited:g} s")
                return False
        _print(f"hardware agent={self._agent} driver={self._given.driver}")
        return True

    def _second_link(self) -> Link:
        """Return the link of another session: only one session can listen at an endpoint, the others connect to it."""
        where = self._where
        return Link(where.world, connect=where.connect or where.listen, config=where.config, identity=where.identity)

    def _tell(self, line: str) -> None:
        if line.startswith("joined "):
            self._gate.joined()
        _print(line)

    def _on_presence(self, alive: bool) -> None:
        """Print the simulator's going or return, and close the gate when it goes.

        The session of the chair tells it. The session of the events may not have heard of a simulator that ends soon
        after the join.
        """
        if not alive:
            self._gate.interrupted("simulator-gone")
        line = self._notices.presence(alive)
        if line is not None:
            _print(line)

    def _read_confirmations(self) -> None:
        read_lines(sys.stdin.fileno(), self._gate.confirmed, self._stop)
        if not self._stop.is_set():
            _log("standard input is closed: after an interruption restart iw-bridge, or start it with --resume auto")

    def _watch_events(self) -> None:
        """Print what happens to the chair."""
        try:
            session = open_session(self._second_link(), self._stop)
        except ConnectionError as error:
            _log(f"events of the chair are not printed: {error}")
            return
        if session is None:
            return
        keys, inbox = Keys(self._where.world), Inbox()
        with (
            session,
            session.declare_subscriber(keys.event, inbox.on_sample),
            session.declare_subscriber(keys.body(self._agent), inbox.on_sample),
        ):
            while not self._stop.is_set():
                inbox.wait(SLICE)
                for arrival in inbox.take():
                    line = self._notice(arrival, keys)
                    if line is not None and not self._stop.is_set():
                        _print(line)

    def _notice(self, arrival: Arrival, keys: Keys) -> str | None:
        if not isinstance(arrival, Put):
            return None
        try:
            encoding = encoding_of(arrival.encoding, arrival.data)
            if arrival.key == keys.event:
                return self._notices.event(decode(Event, arrival.data, encoding, strict=False))
            return self._notices.body(decode(Body, arrival.data, encoding, strict=False))
        except WireError as error:
            _log(f"dropped key={arrival.key} why={error.text!r}")
            return None

    def _operate(self) -> None:
        operate(self._second_link(), self._agent, self._joystick, take=False, stop=self._stop, retry_for=None)

    def _world_driver(self, chair: Robot) -> Driver:
        given = self._given
        for endpoint in given.lab_connect:
            check_endpoint(endpoint, "--lab-connect")
        where = Link(
            check_name(given.lab_world, "--lab-world"),
            connect=tuple(given.lab_connect) or self._where.connect,
            config=None if given.lab_connect else self._where.config,
            identity=None if given.lab_connect else self._where.identity,
        )
        chair = with_receiver(chair, fixes=given.pose == "corrected", noise=given.fix_noise, every=given.fix_every)
        robot = joining(
            chair, agent=self._agent, role=given.lab_role, instance=new_hex(),
            place=given.lab_place or given.place, barrier=None,
        )  # fmt: skip

        def join(make: Make) -> int:
            return run_agent(
                robot, make, {}, where=where, encoding=self._encoding, retry_for=given.retry_for, stop=self._stop,
                tell=lambda line: _print(f"lab-{line}"),
            )  # fmt: skip

        return WorldDriver(chair, self._motors, join, self._stop)

    def _summary(self) -> str:
        counts, source = self._chair.statistics, self._source
        mean = counts.age / counts.poses if counts.poses else 0.0
        values = {
            "agent": self._agent, "poses": counts.poses, "readings": counts.readings, "overtaken": source.overtaken,
            "missing": source.missing, "lost_up": self._chair.lost, "lost_down": self._motors.lost,
            "stale": counts.stale, "age_mean": f"{mean:.4f}", "age_max": f"{counts.oldest:.4f}",
            **self._driver.faults(),
        }  # fmt: skip
        return "bridged " + " ".join(f"{name}={value}" for name, value in values.items())


def _print(line: str) -> None:
    print(line, flush=True)


def _log(line: str) -> None:
    print(f"iw-bridge: {line}", file=sys.stderr, flush=True)


def _robot(option: str, name: str) -> Robot:
    with naming(option):
        return robot_file(name)


def _changed(robot: Robot, option: str, given: Sequence[str]) -> Robot:
    """Return a robot with the fields that an option gives.

    Raises:
        OptionError: One cannot be set; the text names the option.
    """
    fields = _fields(option, given)
    try:
        return equipped(robot, fields)
    except OptionError as error:
        raise OptionError(f"{option}: {error}") from None


def _fields(option: str, given: Sequence[str]) -> dict[str, str]:
    pairs: dict[str, str] = {}
    for text in given:
        name, equals, value = text.partition("=")
        if not equals or not name[:1].isupper() or name in pairs:
            raise OptionError(f"{option}: expected FIELD=VALUE, each field of the robot once, got {text!r}")
        pairs[name] = value
    return pairs


if __name__ == "__main__":
    sys.exit(main())
