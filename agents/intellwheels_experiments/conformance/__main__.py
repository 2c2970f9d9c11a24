"""`iw-check-agent`: play a simulator to any program and say which points of the contract it keeps."""

from __future__ import annotations

import argparse
import socket
import sys
from collections.abc import Sequence

from intellwheels_experiments.conformance import contract_points
from intellwheels_experiments.conformance.contract_points import Check, Outcome, Patience
from intellwheels_experiments.conformance.scripted_simulator import NetworkProbe
from intellwheels_experiments.run.launch_spec import filled
from intellwheels_maps import floor, robot
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.link import DEFAULT_WORLD, Link
from intellwheels_schemas.names import check_agent, check_name
from intellwheels_schemas.process import add_process_options, stop_on_signals

POINTS = (contract_points.__doc__ or "").partition("\n\n    ")[2]
HELP = f"""\
The program is started several times, each time with {{endpoint}}, {{world}} and {{name}} in COMMAND replaced, and with
IW_ENDPOINT, IW_WORLD and IW_NAME in its environment: where to connect, which world, which name to join under.
It must join by itself, wait where no simulator is there yet, and end on SIGTERM.

points:
    {POINTS}
examples:
  a program that takes its name and the endpoint as arguments
      iw-check-agent -- python agents/examples/08_another_language/python/avoid.py {{name}} {{endpoint}}
  a mind of your own
      iw-check-agent -- iw-agent ./my_mind.py --name {{name}} --connect {{endpoint}}
  behind a bridge or router of yours that connects to port 7447
      iw-check-agent --listen tcp/127.0.0.1:7447 -- node avoid.js

Exit code 0: all points passed; 1: not all; 2: wrong usage.
"""


def parser() -> argparse.ArgumentParser:
    """Return the command line."""
    result = argparse.ArgumentParser(
        prog="iw-check-agent",
        usage="iw-check-agent [options] -- COMMAND ...",
        description="Play a simulator to a program in any language, and say which points of the contract it keeps.",
        epilog=HELP,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    result.add_argument("command", nargs="+", metavar="COMMAND", help="the program and its arguments, behind --")
    result.add_argument("--name", default="chair1", metavar="NAME", help="the agent's name (default: chair1)")
    result.add_argument("--world", default=DEFAULT_WORLD, metavar="NAME", help="the world's name (default: main)")
    result.add_argument("--listen", metavar="ENDPOINT", help="where to be found (default: a free port of this machine)")
    result.add_argument("--connect", metavar="ENDPOINT", help="a router to meet at instead")
    patience = Patience()
    for what, means, default in (
        ("start", "to join, after its start or the simulator's return", patience.start),
        ("answer", "to answer", patience.answer),
        ("leave", "to leave after SIGTERM", patience.leave),
    ):
        result.add_argument(
            f"--{what}-within",
            type=_seconds,
            default=default,
            metavar="S",
            help=f"seconds it has {means} (default: {default:g})",
        )
    add_process_options(result)
    return result


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the check and return the exit code: 0 all passed, 1 not all, 2 wrong usage."""
    options = parser().parse_args(arguments)
    stop = stop_on_signals(options.lifeline)
    try:
        agent = check_agent(options.name, "--name")
        world = check_name(options.world, "--world")
    except WireError as error:
        print(f"iw-check-agent: {error}", file=sys.stderr)
        return 2
    if options.listen and options.connect:
        print("iw-check-agent: expected one of --listen and --connect, got both", file=sys.stderr)
        return 2
    endpoint = options.connect or options.listen or f"tcp/127.0.0.1:{_free_port()}"
    ends = (endpoint,)
    link = Link(world, connect=ends) if options.connect else Link(world, listen=ends)
    values = {"endpoint": endpoint, "world": world, "name": agent}
    command = [filled(word, values) for word in options.command]
    environment = {f"IW_{name.upper()}": value for name, value in values.items()}
    patience = Patience(options.start_within, options.answer_within, options.leave_within)
    passed = played = 0
    try:
        with NetworkProbe(command, environment, link, agent, floor("room"), stop) as stand:
            for outcome in Check(stand, world, agent, robot("intellwheels"), patience).run():
                _show(outcome)
                played += 1
                passed += outcome.passed is True
    except (ConnectionError, OSError) as error:
        print(f"iw-check-agent: {error}", file=sys.stderr)
        return 1
    print(f"{passed} of {played} points passed")
    return 0 if passed == played else 1


def _show(outcome: Outcome) -> None:
    if outcome.passed:
        print(f"passed  {outcome.point:<8} {outcome.expected}", flush=True)
        return
    how = "skipped" if outcome.passed is None else "FAILED "
    print(f"{how} {outcome.point:<8} expected {outcome.expected}\n{'':17}got {outcome.got}")
    for line in outcome.printed.splitlines()[-10:]:
        print(f"{'':17}| {line}")
    sys.stdout.flush()


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def _seconds(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0.0 < value < 1e6:
        raise argparse.ArgumentTypeError(f"expected seconds above 0, got {text!r}")
    return value


if __name__ == "__main__":
    sys.exit(main())
