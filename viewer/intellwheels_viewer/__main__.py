"""`iw-viewer`: serves the web page that shows a run and controls it."""

from __future__ import annotations

import argparse
import re
import sys
from pathlib import Path
from typing import Final

from intellwheels_schemas import defaults
from intellwheels_schemas.command_parser import CommandParser, number, port, readable_file
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.extras import missing_extra
from intellwheels_schemas.files import read_with_lines
from intellwheels_schemas.link import add_link_options, link_of
from intellwheels_schemas.messages import Lab
from intellwheels_schemas.output_paths import add_overwrite_option, check_output_file
from intellwheels_schemas.process import add_process_options, stop_on_signals
from intellwheels_viewer.page_hosts import check_page_hosts, is_wide
from intellwheels_viewer.visits import Door

LONGEST: Final = 600.0
"""Longest recording, in seconds: a browser takes minutes to open a longer one."""
_HEADER: Final = re.compile(r"[A-Za-z0-9-]{1,64}")
PORT: Final = 8080
"""Port of the page, if none is given."""

_EPILOG = """\
examples:
  iw-viewer                                      show a simulator on this machine, at http://127.0.0.1:8080
  iw-viewer --connect tcp/10.0.0.5:7447          show a simulator on another machine
  iw-viewer --host 0.0.0.0 --allow-host lab-pc   let other machines open the page as http://lab-pc:8080
  iw-viewer --record run.html --seconds 30       save 30 s of the run as a page that needs no simulator

It prints `ready url=...` when the page can be opened and, with --record, `recorded file=... bytes=...` at the end. It
stores no part of the run, so you can stop and restart it at any time. The page has no login: do not expose it to a
network that you do not trust.
Exit codes: 0 done, 1 refused or failed, 2 wrong usage. The command needs the extra `viewer`.
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
        help="accept browsers that reach the page by this name, for example behind a proxy; with a port, such as "
        "site:8443, only there; may be repeated",
    )  # fmt: skip
    page.add_argument(
        "--allow-programs", action="store_true",
        help="let programs that send no Origin header steer too, even if --host lets other machines reach the page",
    )  # fmt: skip
    page.add_argument(
        "--user-header", metavar="HEADER",
        help="with --lab: the header in which a proxy names the user, such as X-Remote-User",
    )  # fmt: skip
    page.add_argument(
        "--lab", type=readable_file, metavar="FILE",
        help="with --user-header: the lab's document (see iw-lab --help), which says what each user may do; users that "
        "are not in it may only look",
    )  # fmt: skip
    page.add_argument(
        "--dark", action="store_true",
        help="use the dark theme; without it, a page follows its user's system setting; the page has a switch too",
    )  # fmt: skip
    kept = found.add_argument_group("recording")
    kept.add_argument(
        "--record", type=Path, metavar="FILE.html",
        help="record the current run, or the next one, as a page that plays without a server; then exit",
    )  # fmt: skip
    kept.add_argument(
        "--seconds", type=number("seconds", 0.0, LONGEST, low_open=True), default=20.0, metavar="S",
        help="with --record: simulated seconds to record, in (0, 600], fewer if the run ends earlier (default: 20)",
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
    if (given.user_header is None) != (given.lab is None):
        command_line.error("--user-header and --lab: expected both or none, got one")
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
        door = _door(given)
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
            door=door,
            dark=given.dark,
            chosen=chosen,
            record=given.record,
            seconds=given.seconds,
            overwrite=given.overwrite,
        ),
        link,
        stop,
    )


def _door(given: argparse.Namespace) -> Door:
    """Return which browsers may do more than look.

    Raises:
        WireError: The name of the header has another form, or the lab's document is wrong.
    """
    header = given.user_header or ""
    if header and _HEADER.fullmatch(header) is None:
        text = f"--user-header: expected the name of a header such as X-Remote-User, got {header!r}"
        raise WireError("value", text, "--user-header")
    lab = None if given.lab is None else read_with_lines(Lab, given.lab)[0]
    return Door(is_wide(given.host), given.allow_programs, header.lower(), lab)


if __name__ == "__main__":
    sys.exit(main())
