"""Tries a mind before anything starts, so that a wrong option is reported at once and not after a simulator was found.

Only included minds are tried: they are pure. The file of a user may open a device when its mind is made.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from intellwheels_agents.mind import Context
from intellwheels_agents.minds import Source
from intellwheels_agents.options import OptionError, Options
from intellwheels_maps.library import is_path
from intellwheels_schemas import defaults
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

    Raises:
        OptionError: An option is wrong.
        WireError: The map lacks something.
    """
    if is_path(source.name):
        return
    read = Options(options)
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


def _no_map() -> Map:
    raise _NoMapError
