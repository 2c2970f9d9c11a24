"""`iw-ros`: shows a world to ROS 2 nodes."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from intellwheels_agents.options import OptionError
from intellwheels_agents.robot_document import equipped, fields_of
from intellwheels_agents.ros_gateway import ros_options
from intellwheels_agents.ros_gateway.ros_names import sensor_names
from intellwheels_agents.ros_gateway.urdf import urdf
from intellwheels_maps import robot as robot_file
from intellwheels_maps.library import is_path
from intellwheels_schemas.command_parser import naming
from intellwheels_schemas.endpoint_form import check_endpoint
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.extras import missing_extra
from intellwheels_schemas.link import Link, add_link_options, link_of
from intellwheels_schemas.messages import Robot
from intellwheels_schemas.names import check_agent, check_word
from intellwheels_schemas.process import add_process_options, printing, stop_on_signals


def parser() -> argparse.ArgumentParser:
    """Return the command line."""
    result = ros_options.parser()
    add_link_options(result)
    add_process_options(result)
    return result


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code: 0 done, 1 refused or failed, 2 wrong usage."""
    given = parser().parse_args(arguments)
    # First, because a signal may arrive while the other arguments are read.
    stop = stop_on_signals(given.lifeline)
    try:
        if given.urdf is not None:
            return _print_urdf(given.urdf)
        ros_options.check_together(given)
        where, ros = link_of(given), _ros_link(given)
        domain = ros_options.domain_of(given)
        agent = None if given.name is None else check_agent(given.name, "--name")
        if given.place is not None:
            check_word(given.place, "--place")
        body = _body(given) if agent is not None and given.role == "both" else None
        lacking = missing_extra("ros")
        if lacking is not None:
            _log(lacking)
            return 2
        from intellwheels_agents.ros_gateway.gateway_process import GatewayProcess  # noqa: PLC0415 - needs the extra

        return GatewayProcess(given, agent, body, where, ros or where, domain, stop).run()
    except (OptionError, WireError) as error:
        _log(str(error))
        return 2
    except ConnectionError as error:
        _log(str(error))
        return 1


def _print_urdf(name: str) -> int:
    with naming("--urdf"):
        text = urdf(robot_file(name), name.rpartition("/")[2].removesuffix(".xml") if is_path(name) else name)
    with printing():
        sys.stdout.write(text)
    return 0


def _ros_link(given: argparse.Namespace) -> Link | None:
    """Return the link to the ROS nodes if it is not that of the world."""
    for endpoint in given.ros_connect:
        check_endpoint(endpoint, "--ros-connect")
    return Link(given.world, connect=tuple(given.ros_connect)) if given.ros_connect else None


def _body(given: argparse.Namespace) -> Robot:
    """Return the robot of the chair, with the changes that options make."""
    with naming("--robot"):
        robot = robot_file(ros_options.DEFAULT_ROBOT if given.robot is None else given.robot)
    try:
        robot = equipped(robot, fields_of(given.option))
    except OptionError as error:
        raise OptionError(f"--option: {error}") from None
    with naming("--robot"):
        sensor_names(robot)
    return robot


def _log(line: str) -> None:
    print(f"iw-ros: {line}", file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
