"""List the included maps, robots and scenes, check files, and draw maps."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

from intellwheels_maps import floor, names, robot, scene
from intellwheels_maps.check import Finding
from intellwheels_maps.draw import draw
from intellwheels_maps.hospital import hospital
from intellwheels_maps.library import folder_of, is_path
from intellwheels_maps.turning import narrow_places, narrow_starts
from intellwheels_schemas.command_parser import CommandParser, naming, readable_file, whole
from intellwheels_schemas.elements import parse
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.files import write_file
from intellwheels_schemas.messages import Robot
from intellwheels_schemas.output_paths import check_output_file
from intellwheels_schemas.process import printing


class _UsageError(Exception):
    """An argument is wrong."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command and return the exit code: 0 done, 1 for an invalid file. Wrong usage exits with 2."""
    parsed = _parser().parse_args(arguments)
    try:
        with printing():
            return int(parsed.run(parsed))
        return 0  # noqa: TRY300 - the errors below are of the run
    except _UsageError as error:
        print(f"python -m intellwheels_maps: {error}", file=sys.stderr)
        return 2
    except WireError as error:
        print(error.text, file=sys.stderr)
        return 1


def _parser() -> argparse.ArgumentParser:
    parser = CommandParser(prog="python -m intellwheels_maps", description=__doc__)
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    listing = commands.add_parser("list", help="print the included maps (as `floors`), robots and scenes")
    listing.set_defaults(run=_list)

    checking = commands.add_parser(
        "check", help="check a map, robot or scene file: errors with their lines, and places where a chair cannot turn"
    )
    checking.add_argument("file", metavar="FILE", type=readable_file, help="a map, robot or scene file")
    checking.set_defaults(run=_check)

    drawing = commands.add_parser("draw", help="draw the plan of a map as SVG")
    drawing.add_argument("floor", metavar="MAP", help="an included map, a map file, or `hospital` for a generated one")
    drawing.add_argument("file", metavar="FILE.svg", type=Path, help="where to write the plan")
    drawing.set_defaults(run=_draw)

    making = commands.add_parser("hospital", help="print a generated hospital map with 120 rooms as XML")
    making.add_argument(
        "--seed", metavar="N", type=whole(0, 1 << 32), default=1, help="seed of the generator (default: %(default)s)"
    )
    making.set_defaults(run=_hospital)
    return parser


def _list(_: argparse.Namespace) -> int:
    for shelf in ("floors", "robots", "scenes"):
        print(f"{shelf}: {' '.join(names(shelf))}")
    return 0


def _check(parsed: argparse.Namespace) -> int:
    root = _root(parsed.file)
    if root == "Map":
        _warn(narrow_places(floor(parsed.file), _chairs()))
    elif root == "Robot":
        robot(parsed.file)
    elif root == "Scene":
        found = scene(parsed.file)
        folder = folder_of(parsed.file)
        bodies = {cast.name: robot(cast.robot, beside=folder) for cast in found.cast if cast.robot}
        _warn(narrow_starts(found, floor(found.map, beside=folder), bodies))
    else:
        raise WireError("field", f"{parsed.file}: expected the root Map, Robot or Scene, got {root}", str(parsed.file))
    print(f"{parsed.file}: a valid {root}")
    return 0


def _chairs() -> dict[str, Robot]:
    """Return the included wheelchairs by name."""
    return {name: body for name in names("robots") if (body := robot(name)).kind == "wheelchair"}


def _warn(findings: Iterable[Finding]) -> None:
    for finding in findings:
        print(f"warning: {finding.element}: {finding.text}", file=sys.stderr)


def _root(file: Path) -> str:
    try:
        data = file.read_bytes()
    except OSError as error:
        raise WireError("value", f"{file}: expected a readable file, got {error.strerror}", str(file)) from error
    return str(parse(data, str(file)).tag)


def _draw(parsed: argparse.Namespace) -> int:
    try:
        check_output_file(parsed.file, "FILE.svg")
        if parsed.floor != "hospital" and not is_path(parsed.floor):
            with naming("MAP"):
                floor(parsed.floor)
    except WireError as error:
        raise _UsageError(error.text) from None
    document = hospital() if parsed.floor == "hospital" else floor(parsed.floor)
    parsed.file.write_text(draw(document), encoding="utf-8")
    return 0


def _hospital(parsed: argparse.Namespace) -> int:
    print(write_file(hospital(parsed.seed)), end="")
    return 0


if __name__ == "__main__":
    sys.exit(main())
