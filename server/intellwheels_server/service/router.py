"""`iw-router`: a Zenoh router, for machines without the official `zenohd`.

It forwards messages and reads none of them. `--print` prints its configuration, which `zenohd -c FILE` accepts too.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from intellwheels_schemas import defaults
from intellwheels_schemas.command_parser import CommandParser, readable_file
from intellwheels_schemas.endpoint_form import check_endpoint
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Lab
from intellwheels_schemas.own_rights import answer_rights
from intellwheels_schemas.panic_watch import PanicWatch
from intellwheels_schemas.process import SLICE, add_process_options, stop_on_signals
from intellwheels_schemas.router_link import open_router, open_words, router_settings
from intellwheels_server.service.lab_router import lab_settings, read_lab, read_users, users_file


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
    found.add_argument(
        "--lab", type=readable_file, metavar="FILE", help="let in only the identities of this lab, with its rules"
    )
    add_process_options(found)
    return found


def _settings_of(lab: Lab, file: Path, *, printed: bool) -> dict[str, Any]:
    users = users_file(file)
    known = {} if printed else read_users(users)
    lacking = [] if printed else [identity.name for identity in lab.identity if identity.name not in known]
    if lacking:
        text = f"{users}: expected a password for {', '.join(lacking)}, got none; run iw-lab keys {file}"
        raise WireError("value", text, str(users))
    return lab_settings(lab, users)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the router until it is stopped; return the exit code: 0 done, 1 failed, 2 wrong usage."""
    options = parser().parse_args(arguments)
    listen = options.listen or [defaults.ENDPOINT]
    try:
        for endpoint in listen:
            check_endpoint(endpoint, "--listen")
        lab = None if options.lab is None else read_lab(options.lab)
        more = None if lab is None else _settings_of(lab, options.lab, printed=options.print)
    except WireError as error:
        print(f"iw-router: {error}", file=sys.stderr)
        return 2
    if options.print:
        print(router_settings(listen, more), end="")
        return 0
    stop = stop_on_signals(options.lifeline)
    watch = PanicWatch(lambda line: _begin_again(watch, line))
    try:
        with open_router(listen, more) as session:
            queryables = [] if lab is None else answer_rights(session, lab.identity)
            if more is None:
                print(f"iw-router: {open_words(listen)}", file=sys.stderr, flush=True)
            print(f"ready listen={','.join(listen)}", flush=True)
            while not stop.wait(SLICE):
                pass
            for queryable in queryables:
                queryable.undeclare()
    except ConnectionError as error:
        print(f"iw-router: {error}", file=sys.stderr)
        return 1
    return 0


def _begin_again(watch: PanicWatch, line: str) -> None:
    """Replace this process by a new one, which listens at the same endpoints. A router keeps nothing."""
    watch.close()
    print(f"iw-router: restarted why={line!r}", file=sys.stderr, flush=True)
    os.execv(sys.executable, sys.orig_argv)  # noqa: S606 - this process's own command line


if __name__ == "__main__":
    sys.exit(main())
