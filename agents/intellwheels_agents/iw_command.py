"""`iw`: every command of IntellWheels under one name, lists of what is included, and shell completion.

`iw run figure6` is `iw-run figure6`. The commands are found by their entry points, because rooms do not import each
other.
"""

from __future__ import annotations

import argparse
import ast
import importlib
import sys
from collections.abc import Callable, Sequence
from importlib.metadata import EntryPoint, entry_points
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path

import shtab

from intellwheels_agents import minds
from intellwheels_maps import floor, names, robot, scene
from intellwheels_schemas.command_parser import CommandParser
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.explain import did_you_mean
from intellwheels_schemas.messages import Place
from intellwheels_schemas.process import printing
from intellwheels_schemas.version import add_version_option

_PREFIX = "iw-"
_ORDER = ("run", "server", "agent", "viewer", "record", "joystick", "bridge")
"""The commands that the help names first; the others follow by name."""


def _found_commands() -> dict[str, EntryPoint]:
    found = {
        point.name.removeprefix(_PREFIX): point
        for point in entry_points(group="console_scripts")
        if point.name.startswith(_PREFIX) and point.module.startswith("intellwheels_")
    }
    return {name: found[name] for name in [*(name for name in _ORDER if name in found), *sorted(found)]}


def about(module: str) -> str:
    """Return what a command does: the first line of the docstring of its module, behind the command's name.

    The module is not imported: it may need an extra.
    """
    package, *names = module.split(".")
    spec = find_spec(package)
    folder = Path(next(iter(spec.submodule_search_locations or ()), "")) if spec is not None else Path()
    path = folder.joinpath(*names)
    file = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
    with file.open(encoding="utf-8") as lines:
        return lines.readline().strip().strip('"').partition("`: ")[2].rstrip(".")


_POINTS = _found_commands()
COMMANDS = {name: about(point.module) for name, point in _POINTS.items()}
"""The commands and what they do; `iw NAME` is `iw-NAME`. They are the entry points of the installed distribution."""

KINDS = ("floors", "maps", "robots", "scenes", "minds", "places")


def parser() -> argparse.ArgumentParser:
    """Return the parser of `iw`, without the commands' own options."""
    width = max(map(len, (*COMMANDS, "list KIND", "completion SHELL"))) + 2
    lines = "\n".join(f"  iw {name:{width}}{text}" for name, text in COMMANDS.items())
    found = CommandParser(
        prog="iw",
        usage="iw [-h] [--version] COMMAND ...",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        description="IntellWheels: a simulation service for intelligent wheelchairs.",
        epilog=(
            f"commands (each with its own --help):\n{lines}\n"
            f"  iw {'list KIND':{width}}lists what is included: {', '.join(KINDS)}\n"
            f"  iw {'completion SHELL':{width}}prints the completion script for {', '.join(shtab.SUPPORTED_SHELLS)}\n\n"
            "examples:\n"
            "  iw run figure6 --view          three chairs, a table and a door, on a page in your browser\n"
            "  iw list maps                   the included maps; `floors` lists the same\n"
            "  iw list places ward            the places where an agent can start, or drive to\n"
            '  eval "$(iw completion bash)"   completion in this shell\n\n'
            "Exit codes: those of the command; of iw itself 0 done, 2 wrong usage."
        ),
    )
    add_version_option(found)
    found.add_argument(
        "command", metavar="COMMAND", choices=[*COMMANDS, "list", "completion"],
        help="one of the commands below; iw COMMAND is iw-COMMAND, except list and completion",
    )  # fmt: skip
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command and return its exit code: 0 done, 1 refused or failed, 2 wrong usage."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    if words and not words[0].startswith("-") and words[0] not in (*COMMANDS, "list", "completion"):
        known = [*COMMANDS, "list", "completion"]
        hint = did_you_mean(words[0], known)
        print(f"iw: expected one of {', '.join(known)}, got {words[0]!r}{hint}", file=sys.stderr)
        return 2
    if not words:
        parser().print_help()
        return 2
    name = parser().parse_args(words[:1]).command
    if name in ("list", "completion"):
        with printing():
            return _list(words[1:]) if name == "list" else _completion(words[1:])
        return 0
    sys.argv[0] = f"{_PREFIX}{name}"
    command: Callable[[Sequence[str]], int] = _POINTS[name].load()
    return command(words[1:])


def _list(words: Sequence[str]) -> int:
    """Print what is included, one name a line, with its title where it has one."""
    about = (
        "List what is included, or the places of a map. `floors` and `maps` list the same. Of a place, x and y (in "
        "metres) and the heading are in the frame of the map, not of its site. Exit codes: 0 done, 2 wrong usage."
    )
    wanted = CommandParser(prog="iw list", description=about)
    wanted.add_argument("kind", metavar="KIND", choices=KINDS, help=", ".join(KINDS))
    wanted.add_argument("floor", metavar="MAP", nargs="?", help="for places: an included map, or a map file")
    given = wanted.parse_args(words)
    if (given.kind == "places") != (given.floor is not None):
        expected = "expected a MAP after places" if given.floor is None else f"expected no MAP after {given.kind}"
        wanted.error(f"{expected}, got {'none' if given.floor is None else repr(given.floor)}")
    try:
        lines = _lines(given.kind, given.floor)
    except WireError as error:
        print(f"iw list: MAP: {error}", file=sys.stderr)
        return 2
    width = max((len(name) for name, _ in lines), default=0) + 2
    for name, text in lines:
        print(f"{name:{width}}{text}".rstrip())
    return 0


def _lines(kind: str, floor_name: str | None) -> list[tuple[str, str]]:
    if kind == "places":
        found = floor(floor_name or "")
        places = found.grid.position if found.grid is not None else ()
        return [(place.name, _whom(place)) for place in places]
    if kind == "minds":
        return [(name, _summary(name)) for name in minds.names()]
    if kind in ("floors", "maps"):
        return [(name, floor(name).title or "") for name in names("floors")]
    if kind == "robots":
        return [(name, robot(name).kind or "") for name in names("robots")]
    return [(name, scene(name).title or "") for name in names("scenes")]


def _whom(place: Place) -> str:
    """Return the pose of a place and the kinds of body it is for, as text."""
    where = f"x={place.x:g} y={place.y:g} heading={place.heading_deg:g} deg"
    return f"{where}, for {', '.join(place.kinds)}" if place.kinds else where


def _summary(mind: str) -> str:
    """Return the first line of a mind's docstring, read without importing the mind."""
    text = files(minds.__name__).joinpath(f"{mind}.py").read_text()
    return (ast.get_docstring(ast.parse(text)) or "").partition("\n")[0]


def _parser_of(module: str) -> argparse.ArgumentParser:
    """Return the parser of the command whose `main` is in a module, or in the package of that name."""
    found = importlib.import_module(module)
    if not hasattr(found, "parser"):
        found = importlib.import_module(f"{module}.__main__")
    made: argparse.ArgumentParser = found.parser()
    return made


def _completion(words: Sequence[str]) -> int:
    """Print a completion script for all commands."""
    wanted = CommandParser(prog="iw completion", description="Print a completion script for a shell.")
    wanted.add_argument(
        "shell", metavar="SHELL", choices=shtab.SUPPORTED_SHELLS, help=", ".join(shtab.SUPPORTED_SHELLS)
    )
    shell = wanted.parse_args(words).shell
    whole = argparse.ArgumentParser(prog="iw")
    below = whole.add_subparsers()
    for name, point in _POINTS.items():
        below.add_parser(name, parents=[_parser_of(point.module)], add_help=False, help=COMMANDS[name])
    listing = below.add_parser("list", help="lists what is included")
    listing.add_argument("kind", choices=KINDS)
    print(shtab.complete(whole, shell=shell))
    return 0


if __name__ == "__main__":
    sys.exit(main())
