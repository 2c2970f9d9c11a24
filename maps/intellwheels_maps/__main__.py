"""List the included maps, robots and scenes, check files, draw maps, and import and export floors."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

from intellwheels_maps import floor, importers, names, robot, scene
from intellwheels_maps.check import Finding
from intellwheels_maps.draw import draw
from intellwheels_maps.hospital import hospital
from intellwheels_maps.library import folder_of, imported, is_foreign, is_path
from intellwheels_maps.ros_export import export_ros
from intellwheels_maps.turning import narrow_places, narrow_starts
from intellwheels_schemas.command_parser import CommandParser, naming, number, readable_file, whole
from intellwheels_schemas.elements import parse
from intellwheels_schemas.errors import WireError, got_of
from intellwheels_schemas.extras import missing_extra
from intellwheels_schemas.files import write_file
from intellwheels_schemas.messages import Robot
from intellwheels_schemas.output_paths import add_overwrite_option, check_output_file
from intellwheels_schemas.process import printing

EXIT_CODES = "Exit codes: 0 done, also with warnings; 1 the file is invalid; 2 wrong usage."


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
    parser = CommandParser(prog="python -m intellwheels_maps", description=__doc__, epilog=EXIT_CODES)
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    def command(name: str, about: str) -> argparse.ArgumentParser:
        return commands.add_parser(name, help=about, description=f"{about[0].upper()}{about[1:]}.", epilog=EXIT_CODES)

    listing = command("list", "print the included maps (as `floors`), robots and scenes")
    listing.set_defaults(run=_list)

    checking = command(
        "check",
        "check a map, robot or scene file, and print errors with their lines, and places where a chair cannot turn",
    )
    checking.add_argument("file", metavar="FILE", type=readable_file, help="a map, robot or scene file")
    checking.set_defaults(run=_check)

    importing = command("import", "convert a floor plan made for another program to a map, and list what was left out")
    importing.add_argument(
        "file", metavar="FILE[#LEVEL]", type=Path,
        help=f"the floor ({', '.join(importers.FORMATS)}; or .xml, a lab of Ciber-Rato); #LEVEL chooses a level of a "
        "building; .xml needs no extra, .ifc the extra `ifc`, the others `floors`",
    )  # fmt: skip
    importing.add_argument(
        "-o", "--output", metavar="FILE.xml", type=Path, required=True, help="where to write the map"
    )
    add_overwrite_option(importing)
    importing.set_defaults(run=_import)

    exporting = command(
        "export", "write a map for the ROS map server (image, YAML, places and doors); needs the extra `floors`"
    )
    exporting.add_argument("floor", metavar="MAP", help="an included map, or a map file")
    exporting.add_argument(
        "-o", "--output", metavar="FILE.yaml", type=Path, required=True,
        help="where to write; the image is FILE.pgm, and the places and doors are FILE.places.yaml",
    )  # fmt: skip
    exporting.add_argument(
        "--resolution", metavar="M", type=number("metres", 0.001, 10.0), default=0.05,
        help="length of a cell in metres, in [0.001, 10] (default: %(default)s)",
    )  # fmt: skip
    add_overwrite_option(exporting)
    exporting.set_defaults(run=_export)

    drawing = command("draw", "draw the plan of a map as SVG")
    drawing.add_argument("floor", metavar="MAP", help="an included map, a map file, or `hospital` for a generated one")
    drawing.add_argument("file", metavar="FILE.svg", type=Path, help="where to write the plan")
    add_overwrite_option(drawing)
    drawing.set_defaults(run=_draw)

    making = command("hospital", "print a generated hospital map with 120 rooms as XML")
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
    root = "Map" if is_foreign(parsed.file) else _root(parsed.file)
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


def _import(parsed: argparse.Namespace) -> int:
    _check_output(parsed.output, ".xml", overwrite=parsed.overwrite)
    if not is_foreign(parsed.file):
        known = ", ".join(importers.FORMATS)
        raise _UsageError(f"FILE: expected a name that ends in {known}, or a lab of Ciber-Rato, got {parsed.file}")
    found = imported(parsed.file)
    parsed.output.write_text(write_file(found.map), encoding="utf-8")
    for line in found.left_out:
        print(f"left out: {line}", file=sys.stderr)
    document = found.map
    places = len(document.grid.position) if document.grid else 0
    print(
        f"{parsed.output}: walls={len(document.wall)} obstacles={len(document.obstacle)} zones={len(document.zone)} "
        f"doorways={len(document.doorway)} doors={sum(doorway.door is not None for doorway in document.doorway)} "
        f"places={places} routes={len(document.route)} left-out={found.things}"
    )
    return 0


def _export(parsed: argparse.Namespace) -> int:
    stem = parsed.output.name.removesuffix(".yaml")
    image, places = (parsed.output.with_name(f"{stem}{ending}") for ending in (".pgm", ".places.yaml"))
    for file, ending in ((parsed.output, ".yaml"), (image, ".pgm"), (places, ".yaml")):
        _check_output(file, ending, overwrite=parsed.overwrite)
    lacking = missing_extra("floors")
    if lacking is not None:
        raise _UsageError(lacking)
    with naming("MAP"):
        document = floor(parsed.floor)
    exported = export_ros(document, parsed.resolution, image.name)
    parsed.output.write_text(exported.head, encoding="utf-8")
    image.write_bytes(exported.image)
    places.write_text(exported.places, encoding="utf-8")
    print(f"{parsed.output}: {exported.columns} x {exported.rows} cells of {parsed.resolution:g} m")
    return 0


def _check_output(file: Path, ending: str, *, overwrite: bool) -> None:
    try:
        check_output_file(file, "--output", overwrite=overwrite)
    except WireError as error:
        raise _UsageError(error.text) from None
    if not file.name.endswith(ending):
        raise _UsageError(f"--output: expected a name that ends in {ending}, got {file}")


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
        raise WireError("value", f"{file}: expected a readable file, got {got_of(error)}", str(file)) from error
    return str(parse(data, str(file)).tag)


def _draw(parsed: argparse.Namespace) -> int:
    try:
        check_output_file(parsed.file, "FILE.svg", overwrite=parsed.overwrite)
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
