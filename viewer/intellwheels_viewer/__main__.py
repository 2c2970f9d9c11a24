"""`iw-viewer`: the page in which a run is seen and steered."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Final

from intellwheels_schemas.errors import WireError
from intellwheels_schemas.link import add_link_options, link_of
from intellwheels_schemas.process import add_process_options, stop_on_signals

LONGEST: Final = 600.0
"""Seconds of a recording: a longer file takes a browser minutes to open."""

_EPILOG = """\
examples:
  iw-viewer                                      what runs on this machine, at http://127.0.0.1:8080
  iw-viewer --connect tcp/10.0.0.5:7447          what runs on another one
  iw-viewer --host 0.0.0.0 --allow-host lab-pc   for the lab's browsers; put a proxy with a login before it

  iw-viewer --record run.html --seconds 30       a page of the run for who has no simulator

It prints one line, `ready url=...`, once the page is there. It keeps nothing of the run: stop it at any time.
"""


def parser() -> argparse.ArgumentParser:
    """Return the command's grammar."""
    found = argparse.ArgumentParser(
        prog="iw-viewer",
        description="Serve a web page in which a run is seen and steered, to any number of browsers.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    page = found.add_argument_group("page")
    page.add_argument(
        "--host", default="127.0.0.1", metavar="ADDRESS",
        help="address to serve at (default: 127.0.0.1, this machine only; there is no login)",
    )  # fmt: skip
    page.add_argument("--port", type=_port, default=8080, metavar="N", help="port; 0 for any free one (default: 8080)")
    page.add_argument(
        "--allow-host", action="append", default=[], metavar="NAME",
        help="a further name by which browsers reach this page, as behind a proxy; may be repeated",
    )  # fmt: skip
    page.add_argument("--dark", action="store_true", help="a dark page")
    kept = found.add_argument_group("recording")
    kept.add_argument(
        "--record", type=Path, metavar="FILE.html",
        help="keep the run as a page that plays without a server, and end; the run that is there or the next one",
    )  # fmt: skip
    kept.add_argument(
        "--seconds", type=_seconds, default=20.0, metavar="S",
        help="how much of it, in simulated seconds (default: 20; less where the run ends before)",
    )  # fmt: skip
    add_process_options(found)
    add_link_options(found)
    found.set_defaults(world=None)
    return found


def main(arguments: list[str] | None = None) -> int:
    """Run the command and return its exit code."""
    given = parser().parse_args(arguments)
    chosen = given.world is not None
    given.world = given.world or "main"
    try:
        link = link_of(given)
    except WireError as error:
        print(f"iw-viewer: {error.text}", file=sys.stderr)
        return 2
    stop = stop_on_signals(given.lifeline)
    # These import viser, numpy and zenoh: `--help` and usage errors come without them.
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
        ),
        link,
        stop,
    )


def _port(text: str) -> int:
    if not text.isdecimal() or int(text) > 65535:
        raise argparse.ArgumentTypeError(f"expected a port, 0 to 65535, got {text!r}")
    return int(text)


def _seconds(text: str) -> float:
    try:
        seconds = float(text)
    except ValueError:
        seconds = 0.0
    if not 0.0 < seconds <= LONGEST:
        raise argparse.ArgumentTypeError(f"expected seconds, more than 0 and at most {LONGEST:g}, got {text!r}")
    return seconds


if __name__ == "__main__":
    sys.exit(main())
