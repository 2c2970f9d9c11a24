"""`iw-router`: a Zenoh router for the contract, where the official `zenohd` is not at hand.

It carries messages and knows none of them. With `--print` it shows its configuration, which `zenohd -c FILE`
takes as well.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from intellwheels_schemas import link
from intellwheels_schemas.process import SLICE, add_process_options, stop_on_signals

DEFAULT_LISTEN = "tcp/127.0.0.1:7447"


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    found = argparse.ArgumentParser(
        prog="iw-router",
        description="Let a simulator and its agents meet: they all connect here, each with --connect ENDPOINT.",
    )
    found.add_argument(
        "--listen",
        action="append",
        metavar="ENDPOINT",
        help=f"where to be found; may be repeated (default: {DEFAULT_LISTEN})",
    )
    found.add_argument("--print", action="store_true", help="print the configuration, for zenohd -c FILE, and end")
    add_process_options(found)
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    """Route until told to stop and return the exit code: 0 done, 1 failed, 2 wrong usage."""
    options = parser().parse_args(arguments)
    listen = options.listen or [DEFAULT_LISTEN]
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
