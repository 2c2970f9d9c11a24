"""The command line of `iw-bridge`, without the options that every command shares."""

from __future__ import annotations

import argparse
from typing import Final

from intellwheels_agents.bridge.driver_choice import DRIVERS
from intellwheels_agents.bridge.luci_options import add_luci_options
from intellwheels_agents.bridge.pose_source import DRIFT, POSE_SOURCES
from intellwheels_agents.bridge.rnet_options import add_bus_options
from intellwheels_agents.bridge.sensor_merge import SENSORS
from intellwheels_schemas import messages
from intellwheels_schemas.command_parser import CommandParser, add_retry_option, like_field, number, share, whole

EXAMPLES = """\
examples:
  a chair with its controller on a serial line; any program that joins with role mind can drive it
      iw-bridge serial --port /dev/ttyUSB0 --name chair1 --robot intellwheels --place start1
      iw-agent avoid --name chair1 --role mind
  a chair with a LUCI unit, driven over the network
      iw-bridge luci --address 192.168.1.50 --name chair1 --robot intellwheels --place start1
  a chair with R-Net electronics, which its user drives: the bridge listens to the CAN bus and sends nothing
      iw-bridge rnet --channel can0 --name chair1 --robot intellwheels --place start1
  a chair in the simulation `lab` instead of hardware; its right wheel is 0.2 % too large, its pose is raw odometry
      iw-server --map ward
      iw-server --world lab --listen tcp/127.0.0.1:7448 --map ward --hide-truth
      iw-bridge world --lab-connect tcp/127.0.0.1:7448 --name chair1 --place lobby1 --chair-option WheelRatio=1.002
  the same, with its pose corrected once a second by a position with an error of 5 cm
      iw-bridge world --lab-connect tcp/127.0.0.1:7448 --name chair1 --place lobby1 --chair-option WheelRatio=1.002 \\
          --pose corrected --fix-every 20 --fix-noise 0.05

Two worlds in lockstep advance together, tick by tick. Give each server a --deadline that is longer than the slowest
tick of the other.

Standard output has lines that begin with one of these words:
    hardware                        the first reading of the chair has arrived
    joined, run, left               the bridge joined the simulation, a new run began, the bridge left
    lab-joined, lab-run, lab-left   the same in the laboratory
    held, ready, resumed            with --resume confirm: the motors are off, Enter is awaited, the chair drives on
    bridged                         the bridge has ended; this line of output counts:
        poses, readings             poses reported to the simulator, readings of the chair
        overtaken, missing          readings dropped because a newer one was there; readings that never came
        lost_up, lost_down          readings and powers dropped by --loss
        stale                       how often the chair fell silent
        age_mean, age_max           age of the reported poses, in s
        garbage, reopened, unwritten    of a real chair: messages that were malformed or wrong, how often the connection
                                    was opened again, powers that could not be sent
        injected                    with rnet: joystick frames sent
    chair                           with rnet: battery and speed setting in percent, largest motor current, on change
    simulator-gone, simulator-back, removed, replaced, taken, released, mind-joined, mind-left, mind-lost,
    mind-returned, body-lost, body-returned
                                    events of the chair
On standard error, `erred code=late` says that a pose came more than a tick late and was not used; it is printed for
the 1st, 10th, 100th, ... of them. On a busy machine a few do no harm, as the next tick has another pose.
Exit codes: 0 done, 1 refused or failed, 2 wrong usage. The driver serial needs the extra `bridge`, luci the
extra `luci`, and rnet the extra `rnet`.
"""
DEFAULT_ROBOT: Final = "intellwheels"
MAX_COUNT: Final = 2**31 - 1
"""Largest value of --baud and --fix-every."""
MAX_OFFSET: Final = 1e12
"""Largest clock offset, s: the largest time stamp."""
_DELAY = number("seconds", 0.0, 3600.0)


def parser() -> argparse.ArgumentParser:
    """Return the parser of this command's own options."""
    result = CommandParser(
        prog="iw-bridge",
        description="Bring a real chair, or a stand-in for one, into a simulation, as the body of an agent.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    result.add_argument(
        "driver",
        choices=tuple(DRIVERS),
        help="where the chair is: in another simulation, the laboratory (world), on a serial line (serial), behind a "
        "LUCI unit on the network (luci), or on the CAN bus of R-Net electronics (rnet)",
    )
    body = result.add_argument_group("body")
    body.add_argument(
        "--name", required=True, metavar="NAME", help="name of the agent; with the driver world, in both worlds"
    )
    body.add_argument(
        "--robot", default=DEFAULT_ROBOT, metavar="NAME|FILE",
        help=f"the body and its virtual sensors (default: {DEFAULT_ROBOT})",
    )  # fmt: skip
    body.add_argument(
        "--option",
        action="append",
        default=[],
        metavar="FIELD=VALUE",
        help="change a field of --robot; may be repeated",
    )
    body.add_argument(
        "--resume", choices=("auto", "confirm"),
        help="what the chair does after the simulator has been gone, or silent for 1 s: auto drives on, confirm waits "
        "until Enter is pressed in this terminal (default: confirm for real hardware, auto for simulated)",
    )  # fmt: skip
    body.add_argument(
        "--place",
        metavar="PLACE",
        help="place of the map at which the chair stands when the "
        "bridge starts (default: a free place that the simulator chooses)",
    )
    body.add_argument(
        "--sensors", choices=SENSORS, default="virtual",
        help="which sensors the mind gets: the virtual ones of --robot, the real sonars of --chair, or both; with "
        "both, a real sonar is named real-ID; with the driver luci, real and both include its inertial unit; with "
        "rnet, only virtual is possible "
        "(default: virtual)",
    )  # fmt: skip
    chair = result.add_argument_group("the chair")
    chair.add_argument(
        "--chair",
        metavar="NAME|FILE",
        help="robot with the nominal dimensions and the sonars of the chair (default: same as --robot)",
    )
    chair.add_argument(
        "--chair-option", action="append", default=[], metavar="FIELD=VALUE",
        help="change a field of --chair, such as WheelRatio=1.002 with the driver world; may be repeated",
    )  # fmt: skip
    chair.add_argument(
        "--hardware", choices=("real", "simulated"),
        help="what the chair is; a real one can join only in real time at speed 1 "
        "(default: simulated for world, real for the others)",
    )  # fmt: skip
    chair.add_argument(
        "--joystick", action="store_true", help="send the input of the chair's own joystick to the simulation"
    )
    _add_pose_options(result)
    _add_line_options(result)
    result.add_argument(
        "--encoding", choices=("json", "xml"), default="json", help="encoding of messages (default: json)"
    )
    add_retry_option(result, "the chair or the simulator")
    return result


def _add_pose_options(result: argparse.ArgumentParser) -> None:
    pose = result.add_argument_group("pose")
    pose.add_argument(
        "--pose", choices=POSE_SOURCES, default="raw", help="source of poses. raw: encoders and nominal dimensions; "
        "calibrated: encoders and calibrated dimensions; corrected: as calibrated, plus position fixes; with rnet, "
        "which has no encoders, the wheels' travel follows from the joystick and the speed setting (default: raw)",
    )  # fmt: skip
    for name, meaning in (
        ("--wheel-ratio", "diameter of the right wheel over that of the left wheel (UMBmark's E_d)"),
        ("--wheel-scale", "mean wheel diameter over the nominal one"),
        ("--track-ratio", "track over the nominal one (UMBmark's E_b)"),
    ):
        pose.add_argument(
            name,
            type=like_field(messages.FigureRatio),
            default=1.0,
            metavar="R",
            help=f"calibration, for calibrated and corrected poses: {meaning}, in [0.5, 2] (default: 1)",
        )
    pose.add_argument(
        "--drift", type=like_field(messages.WayVariance), metavar="K",
        help=f"variance of the travel of a wheel, in m2 per metre, in [0, 1], for the covariance of poses "
        f"(default: {DRIFT:g}; with rnet, which has no encoders, {DRIVERS['rnet'].drift:g})",
    )  # fmt: skip
    pose.add_argument(
        "--fix-every", type=whole(1, MAX_COUNT), default=20, metavar="TICKS",
        help="driver world, corrected poses: ticks between position fixes (measured positions), for a chair without a "
        "GPS of its own (default: 20)",
    )  # fmt: skip
    pose.add_argument(
        "--fix-noise", type=like_field(messages.Length), default=0.05, metavar="M",
        help="driver world, corrected poses: standard deviation of a fix on each axis in metres, in [0, 1000], for a "
        "chair without a GPS of its own (default: 0.05)",
    )  # fmt: skip
    pose.add_argument(
        "--clock-offset", type=number("seconds", -MAX_OFFSET, MAX_OFFSET), default=0.0, metavar="S",
        help="seconds added to the time stamps of poses: the simulator's clock minus this machine's (default: 0)",
    )  # fmt: skip


def _add_line_options(result: argparse.ArgumentParser) -> None:
    world = result.add_argument_group("driver world")
    world.add_argument(
        "--lab-world", default="lab", metavar="NAME", help="name of the other simulation, the laboratory (default: lab)"
    )
    world.add_argument(
        "--lab-connect", action="append", default=[], metavar="ENDPOINT",
        help="endpoint of the laboratory; may be repeated (default: that of the simulation)",
    )  # fmt: skip
    world.add_argument(
        "--lab-place", metavar="PLACE", help="place where the chair starts in the laboratory (default: same as --place)"
    )
    world.add_argument(
        "--lab-role", choices=("both", "mind"), default="both",
        help="both: this bridge adds the chair to the laboratory; mind: the chair is there already (default: both)",
    )  # fmt: skip
    line = result.add_argument_group("driver serial")
    line.add_argument(
        "--port", metavar="DEVICE|URL", help="serial device such as /dev/ttyUSB0, or socket://HOST:PORT; required"
    )
    line.add_argument(
        "--baud",
        type=whole(1, MAX_COUNT),
        default=115_200,
        metavar="N",
        help="speed of the line in bits a second (default: 115200)",
    )
    add_luci_options(result)
    rnet = result.add_argument_group("driver rnet")
    add_bus_options(rnet)
    rnet.add_argument(
        "--allow-injection", action="store_true",
        help="drive the chair by joystick frames on its bus, against the maker's intention; without it, the bridge "
        "only listens and sends nothing",
    )  # fmt: skip
    faults = result.add_argument_group(
        "faults for experiments, on the line between chair and bridge, in both directions"
    )
    faults.add_argument(
        "--delay", type=_DELAY, default=0.0, metavar="S", help="delay in seconds, in [0, 3600] (default: 0)"
    )
    faults.add_argument(
        "--jitter",
        type=_DELAY,
        default=0.0,
        metavar="S",
        help="largest additional delay in seconds, in [0, 3600] (default: 0)",
    )
    faults.add_argument(
        "--loss", type=share, default=0.0, metavar="SHARE", help="share of messages lost, in [0, 1] (default: 0)"
    )
    faults.add_argument(
        "--seed", type=like_field(messages.Seed), default="1", metavar="TEXT", help="seed of the faults (default: 1)"
    )
