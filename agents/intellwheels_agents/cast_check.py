"""Checks the cast of a scene before anything starts: minds, their options, fields of robots, and starting places.

`iw-run` starts it as a process, because rooms do not import each other: scenes come on standard input, one a line, as
JSON. It prints nothing if all can start. The first fault goes to standard error, with exit code 2.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from intellwheels_agents import minds
from intellwheels_agents.mind_trial import check_mind_file, check_mind_options
from intellwheels_agents.options import OptionError, Options
from intellwheels_agents.robot_document import default_robot, equipped, split_options
from intellwheels_maps import floor, robot
from intellwheels_maps.library import is_path
from intellwheels_maps.starts import check_starts
from intellwheels_schemas.codec import Encoding, decode
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Cast, Map, Robot, Scene


def check_cast(scene: Scene, folder: Path | None) -> None:
    """Check that every agent of a scene can start.

    Args:
        scene: The scene.
        folder: Where relative paths in it start; None: the working directory.

    Raises:
        OptionError: A mind, an option or a field of a robot is wrong; the text names the agent.
        WireError: A robot is wrong, or an agent starts in something.
    """
    ground = floor(scene.map, beside=folder)
    bridged = {bridge.agent for bridge in scene.bridge}
    bodies: dict[str, Robot] = {}
    for cast in scene.cast:
        if not cast.mind:
            continue  # a program of another language brings its body
        try:
            body = _checked(cast, folder, ground, own_body=cast.name not in bridged)
        except (OptionError, WireError) as error:
            raise OptionError(f"agent {cast.name!r}: {str(error).removeprefix('MIND: ')}") from error
        if cast.name not in bridged:
            bodies[cast.name] = body
    findings = check_starts(scene, ground, bodies)
    if findings:
        raise OptionError(findings[0].text)


def _checked(cast: Cast, folder: Path | None, ground: Map, *, own_body: bool) -> Robot:
    """Return the body of an agent, its mind and options checked."""
    robot_options, mind_options = split_options({option.name: option.value for option in cast.option})
    body = equipped(robot(cast.robot or default_robot(cast.mind), beside=folder), robot_options)
    if is_path(cast.mind):
        check_mind_file((folder or Path()) / cast.mind)
        return body
    source = minds.find(cast.mind)
    body = source.equip(body, Options(mind_options))
    check_mind_options(source, body, mind_options, own_body=own_body, agent=cast.name, fetch_map=lambda: ground)
    return body


def main(arguments: Sequence[str] | None = None) -> int:
    """Check the scenes on standard input, and return the exit code: 0 all can start, 2 not."""
    parser = argparse.ArgumentParser(prog="python -m intellwheels_agents.cast_check", description=__doc__)
    parser.add_argument("--folder", type=Path, help="where relative paths in the scenes start")
    folder: Path | None = parser.parse_args(arguments).folder
    try:
        for line in sys.stdin.buffer:
            check_cast(decode(Scene, line, Encoding.JSON), folder)
    except (OptionError, WireError) as error:
        sys.stderr.write(f"{error}\n")
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
