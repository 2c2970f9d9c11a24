"""`iw-router`: a Zenoh router, for machines without the official `zenohd`.

It forwards messages and reads none of them. `--print` prints its configuration, which `zenohd -c FILE` accepts too.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from intellwheels_schemas import defaults, link
from intellwheels_schemas.command_parser import CommandParser
from intellwheels_schemas.endpoint_form import check_endpoint
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.process import SLICE, add_process_options, stop_on_signals


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    found = CommandParser(
        prog="iw-router",
        description="Run a router through which a simulator and its agents connect. Start each of them with "
        "--connect ENDPOINT, where ENDPOINT is an endpoint of this router.",
    )
    found.add_argument(
        "--listen",
        action="append",
        metavar="ENDPOINT",
        help=f"endpoint to listen at; may be repeated (default: {defaults.ENDPOINT})",
    )
    found.add_argument("--print", action="store_true", help="print the configuration for zenohd -c FILE, and exit")
    add_process_options(found)
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the router until it is stopped; return the exit code: 0 done, 1 failed, 2 wrong usage."""
    options = parser().parse_args(arguments)
    listen = options.listen or [defaults.ENDPOINT]
    try:
        for endpoint in listen:
            check_endpoint(endpoint, "--listen")
    except WireError as error:
        print(f"iw-router: {error}", file=sys.stderr)
        return 2
    if options.print:
        print(link.router_settings(listen), end="")
        return 0
    stop = stop_on_signals(options.lifeline)
    try:
        with link.open_router(listen):
            print(f"ready listen={','.join(listen)}", flush=True)
            while not stop.wait(SLICE):
                pass
    except ConnectionError as error:
        print(f"iw-router: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
