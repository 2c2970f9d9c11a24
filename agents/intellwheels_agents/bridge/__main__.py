"""`iw-bridge`: a real chair in a simulation, in a process of its own."""

from __future__ import annotations

import argparse
import math
import sys
import threading
from collections.abc import Callable, Sequence
from typing import Literal

from intellwheels_agents.agent_peer import run_agent
from intellwheels_agents.bridge.chair_joystick import StickSource
from intellwheels_agents.bridge.hardware_driver import Driver
from intellwheels_agents.bridge.line_faults import Faults
from intellwheels_agents.bridge.motor_deadman import MotorDeadman
from intellwheels_agents.bridge.motor_writer import MotorWriter
from intellwheels_agents.bridge.pose_source import DRIFT, POSE_SOURCES, Calibration, PoseSource
from intellwheels_agents.bridge.real_chair import RealChair
from intellwheels_agents.bridge.sensor_merge import SENSORS, SensorMerge
from intellwheels_agents.bridge.serial_driver import SerialDriver
from intellwheels_agents.bridge.world_driver import WorldDriver, fitted
from intellwheels_agents.joystick.joystick_peer import operate
from intellwheels_agents.mind import Make
from intellwheels_agents.options import OptionError
from intellwheels_agents.robot_document import equipped, joining
from intellwheels_maps import robot as robot_file
from intellwheels_schemas.codec import Encoding
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.link import Link, add_link_options, link_of
from intellwheels_schemas.messages import Robot
from intellwheels_schemas.names import check_agent, check_name, new_hex
from intellwheels_schemas.process import add_process_options, stop_on_signals

EXAMPLES = """\
examples:
  a chair on a serial line; its mind is any program, in any language, that joins as its mind
      iw-bridge serial --port /dev/ttyUSB0 --name chair1 --robot intellwheels --place start1
      iw-agent avoid --name chair1 --role mind
  a chair of the simulation `lab`, whose right wheel is 0.2 % too large, reported by raw odometry
      iw-server --world lab --listen tcp/127.0.0.1:7448 --map ward --hide-truth
      iw-bridge world --lab-connect tcp/127.0.0.1:7448 --name chair1 --chair-option WheelRatio=1.002
  the same, its pose corrected by a position once a second that is right to 5 cm
      iw-bridge world --lab-connect tcp/127.0.0.1:7448 --name chair1 --chair-option WheelRatio=1.002 \\
          --pose corrected --fix-every 20 --fix-noise 0.05

Two worlds in lockstep go tick by tick; both servers then need a --deadline as long as the other may be kept waiting.
On standard output: `hardware agent=...` when the chair is heard, `joined agent=...`, `run ...`, `left ...` of the
simulation, the same with `lab-` before them of the laboratory, and at the end `bridged agent=...` with what was
measured on the way. Exit code 0: done; 1: refused or failed; 2: wrong usage.
"""
DEFAULT_ROBOT = "intellwheels"


def parser() -> argparse.ArgumentParser:
    """Return the command line."""
    result = argparse.ArgumentParser(
        prog="iw-bridge",
        description="Join a simulation with the body of a real chair.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    result.add_argument("driver", choices=("world", "serial"), help="another simulation's, or one on a line")
    body = result.add_argument_group("body")
    body.add_argument("--name", required=True, metavar="NAME", help="the agent's name, in both worlds")
    body.add_argument(
        "--robot", default=DEFAULT_ROBOT, metavar="NAME|FILE",
        help=f"the body with its virtual sensors (default: {DEFAULT_ROBOT})",
    )  # fmt: skip
    body.add_argument("--option", action="append", default=[], metavar="FIELD=VALUE", help="a field of it; repeated")
    body.add_argument("--place", metavar="PLACE", help="where the chair stands when the bridge starts")
    body.add_argument(
        "--sensors", choices=SENSORS, default="virtual", help="what its mind perceives: virtual sensors, its own"
        " sonars under their names, or both, its own as real-ID (default: virtual)",
    )  # fmt: skip
    chair = result.add_argument_group("the chair as built")
    chair.add_argument("--chair", metavar="NAME|FILE", help="its data sheet and own sonars (default: as --robot)")
    chair.add_argument(
        "--chair-option", action="append", default=[], metavar="FIELD=VALUE",
        help="a field of it, such as WheelRatio=1.002 of one in world; repeated",
    )  # fmt: skip
    chair.add_argument(
        "--hardware", choices=("real", "simulated"),
        help="real: only real time at speed 1 moves it (default: simulated for world, real for serial)",
    )  # fmt: skip
    chair.add_argument("--joystick", action="store_true", help="its own joystick writes the user's input")
    _add_pose_options(result)
    _add_line_options(result)
    result.add_argument(
        "--encoding", choices=("json", "xml"), default="json", help="how messages are written (default: json)"
    )
    result.add_argument(
        "--retry-for", type=_positive, default=math.inf, metavar="S",
        help="give up when chair or simulator is not there for so many seconds (default: never)",
    )  # fmt: skip
    add_link_options(result)
    add_process_options(result)
    return result


def _add_pose_options(result: argparse.ArgumentParser) -> None:
    pose = result.add_argument_group("pose")
    pose.add_argument(
        "--pose", choices=POSE_SOURCES, default="raw", help="encoders with the data sheet's figures, with calibrated "
        "ones, or those corrected by positions from outside (default: raw)",
    )  # fmt: skip
    for name, what in (
        ("--wheel-ratio", "right wheel over left one (UMBmark's E_d)"),
        ("--wheel-scale", "mean wheel over that of the data sheet"),
        ("--track-ratio", "track over that of the data sheet (UMBmark's E_b)"),
    ):
        pose.add_argument(name, type=_ratio, default=1.0, metavar="R", help=f"calibration: {what} (default: 1)")
    pose.add_argument(
        "--drift", type=_not_negative, default=DRIFT, metavar="K",
        help=f"variance of a wheel's way, m2 a metre, for the covariance (default: {DRIFT:g})",
    )  # fmt: skip
    pose.add_argument(
        "--fix-every", type=_count, default=20, metavar="TICKS",
        help="world: ticks from one position to the next, where the chair has no GPS of its own (default: 20)",
    )  # fmt: skip
    pose.add_argument(
        "--fix-noise", type=_not_negative, default=0.05, metavar="M",
        help="world: its standard deviation on each axis (default: 0.05)",
    )  # fmt: skip


def _add_line_options(result: argparse.ArgumentParser) -> None:
    world = result.add_argument_group("driver world")
    world.add_argument("--lab-world", default="lab", metavar="NAME", help="the laboratory's name (default: lab)")
    world.add_argument(
        "--lab-connect", action="append", default=[], metavar="ENDPOINT",
        help="where it is (default: where the simulation is)",
    )  # fmt: skip
    world.add_argument("--lab-place", metavar="PLACE", help="where the chair starts in it (default: --place)")
    world.add_argument(
        "--lab-role", choices=("both", "mind"), default="both",
        help="both: bring the chair; mind: it is there, and another process its body (default: both)",
    )  # fmt: skip
    line = result.add_argument_group("driver serial")
    line.add_argument("--port", metavar="DEVICE|URL", help="such as /dev/ttyUSB0, or socket://HOST:PORT")
    line.add_argument("--baud", type=_count, default=115_200, metavar="N", help="bits a second (default: 115200)")
    faults = result.add_argument_group("faults, for experiments: of the way between chair and bridge, both ways")
    faults.add_argument("--delay", type=_not_negative, default=0.0, metavar="S", help="seconds (default: 0)")
    faults.add_argument(
        "--jitter", type=_not_negative, default=0.0, metavar="S", help="further seconds at most (default: 0)"
    )
    faults.add_argument("--loss", type=_share, default=0.0, metavar="SHARE", help="share that is lost (default: 0)")
    faults.add_argument("--seed", default="1", metavar="TEXT", help="the faults follow from it (default: 1)")
    faults.add_argument(
        "--clock-offset", type=float, default=0.0, metavar="S",
        help="added to the stamps: the simulator's clock minus this machine's (default: 0)",
    )  # fmt: skip


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code: 0 done, 1 refused or failed, 2 wrong usage."""
    grammar = parser()
    given = grammar.parse_args(arguments)
    if (given.driver == "serial") != (given.port is not None):
        grammar.error("--port: expected one with the driver serial, and only then")
    # First of all: a signal may come while the rest is still read.
    stop = stop_on_signals(given.lifeline)
    try:
        return _Bridge(given, stop).run()
    except (OptionError, WireError) as error:
        print(f"iw-bridge: {error}", file=sys.stderr)
        return 2
    except ConnectionError as error:
        print(f"iw-bridge: {error}", file=sys.stderr)
        return 1


class _Bridge:
    """One bridge: its parts, put together, and its life."""

    def __init__(self, given: argparse.Namespace, stop: threading.Event) -> None:
        self._given = given
        self._stop = stop
        self._agent = check_agent(given.name, "--name")
        self._where = link_of(given)
        self._encoding = Encoding.XML if given.encoding == "xml" else Encoding.JSON
        robot = equipped(robot_file(given.robot), _fields("--option", given.option))
        chair = equipped(robot_file(given.chair or given.robot), _fields("--chair-option", given.chair_option))
        faults = Faults(given.delay, given.jitter, given.loss, f"{given.seed}/{self._agent}")
        self._motors = MotorDeadman(faults)
        self._driver = self._laboratory(chair) if given.driver == "world" else self._port(chair)
        calibration = Calibration(given.wheel_ratio, given.wheel_scale, given.track_ratio)
        self._source = PoseSource(chair, given.pose, calibration, drift=given.drift, returns=self._driver.returns)
        default: Literal["real", "simulated"] = "real" if given.driver == "serial" else "simulated"
        merge = SensorMerge(robot, chair, given.sensors, given.hardware or default)
        self._stick = StickSource(stop)
        self._chair = RealChair(
            self._driver, self._source, self._motors, merge, faults=faults, hear=self._stick.hear,
            clock_offset=given.clock_offset,
        )  # fmt: skip
        self._body = joining(
            merge.robot, agent=self._agent, role="body", instance=new_hex(), place=given.place, barrier=None
        )

    def run(self) -> int:
        """Live, and return the exit code."""
        given, stop = self._given, self._stop
        self._driver.start()
        pump = MotorWriter(self._motors, self._driver, lambda: self._chair.lockstep)
        threads = [threading.Thread(target=pump.run, args=(stop,), name="motors")]
        if given.joystick:
            threads.append(threading.Thread(target=self._operate, name="joystick", daemon=True))
        try:
            if not self._await_hardware():
                return 1 if self._driver.failure or not stop.is_set() else 0
            for thread in threads:
                thread.start()
            code = run_agent(
                self._body, self._chair.begin, {}, where=self._where, encoding=self._encoding,
                retry_for=given.retry_for, stop=stop,
            )  # fmt: skip
            return 1 if self._driver.failure else code
        finally:
            stop.set()
            for thread in threads:
                if thread.is_alive():
                    thread.join(timeout=2.0)
            self._driver.close()
            if self._driver.failure:
                print(f"iw-bridge: {self._driver.failure}", file=sys.stderr)
            print(self._summary(), flush=True)

    def _await_hardware(self) -> bool:
        """Wait until the chair is heard; return whether it is."""
        waited, pause = 0.0, 0.1
        while not self._driver.heard.wait(pause):
            waited += pause
            if self._stop.is_set():
                return False
            if waited >= self._given.retry_for:
                print(f"iw-bridge: no chair was heard in {waited:g} s", file=sys.stderr)
                return False
        print(f"hardware agent={self._agent} driver={self._given.driver}", flush=True)
        return True

    def _operate(self) -> None:
        operate(self._where, self._agent, self._stick, take=False, stop=self._stop, retry_for=None)

    def _laboratory(self, chair: Robot) -> Driver:
        given = self._given
        where = Link(
            check_name(given.lab_world, "--lab-world"),
            connect=tuple(given.lab_connect) or self._where.connect,
            config=None if given.lab_connect else self._where.config,
        )
        chair = fitted(chair, fixes=given.pose == "corrected", noise=given.fix_noise, every=given.fix_every)
        robot = joining(
            chair, agent=self._agent, role=given.lab_role, instance=new_hex(),
            place=given.lab_place or given.place, barrier=None,
        )  # fmt: skip

        def enter(make: Make) -> int:
            return run_agent(
                robot, make, {}, where=where, encoding=self._encoding, retry_for=given.retry_for, stop=self._stop,
                tell=lambda line: print(f"lab-{line}", flush=True),
            )  # fmt: skip

        return WorldDriver(chair, self._motors, enter, self._stop)

    def _port(self, chair: Robot) -> Driver:
        return SerialDriver(self._given.port, self._given.baud, chair.proximity, self._stop)

    def _summary(self) -> str:
        tally, source = self._chair.tally, self._source
        mean = tally.age / tally.poses if tally.poses else 0.0
        values = {
            "agent": self._agent, "poses": tally.poses, "readings": tally.readings, "overtaken": source.stale,
            "missing": source.lost, "lost_up": self._chair.lost, "lost_down": self._motors.lost, "stale": tally.stale,
            "age_mean": f"{mean:.4f}", "age_max": f"{tally.oldest:.4f}", **self._driver.faults(),
        }  # fmt: skip
        return "bridged " + " ".join(f"{name}={value}" for name, value in values.items())


def _fields(option: str, given: Sequence[str]) -> dict[str, str]:
    pairs: dict[str, str] = {}
    for text in given:
        name, equals, value = text.partition("=")
        if not equals or not name[:1].isupper() or name in pairs:
            raise OptionError(f"{option}: expected each field of the robot document once, FIELD=VALUE, got {text!r}")
        pairs[name] = value
    return pairs


def _number(expected: str, fits: Callable[[float], bool]) -> Callable[[str], float]:
    def read(text: str) -> float:
        value = float(text)
        if not fits(value):
            raise argparse.ArgumentTypeError(f"expected {expected}, got {text!r}")
        return value

    return read


_positive = _number("a number above 0", lambda value: 0.0 < value < math.inf)
_not_negative = _number("a number from 0 on", lambda value: 0.0 <= value < math.inf)
_share = _number("a share in [0, 1]", lambda value: 0.0 <= value <= 1.0)
_ratio = _number("a ratio in [0.5, 2]", lambda value: 0.5 <= value <= 2.0)


def _count(text: str) -> int:
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"expected a whole number from 1 on, got {text!r}")
    return value


if __name__ == "__main__":
    sys.exit(main())
