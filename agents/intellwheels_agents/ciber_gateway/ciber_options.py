"""The command line of `iw-ciber`, without the options that every command shares."""

from __future__ import annotations

import argparse
import socket
from collections.abc import Mapping
from typing import Final

from intellwheels_agents.ciber_gateway.ciber_robot import ciber_robot
from intellwheels_agents.ciber_gateway.client_messages import Registration
from intellwheels_agents.ciber_gateway.lab_frame import BEACON, Lab, Target
from intellwheels_agents.ciber_gateway.robot_client import Waits
from intellwheels_agents.ciber_gateway.simulator_messages import KINDS, Settings
from intellwheels_agents.options import OptionError
from intellwheels_agents.robot_document import equipped
from intellwheels_schemas.command_parser import CommandParser, add_retry_option, number, port, positive_seconds, whole
from intellwheels_schemas.messages import Place

EXAMPLES: Final = """\
examples:
  a lab of the Ciber-Rato simulator, agents and its viewer, each in a terminal
      iw-server --map MyLab.xml
      iw-ciber
      ./robsample --host localhost          (or any other agent)
      Viewer                                (or iw-viewer, to see it in a browser)
  a lockstep run that waits for the answers of the agents
      iw-server --map MyLab.xml --pace lockstep
      iw-ciber --await 2
  without noise
      iw-ciber --option MotorNoise=0 --option Compass.NoiseDeg=0 --option Beacon.NoiseDeg=0 --obstacle-noise 0

A unit of a lab is 1 m. Robots start at the places of the map that have no kind, or the kind robot. An agent that asks
for the Id N starts at the N-th of these places, counted from 1; the Id 0 means any free one. Beacons are the places of
kind beacon, targets the zones.
A cycle is a tick, and lasts 50 ms with the simulator's default period. With a shorter period, use
--option TopSpeed=V with V at least 0.15 m divided by the period in s; otherwise the largest powers are reduced.

A robot that meets an obstacle slides along it; in the Ciber-Rato simulator it only turned.
In the Ciber-Rato simulator a robot heard itself, and its GPS had a random origin; here neither is so. Scores are not
kept, and there is no line sensor. RobotBeacon, Panel and the binary protocol are refused. A viewer shows the robots of
this iw-ciber.
Anybody who can send datagrams to the port can drive a robot of its own; by default only this machine can.

Standard output has the lines `ready port=...`, `joined agent=...`, `run agent=...`, `viewer client=...`,
`left agent=...`. Standard error has what was not obeyed, for the 1st, 10th, 100th time and so on.
Exit codes: 0 done, 1 refused or failed, 2 wrong usage.
"""
PORT: Final = 6000
"""Port of registrations, which agents have built in."""
HOST: Final = "127.0.0.1"
_WAITS: Final = Waits()
_SETTINGS: Final = Settings()


def parser() -> argparse.ArgumentParser:
    """Return the parser of this command's own options."""
    result = CommandParser(
        prog="iw-ciber",
        description="Let agents and viewers of the Ciber-Rato simulator, unchanged, take part in a world.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    result.add_argument(
        "--host", metavar="ADDRESS", default=HOST, help=f"address to listen at (default: {HOST}, this machine only)"
    )
    result.add_argument(
        "--port", type=port, default=PORT, metavar="N",
        help=f"port of registrations; 0 picks a free one (default: {PORT})",
    )  # fmt: skip
    result.add_argument(
        "--control", action="store_true", help="let viewers pause and resume the world, and remove robots"
    )
    result.add_argument(
        "--await", dest="await_answer", type=number("seconds", 0.0, 3600.0), default=_WAITS.answer, metavar="S",
        help="wait at each tick up to S seconds for the answers of agents, in [0, 3600]; less than the duration of a "
        f"tick or, in lockstep, than the simulator's --deadline (default: {_WAITS.answer:g})",
    )  # fmt: skip
    result.add_argument(
        "--silence", type=positive_seconds, default=_WAITS.silence, metavar="S",
        help=f"remove an agent that sends nothing for S seconds (default: {_WAITS.silence:g})",
    )  # fmt: skip
    robots = result.add_argument_group("robots")
    robots.add_argument("--gps", action="store_true", help="robots have a GPS")
    robots.add_argument("--no-beacon", dest="beacon", action="store_false", help="robots have no sensors for beacons")
    robots.add_argument(
        "--beacon-height", type=number("metres", 0.01, 100.0), default=2.0, metavar="M",
        help="height of the beacons in metres, in [0.01, 100], needed as a map does not keep those of a lab file; "
        "walls lower than this do not hide them (default: 2)",
    )  # fmt: skip
    robots.add_argument(
        "--obstacle-noise",
        type=number("a standard deviation", 0.0, 10.0), default=_SETTINGS.obstacle_noise, metavar="F",
        help=f"noise of the values of obstacle sensors, 1/m, in [0, 10] (default: {_SETTINGS.obstacle_noise:g})",
    )  # fmt: skip
    robots.add_argument(
        "--option", action="append", default=[], metavar="FIELD=VALUE",
        help="change a field of the robots, such as Beacon.ConeDeg=120; may be repeated",
    )  # fmt: skip
    robots.add_argument(
        "--requestable", action="append", default=[], choices=KINDS,
        help="send these sensors only when an agent requests them; may be repeated",
    )  # fmt: skip
    told = result.add_argument_group("parameters that agents are told")
    told.add_argument(
        "--requests", type=whole(0, 100), default=_SETTINGS.requests, metavar="N",
        help="largest number of sensors that an agent may request in a cycle, in [0, 100] "
        f"(default: {_SETTINGS.requests})",
    )  # fmt: skip
    told.add_argument(
        "--sim-time", type=whole(1, 1_000_000), default=_SETTINGS.sim_time, metavar="N",
        help=f"cycles of a run, in [1, 1000000]; the run does not end then (default: {_SETTINGS.sim_time})",
    )  # fmt: skip
    told.add_argument(
        "--key-time", type=whole(0, 1_000_000), default=_SETTINGS.key_time, metavar="N",
        help=f"cycles of its first phase, in [0, 1000000], at most --sim-time (default: {_SETTINGS.key_time})",
    )  # fmt: skip
    add_retry_option(result)
    return result


def check_together(given: argparse.Namespace) -> None:
    """Check that options fit each other, and that the address is of this machine.

    Raises:
        OptionError: They do not; the text names one.
    """
    if given.key_time > given.sim_time:
        raise OptionError(f"--key-time: expected at most --sim-time {given.sim_time}, got {given.key_time}")
    if not given.beacon and "beacon" in given.requestable:
        raise OptionError("--requestable: expected no beacon with --no-beacon, got both")
    if not given.gps and "gps" in given.requestable:
        raise OptionError("--requestable: expected gps with --gps only, got no --gps")
    try:
        # As the port will be: these are datagrams of IPv4.
        address = socket.getaddrinfo(given.host or "?", 0, socket.AF_INET, socket.SOCK_DGRAM)[0][4]
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.bind(address)
    except (OSError, UnicodeError):
        expected = "an IPv4 address of this machine, such as 127.0.0.1 or 0.0.0.0"
        raise OptionError(f"--host: expected {expected}, got {given.host!r}") from None


def check_fields(given: argparse.Namespace, changes: Mapping[str, str]) -> None:
    """Check the fields of robots that are changed, with a lab that has what robots can have sensors for.

    Raises:
        OptionError: A robot has no such field or sensor, or the field cannot have that value.
        WireError: The fields contradict each other.
    """
    target, beacon = Target("target", 1.0, 1.0, 1.0), Place(name="beacon1", x=1.0, y=1.0, kinds=(BEACON,))
    lab = Lab("", 0.0, 0.0, 2.0, 2.0, (), (beacon,), (target,), ())
    robot = ciber_robot(
        Registration("robot"), lab, gps=given.gps, beacons=given.beacon, beacon_height=given.beacon_height
    )
    try:
        equipped(robot, changes)
    except OptionError as error:
        raise OptionError(f"--option: {error}") from None
