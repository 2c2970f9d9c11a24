"""Tries a mind before anything starts, so that a wrong option is reported at once and not after a simulator was found.

Only included minds are tried: they are pure. The file of a user may open a device when its mind is made.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping
from pathlib import Path

from intellwheels_agents.mind import Context
from intellwheels_agents.minds import Source
from intellwheels_agents.options import OptionError, Options
from intellwheels_maps.library import is_path
from intellwheels_schemas import defaults
from intellwheels_schemas.errors import got_of
from intellwheels_schemas.messages import Map, Parameters, Position, Robot

_SETTINGS = Parameters(
    world=defaults.WORLD,
    period=defaults.PERIOD,
    pace="realtime",
    say_limit=defaults.SAY_LIMIT,
    say_range=defaults.SAY_RANGE,
    command_timeout=defaults.COMMAND_TIMEOUT,
    grace=defaults.GRACE,
)


class _NoMapError(Exception):
    """The mind asks for the map, which nobody knows yet."""


def check_mind_options(
    source: Source,
    robot: Robot,
    options: Mapping[str, str],
    *,
    own_body: bool = True,
    agent: str = "trial",
    position: Position | None = None,
    fetch_map: Callable[[], Map] | None = None,
    read: Options | None = None,
) -> None:
    """Make an included mind once and throw it away.

    Args:
        source: The mind.
        robot: The body that it will drive.
        options: The mind's options.
        own_body: Whether it is that body. If it is another process's, only errors that name an option count.
        agent: The agent's name.
        position: Where it will start; None: unknown.
        fetch_map: Returns the map; None: unknown, and a mind that asks for it is checked only up to there.
        read: The same options, if the caller wants to know what the mind reads.

    Raises:
        OptionError: An option is wrong.
        WireError: The map lacks something.
    """
    if is_path(source.name):
        return
    read = Options(options) if read is None else read
    at = position or Position(x=0.0, y=0.0, heading=0.0)
    try:
        source.make(Context(agent, robot, at, _SETTINGS, read, fetch_map or _no_map))
        read.check_all_read()
    except _NoMapError:
        return
    except OptionError as error:
        names_option = any(f"option {name}:" in str(error) for name in options)
        if own_body or names_option:
            raise


def check_mind_file(path: Path) -> None:
    """Check that the file of a user's mind is there, is Python and seems to define a mind. It is not run.

    Raises:
        OptionError: It is not.
    """
    try:
        tree = ast.parse(path.read_bytes(), str(path))
    except OSError as error:
        raise OptionError(f"{path}: expected a Python file, got {got_of(error)}") from None
    except (SyntaxError, ValueError) as error:
        place = f"{path}:{getattr(error, 'lineno', None) or 1}"
        raise OptionError(f"{place}: expected Python, got a syntax error: {error}") from None
    names: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, (ast.ClassDef, ast.FunctionDef)):
            names.add(node.name)
        elif isinstance(node, (ast.Import, ast.ImportFrom)):
            names |= {alias.asname or alias.name for alias in node.names}
        elif isinstance(node, ast.Name):
            names.add(node.id)
    if not names & {"Mind", "make", "*"}:
        raise OptionError(f"{path}: expected make(context) or a class Mind, got neither")


def _no_map() -> Map:
    raise _NoMapError
