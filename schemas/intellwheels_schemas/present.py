"""Check whether a router, a simulator or an agent is running, for health checks and scripts.

Exit code 0: it is running; 1: it is not running, or the endpoint does not answer; 2: wrong usage.
"""

from __future__ import annotations

import sys
import threading
from collections.abc import Sequence

from intellwheels_schemas import link, own_rights
from intellwheels_schemas.command_parser import CommandParser
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.names import check_name

TIMEOUT = 3.0
"""Seconds to wait for the endpoint to answer."""


def parser() -> CommandParser:
    """Return the command line."""
    result = CommandParser(prog="python -m intellwheels_schemas.present", description=__doc__)
    result.add_argument(
        "--agent", metavar="NAME", help="check for this agent (default: for the simulator of the world)"
    )
    result.add_argument("--router", action="store_true", help="only check whether the endpoint answers")
    link.add_link_options(result)
    return result


def main(arguments: Sequence[str] | None = None) -> int:
    """Check once and return the exit code."""
    options = parser().parse_args(arguments)
    try:
        route = link.link_of(options)
        keys = Keys(route.world)
        wanted, *more = [keys.alive] if options.agent is None else _tokens(keys, check_name(options.agent, "--agent"))
        session = link.open_session(route, threading.Event(), timeout=TIMEOUT)
    except WireError as error:
        print(f"present: {error.text}", file=sys.stderr)
        return 2
    except ConnectionError as error:
        print(f"present: {error}", file=sys.stderr)
        return 1
    if session is None:
        return 1
    with session:
        if options.router or any(link.tokens(session, key) for key in (wanted, *more)):
            return 0
        denied = own_rights.denied(session, wanted, "watch")
    print(f"present: {denied or f'no liveliness token {wanted} at {route.where()}'}", file=sys.stderr)
    return 1


def _tokens(keys: Keys, agent: str) -> list[str]:
    return [keys.tokens(agent), keys.crew_tokens(agent)]


if __name__ == "__main__":
    sys.exit(main())
