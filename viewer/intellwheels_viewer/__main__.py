"""`iw-viewer`: serves the web page that shows a run and controls it."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Final

from intellwheels_schemas import defaults
from intellwheels_schemas.command_parser import CommandParser, number, port
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.extras import missing_extra
from intellwheels_schemas.link import add_link_options, link_of
from intellwheels_schemas.output_paths import add_overwrite_option, check_output_file
from intellwheels_schemas.process import add_process_options, stop_on_signals
from intellwheels_viewer.page_hosts import check_page_hosts

LONGEST: Final = 600.0
"""Longest recording, in seconds: a browser takes minutes to open a longer one."""
PORT: Final = 8080
"""Port of the page, if none is given."""

_EPILOG = """\
examples:
  iw-viewer                                      show a simulator on this machine, at http://127.0.0.1:8080
  iw-viewer --connect tcp/10.0.0.5:7447          show a simulator on another machine
  iw-viewer --host 0.0.0.0 --allow-host lab-pc   let other machines open the page as http://lab-pc:8080
  iw-viewer --record run.html --seconds 30       save 30 s of the run as a page that needs no simulator

It prints one line, `ready url=...`, when the page can be opened. It stores no part of the run, so you can stop and
restart it at any time. The page has no login: do not expose it to a network that you do not trust.
"""


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    found = CommandParser(
        prog="iw-viewer",
        description="Serve a web page that shows a run and controls it. Any number of browsers can open it.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    page = found.add_argument_group("page")
    page.add_argument(
        "--host", default="127.0.0.1", metavar="ADDRESS",
        help="address to serve the page at (default: 127.0.0.1, this machine only)",
    )  # fmt: skip
    page.add_argument(
        "--port", type=port, metavar="N",
        help=f"port of the page; 0 picks a free one (default: {PORT}; with --record, a free one)",
    )  # fmt: skip
    page.add_argument(
        "--allow-host", action="append", default=[], metavar="NAME",
        help="accept browsers that reach the page by this name, for example behind a proxy; may be repeated",
    )  # fmt: skip
    page.add_argument("--dark", action="store_true", help="use the dark theme")
    kept = found.add_argument_group("recording")
    kept.add_argument(
        "--record", type=Path, metavar="FILE.html",
        help="record the current run, or the next one, as a page that plays without a server; then exit",
    )  # fmt: skip
    kept.add_argument(
        "--seconds", type=number("seconds", 0.0, LONGEST, low_open=True), default=20.0, metavar="S",
        help="with --record: simulated seconds to record, fewer if the run ends earlier (default: 20)",
    )  # fmt: skip
    add_overwrite_option(kept)
    add_process_options(found)
    add_link_options(found, world="the only running world; if there are several, the page lets you choose")
    found.set_defaults(world=None)
    return found


def main(arguments: list[str] | None = None) -> int:
    """Run the command and return its exit code."""
    command_line = parser()
    given = command_line.parse_args(arguments)
    if given.record is None and given.seconds != command_line.get_default("seconds"):
        command_line.error("--seconds: expected with --record, got none")
    if given.record is None and given.overwrite:
        command_line.error("--overwrite: expected with --record, got none")
    lacking = missing_extra("viewer")
    if lacking is not None:
        print(f"iw-viewer: {lacking}", file=sys.stderr)
        return 2
    chosen = given.world is not None
    given.world = given.world if chosen else defaults.WORLD
    try:
        check_output_file(given.record, "--record", overwrite=given.overwrite)
        link = link_of(given)
        check_page_hosts(given.host, given.allow_host)
    except WireError as error:
        print(f"iw-viewer: {error.text}", file=sys.stderr)
        return 2
    if given.port is None:
        # Nobody needs to know the address of a recording, and another viewer may have the usual port.
        given.port = PORT if given.record is None else 0
    stop = stop_on_signals(given.lifeline)
    # Imported late: viser, numpy and zenoh are slow to load, and `--help` does not need them.
    from intellwheels_viewer.viewer_service import Options, serve  # noqa: PLC0415

    return serve(
        Options(
            host=given.host,
            port=given.port,
            allowed=frozenset(given.allow_host),
            dark=given.dark,
            chosen=chosen,
            record=given.record,
            seconds=given.seconds,
            overwrite=given.overwrite,
        ),
        link,
        stop,
    )


if __name__ == "__main__":
    sys.exit(main())
