"""`iw-router`: runs the router where simulators and agents meet, for machines without the official `zenohd`.

It forwards messages and reads none of them. `--print` prints its configuration, which `zenohd -c FILE` accepts too.
"""

from __future__ import annotations

import argparse
import datetime
import os
import sys
import time
from collections.abc import Sequence
from typing import Final

from intellwheels_schemas import defaults
from intellwheels_schemas.command_parser import CommandParser, readable_file, whole
from intellwheels_schemas.endpoint_form import check_endpoint
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.identity_file import WARN_DAYS
from intellwheels_schemas.lab_rules import has_expired
from intellwheels_schemas.own_rights import answer_rights
from intellwheels_schemas.panic_watch import PanicWatch
from intellwheels_schemas.process import SLICE, add_process_options, stop_on_signals
from intellwheels_schemas.router_link import guard_sessions, open_router, open_words, router_settings
from intellwheels_schemas.session_count import MAX_SESSIONS
from intellwheels_server.service.denial_process import DenialProcess
from intellwheels_server.service.denials import LOG
from intellwheels_server.service.lab_files import LabFiles, read_lab, router_until
from intellwheels_server.service.lab_router import checked_settings

LIVED_LONG: Final = 60.0
"""Seconds after which a replaced router begins again at once."""
FIRST_PAUSE: Final = 0.5
LAST_PAUSE: Final = 10.0
"""Seconds before a router that was replaced soon after its start listens again: the first pause, and the longest."""
_PAUSE: Final = "IW_ROUTER_PAUSE"
"""Variable in which a process tells the one that replaces it how long to wait."""

EXAMPLES = """\
examples:
  iw-router                                                   for the processes of this machine
  iw-router --listen tcp/0.0.0.0:7447                         for those of other machines too
  iw-router --lab LAB.xml --listen tcp/0.0.0.0:7447           for the identities of a lab only (see iw-lab --help)
  iw-router --print > router.json5 && zenohd -c router.json5  the official router with this configuration

With --lab, each denial is reported the 1st, 10th, 100th time and so on; not if RUST_LOG asks for Zenoh's own log.
Standard output has `ready listen=...` when others can connect. Exit codes: 0 done, 1 failed, 2 wrong usage.
"""


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    found = CommandParser(
        prog="iw-router",
        description="Run a router through which a simulator and its agents connect. Start each of them with\n"
        "--connect ENDPOINT, where ENDPOINT is an endpoint of this router.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
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
    found.add_argument(
        "--max-sessions", type=whole(1, 10_000), metavar="N",
        help="Zenoh sessions that one certificate, or one address without certificates, may have at a time, in "
        f"[1, 10000]; more are closed and reported (default: {MAX_SESSIONS}; no limit for sessions of this machine "
        "that show no certificate)",
    )  # fmt: skip
    found.add_argument(
        "--no-denials", dest="denials", action="store_false",
        help="do not report what the rules of the lab deny; that saves about a third of the router's work",
    )  # fmt: skip
    add_process_options(found)
    return found


def _check_listen(endpoint: str, files: LabFiles | None) -> None:
    check_endpoint(endpoint, "--listen")
    if endpoint.startswith("tls/") and (files is None or not files.router.exists()):
        text = "--listen: expected --lab with a certificate for tls/, got none; run iw-lab keys --host HOST"
        raise WireError("value", text, "--listen")


def _warnings(files: LabFiles, today: datetime.date) -> list[str]:
    found = [
        f"{identity.name} expired after {identity.until} and is not let in"
        for identity in read_lab(files.lab).identity
        if has_expired(identity, today)
    ]
    until = router_until(files)
    if until is not None and (until - today).days <= WARN_DAYS:
        found.append(f"the router's certificate expires after {until}; run iw-lab keys, and restart iw-router")
    return [*found, *(f"warning: {words}" for words in files.exposed())]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the router until it is stopped; return the exit code: 0 done, 1 failed, 2 wrong usage."""
    options = parser().parse_args(arguments)
    listen = options.listen or [defaults.ENDPOINT]
    files, today = None if options.lab is None else LabFiles(options.lab), _today()
    try:
        for endpoint in listen:
            _check_listen(endpoint, files)
        more = None if files is None else checked_settings(files, today, printed=options.print)
        warnings = [] if files is None else _warnings(files, today)
    except WireError as error:
        _log(str(error))
        return 2
    if files is None and not options.denials:
        _log("--no-denials: expected --lab too, got none")
        return 2
    if options.print:
        print(router_settings(listen, more), end="")
        return 0
    stop = stop_on_signals(options.lifeline)
    if pause := _pause():
        _log(f"waiting seconds={pause:g} why='restarted before'")
        stop.wait(pause)
    # With its own standard error, and without anything of Zenoh.
    report = DenialProcess() if more is not None and options.denials and not os.environ.get("RUST_LOG") else None
    began = time.monotonic()
    watch = PanicWatch(lambda line: _begin_again(watch, report, line, next_pause(pause, time.monotonic() - began)))
    over = ""
    try:
        if stop.is_set():
            return 0
        with open_router(listen, more, "off" if report is None else LOG) as session:
            identities = () if files is None else read_lab(files.lab).identity
            let_in = [identity for identity in identities if not has_expired(identity, today)]
            kept = [*answer_rights(session, identities), guard_sessions(session, options.max_sessions, _log)]
            for warning in warnings:
                _log(warning)
            if more is None:
                _log(open_words(listen))
            out = sys.stdout if report is None else report.out
            print(f"ready listen={','.join(listen)}", file=out, flush=True)
            while not over and not stop.wait(SLICE):
                if report is not None and report.has_ended():
                    _log("denials are not reported any more: restart iw-router")
                over = ", ".join(one.name for one in let_in if has_expired(one, _today()))
            for one in kept:
                one.undeclare()
    except ConnectionError as error:
        _log(str(error))
        return 1
    finally:
        if report is not None:
            report.close()
    if over:
        # Zenoh keeps its users and their sessions until it ends.
        _begin_again(watch, None, f"the last day of {over} is over")
    return 0


def _log(line: str) -> None:
    print(f"iw-router: {line}", file=sys.stderr, flush=True)


def _today() -> datetime.date:
    return datetime.datetime.now(datetime.UTC).date()


def next_pause(pause: float, lived: float) -> float:
    """Return for how many seconds a router that must be replaced waits before it listens again.

    Args:
        pause: For how long this one has waited, s.
        lived: For how long it has listened since, s.
    """
    return 0.0 if lived >= LIVED_LONG else min(max(FIRST_PAUSE, 2.0 * pause), LAST_PAUSE)


def _pause() -> float:
    """Return for how many seconds this process must wait, as the one that it replaces said."""
    try:
        return min(max(float(os.environ.pop(_PAUSE, "0")), 0.0), LAST_PAUSE)
    except ValueError:
        return 0.0


def _begin_again(watch: PanicWatch, report: DenialProcess | None, why: str, pause: float = 0.0) -> None:
    """Replace this process by a new one, which listens at the same endpoints. A router keeps nothing."""
    watch.close()
    _log(f"restarted why={why!r}")
    if report is not None:
        report.close()
    os.environ[_PAUSE] = str(pause)
    os.execv(sys.executable, sys.orig_argv)  # noqa: S606 - this process's own command line


if __name__ == "__main__":
    sys.exit(main())
