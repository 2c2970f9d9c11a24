"""What `iw-run` checks of its options before it starts anything."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from intellwheels_experiments.run.cast_trial import check_cast
from intellwheels_maps.library import is_path, robot
from intellwheels_maps.turning import narrow_starts
from intellwheels_schemas.endpoint_form import check_free, is_free
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.link import Link, check_link
from intellwheels_schemas.messages import Map, Pace, Scene


def check_connection(options: argparse.Namespace) -> None:
    """Check the endpoints, the configuration and the ports that this command would use.

    Raises:
        WireError: One cannot be used.
        ConnectionError: A port is in use.
    """
    check_link(Link(options.world, tuple(options.listen), tuple(options.connect), options.config))
    check_free(options.listen)
    if options.view and not is_free("127.0.0.1", options.view_port):
        got = f"{options.view_port}, which is in use, perhaps by another viewer"
        hint = "; --view-port 0 takes any free one"
        raise WireError("value", f"--view-port: expected a free port, got {got}{hint}", "--view-port")


def check_speed(speed: float, pace: Pace) -> None:
    """Check that a run at this pace can have this speed.

    Raises:
        WireError: It has none.
    """
    if speed != 1.0 and pace != "realtime":
        raise WireError("value", f"--speed: expected with --pace realtime, got pace {pace}", "--speed")


def check_cast_of(scenes: Sequence[Scene], folder: Path | None, options: argparse.Namespace) -> None:
    """Check that all agents can start. Included scenes can, unless an option changes them.

    Raises:
        WireError: One cannot.
    """
    given = [f"--{name}" for name in ("mind", "option", "command") if getattr(options, name)]
    if given or is_path(options.scene):
        check_cast(scenes, folder, " or ".join(given) or "SCENE")


def narrow_warnings(chosen: Scene, ground: Map, folder: Path | None) -> list[str]:
    """Return a sentence for each simulated agent of a scene that starts where its robot cannot turn on the spot.

    Raises:
        WireError: A robot cannot be read.
    """
    bridged = {bridge.agent for bridge in chosen.bridge}
    bodies = {
        cast.name: robot(cast.robot, beside=folder) for cast in chosen.cast if cast.robot and cast.name not in bridged
    }
    return [finding.text for finding in narrow_starts(chosen, ground, bodies)]


def first_agent(chosen: Scene) -> str:
    """Return the first agent of a scene.

    Raises:
        WireError: There is none.
    """
    if not chosen.cast:
        raise WireError("value", f"SCENE: {chosen.name}: expected a Cast, got none", "SCENE")
    return chosen.cast[0].name
