"""The command line of `iw-ros`, without the options that every command shares."""

from __future__ import annotations

import argparse
import os
from collections.abc import Mapping
from typing import Final

from intellwheels_agents.options import OptionError
from intellwheels_agents.ros_gateway.rmw_wire import LARGEST_DOMAIN
from intellwheels_schemas.command_parser import CommandParser, add_retry_option, number, whole
from intellwheels_schemas.errors import wrong_value

EXAMPLES: Final = """\
examples:
  a chair that ROS nodes drive, with /clock, /map and the services of the world
      iw-ros --name chair1 --robot lidar-chair
  a second chair of the same world
      iw-ros --name chair2 --robot intellwheels --no-world
  the mind of a chair that is there, such as one of iw-bridge
      iw-ros --name chair1 --role mind
  a chair that drives by itself: its topics, and goals from RViz
      iw-agent navigate --name chair1 &  iw-ros --name chair1 --role watch
  only /clock, /map and the services
      iw-ros
  the description of a robot, for robot_state_publisher
      iw-ros --urdf intellwheels

A ROS node with rmw_zenoh connects to a router at tcp/localhost:7447. Through iw-router, nodes reach iw-ros but not each
other. With several nodes that talk to each other, such as Nav2, start the router of ROS, rmw_zenohd, in its place.
Either connect the simulator and iw-ros to this router (--connect of each), or connect iw-ros to the simulator with
--connect and to the router with --ros-connect. Nodes need the parameter use_sim_time. A `-` in a name becomes `_` in
ROS.

Standard output has the lines `ready domain=...`, `joined agent=...`, `run agent=...`, `watching agent=...`,
`left agent=...`.
Exit codes: 0 done, 1 refused or failed, 2 wrong usage. The command needs the extra `ros`.
"""
DEFAULT_ROBOT: Final = "intellwheels"
ROLES: Final = ("both", "mind", "watch")
LOCALISATIONS: Final = ("start", "truth", "none")
DOMAIN_VARIABLE: Final = "ROS_DOMAIN_ID"


def parser() -> argparse.ArgumentParser:
    """Return the parser of this command's own options."""
    result = CommandParser(
        prog="iw-ros",
        description="Show a world to ROS 2 nodes with rmw_zenoh, and let them drive a chair. This machine needs no ROS "
        "installation.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    chair = result.add_argument_group("chair")
    chair.add_argument("--name", metavar="NAME", help="agent whose topics are /NAME/... (default: no chair)")
    chair.add_argument(
        "--role", choices=ROLES, default="both",
        help="both: a body that ROS drives; mind: ROS drives a body that another process provides; watch: another mind "
        "drives, and receives goals from ROS (default: both)",
    )  # fmt: skip
    chair.add_argument("--robot", metavar="NAME|FILE", help=f"the body, with role both (default: {DEFAULT_ROBOT})")
    chair.add_argument(
        "--option",
        action="append",
        default=[],
        metavar="FIELD=VALUE",
        help="change a field of --robot; may be repeated",
    )
    chair.add_argument("--place", metavar="PLACE", help="place of the map to start at (default: any free place)")
    chair.add_argument(
        "--localisation", choices=LOCALISATIONS, default="start",
        help="transform from map to odom. start: the start pose, so that the chair drifts on the map; truth: the true "
        "pose, from a truth sensor; none: another node publishes it, such as AMCL (default: start)",
    )  # fmt: skip
    chair.add_argument(
        "--await", dest="await_command", type=number("seconds", 0.0, 3600.0), default=0.0, metavar="S",
        help="in lockstep, wait at each tick up to S seconds, in [0, 3600] and less than the simulator's --deadline, "
        "for a velocity command that answers the tick (default: 0)",
    )  # fmt: skip
    graph = result.add_argument_group("ROS")
    graph.add_argument(
        "--domain",
        type=whole(0, LARGEST_DOMAIN),
        metavar="N",
        help=f"domain of ROS, in [0, {LARGEST_DOMAIN}] (default: ${DOMAIN_VARIABLE}, or 0)",
    )
    graph.add_argument("--humble", action="store_true", help="for nodes of ROS 2 Humble, which has no type hashes")
    graph.add_argument(
        "--ros-connect", action="append", default=[], metavar="ENDPOINT",
        help="endpoint of the router of the ROS nodes; may be repeated (default: as the world's)",
    )  # fmt: skip
    graph.add_argument(
        "--no-world", action="store_true",
        help="do not provide /clock, /map and the services: another iw-ros of this world does",
    )  # fmt: skip
    graph.add_argument(
        "--resolution", type=number("metres", 0.001, 10.0), metavar="M",
        help="size of a cell of /map in metres, in [0.001, 10] (default: the smallest of 0.05, 0.1, 0.2, ... "
        "with which the map has at most a million cells)",
    )  # fmt: skip
    result.add_argument("--urdf", metavar="NAME|FILE", help="print the description of a robot, and exit")
    add_retry_option(result)
    return result


def check_together(given: argparse.Namespace) -> None:
    """Check that no option is given that another one makes meaningless.

    Raises:
        OptionError: One is; the text names it.
    """
    for option, value in (("--robot", given.robot), ("--option", given.option or None), ("--place", given.place)):
        if value is not None and (given.name is None or given.role != "both"):
            got = "no --name" if given.name is None else f"--role {given.role}"
            raise OptionError(f"{option}: expected a chair with role both, got {got}")
    needs_chair = (
        ("--role", given.role != "both"), ("--localisation", given.localisation != "start"),
        ("--await", given.await_command > 0.0), ("--no-world", given.no_world),
    )  # fmt: skip
    for option, is_given in needs_chair:
        if is_given and given.name is None:
            raise OptionError(f"{option}: expected with --name, got none")
    if given.await_command > 0.0 and given.role == "watch":
        raise OptionError("--await: expected a role with a mind, got --role watch")
    if given.resolution is not None and given.no_world:
        raise OptionError("--resolution: expected without --no-world, got both")


def domain_of(given: argparse.Namespace, environment: Mapping[str, str] = os.environ) -> int:
    """Return the domain of ROS: that of the option, of the variable of ROS, or 0.

    Raises:
        WireError: The variable is no domain.
    """
    if given.domain is not None:
        return int(given.domain)
    text = environment.get(DOMAIN_VARIABLE, "") or "0"
    if not (text.isascii() and text.isdigit() and len(text) <= 3 and int(text) <= LARGEST_DOMAIN):
        raise wrong_value(DOMAIN_VARIABLE, f"a whole number in [0, {LARGEST_DOMAIN}]", repr(text[:40]))
    return int(text)
