"""Writes a scene for a floor alone, or for a floor and its doors: what `iw-run --floor` runs."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Final

import msgspec

from intellwheels_maps import floor, names, robot
from intellwheels_maps.door_leaves import door_leaves
from intellwheels_schemas.codec import VERSION
from intellwheels_schemas.command_parser import naming
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.files import write_file
from intellwheels_schemas.messages import Cast, End, Map, Scene, Timeout

FLOOR_SECONDS: Final = 60.0
"""Simulated time after which a run without a page ends."""


def add_scene_options(parser: argparse.ArgumentParser) -> None:
    """Add the argument and the options that say what is run."""
    parser.add_argument(
        "scene", metavar="SCENE", nargs="?",
        help=f"an included scene ({', '.join(names('scenes'))}) or an XML file; none with --floor",
    )  # fmt: skip
    parser.add_argument(
        "--floor", "--map", metavar="MAP",
        help="run a map in place of a scene: an included map, or a map file of any format (a floor plan made for "
        "another program needs the extra `floors`, or `ifc` if it is .ifc; a lab file of Ciber-Rato needs none); it "
        f"has no agents without --doors, and runs for {FLOOR_SECONDS:g} s of simulated time or, with --view, until "
        "Ctrl-C; --listen lets your agents join",
    )  # fmt: skip
    parser.add_argument("--doors", action="store_true", help="with --floor: start an agent for each leaf of its doors")


def check_scene_options(options: argparse.Namespace) -> None:
    """Check that there is either a scene or a floor.

    Raises:
        WireError: There is none or both, or doors without a floor.
    """
    if (options.scene is None) == (options.floor is None):
        got = "none" if options.scene is None else "both"
        raise WireError("value", f"SCENE: expected either a scene or --floor, got {got}", "SCENE")
    if options.doors and options.floor is None:
        raise WireError("value", "--doors: expected with --floor, got a scene", "--doors")


def write_floor_scene(name_or_path: str, folder: Path, *, doors: bool, forever: bool) -> str:
    """Write a scene, its map and the robots of its doors, and return the path of the scene.

    Args:
        name_or_path: An included map, or a map file of any format.
        folder: Where to write, an empty folder.
        doors: Whether the doors of the map are agents.
        forever: Whether the run has no end.

    Raises:
        WireError: There is no such map, or it has no doors.
    """
    with naming("--floor"):
        found: Map = floor(name_or_path)
    cast: tuple[Cast, ...] = ()
    if doors:
        leaves = door_leaves(found, robot("door"))
        for line in leaves.left_out:
            sys.stderr.write(f"iw-run: warning: {line}\n")
        if not leaves.cast:
            raise WireError("value", f"--doors: expected a floor with doors, got {found.name!r} without", "--doors")
        found = leaves.floor
        for name, body in leaves.robots.items():
            (folder / f"{name}.xml").write_text(write_file(body), encoding="utf-8")
        cast = tuple(msgspec.structs.replace(one, robot=f"{one.robot}.xml") for one in leaves.cast)
    (folder / "floor.xml").write_text(write_file(found), encoding="utf-8")
    end = None if forever else End(timeout=Timeout(seconds=FLOOR_SECONDS))
    # In lockstep, a world without agents waits for the first one.
    scene = Scene(
        format=VERSION, name=found.name, title=found.title, map="floor.xml", cast=cast, end=end,
        pace="lockstep" if cast else "free",
    )  # fmt: skip
    path = folder / "scene.xml"
    path.write_text(write_file(scene), encoding="utf-8")
    return str(path)
