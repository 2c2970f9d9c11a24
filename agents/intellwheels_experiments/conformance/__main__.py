"""`iw-check-agent`: runs a program against a scripted simulator and reports which points of the contract it meets."""

from __future__ import annotations

import argparse
import shutil
import sys
import textwrap
from collections.abc import Sequence
from pathlib import Path

from intellwheels_experiments.conformance.agent_session import Patience
from intellwheels_experiments.conformance.contract_points import Outcome, check, described
from intellwheels_experiments.conformance.scripted_simulator import NetworkProbe
from intellwheels_experiments.run.endpoints import free_endpoint
from intellwheels_maps import floor, robot
from intellwheels_schemas import defaults
from intellwheels_schemas.command_line import check_placeholders, filled
from intellwheels_schemas.command_parser import CommandParser, positive_seconds
from intellwheels_schemas.endpoint_form import check_free
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.identity_option import add_identity_option, router_of
from intellwheels_schemas.link import Link, check_link
from intellwheels_schemas.names import check_agent, check_name
from intellwheels_schemas.process import add_process_options, stop_on_signals

HELP = f"""\
The command starts the program several times. Each time it replaces {{endpoint}}, {{world}} and {{name}} in COMMAND. The
program also finds them in its environment, as IW_ENDPOINT, IW_WORLD and IW_NAME: where to connect, which world to join,
and under which name. The program must join as a single agent, not in a crew, wait while there is no simulator, and end
on SIGTERM.

points (the situation: what the program must do):
{textwrap.indent(described(), "    ")}

examples:
  a program that takes its name and the endpoint as arguments
      iw-check-agent -- python agents/examples/other_languages/python/avoid.py {{name}} {{endpoint}}
  your own mind
      iw-check-agent -- iw-agent ./my_mind.py --name {{name}} --connect {{endpoint}}
  a program that cannot be told an endpoint, and connects to port 7447 itself or through a bridge of your own
      iw-check-agent --listen tcp/127.0.0.1:7447 -- node avoid.js

Exit codes: 0 all points passed, 1 otherwise, 2 wrong usage.
"""


def parser() -> argparse.ArgumentParser:
    """Return the command line."""
    result = CommandParser(
        prog="iw-check-agent",
        usage="iw-check-agent [options] -- COMMAND ...",
        description="Run a program, in any language, against a scripted simulator, and report which points of the "
        "contract it meets.",
        epilog=HELP,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    result.add_argument("command", nargs="+", metavar="COMMAND", help="the program and its arguments, after --")
    result.add_argument("--name", default="chair1", metavar="NAME", help="the agent's name (default: chair1)")
    result.add_argument(
        "--world", default=defaults.WORLD, metavar="NAME", help="the world's name (default: %(default)s)"
    )
    result.add_argument("--listen", metavar="ENDPOINT", help="where to listen (default: a free port of this machine)")
    result.add_argument(
        "--connect", metavar="ENDPOINT",
        help="connect to this router instead of listening (default: the first endpoint of --identity, if it is given)",
    )  # fmt: skip
    add_identity_option(result)
    patience = Patience()
    for what, does, default in (
        ("start", "joins after its start or the return of the simulator", patience.start),
        ("answer", "answers", patience.answer),
        ("leave", "leaves after SIGTERM", patience.leave),
    ):
        result.add_argument(
            f"--{what}-within",
            type=positive_seconds,
            default=default,
            metavar="S",
            help=f"seconds within which the program {does} (default: {default:g})",
        )
    add_process_options(result)
    return result


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the check and return the exit code: 0 all points passed, 1 not all, 2 wrong usage."""
    options = parser().parse_args(arguments)
    stop = stop_on_signals(options.lifeline)
    try:
        agent = check_agent(options.name, "--name")
        world = check_name(options.world, "--world")
        check_placeholders(options.command, "COMMAND")
        link = _link(world, options.listen, options.connect, options.identity)
        _check_program(options.command[0])
        check_free(link.listen)
    except WireError as error:
        print(f"iw-check-agent: {error}", file=sys.stderr)
        return 2
    except ConnectionError as error:
        print(f"iw-check-agent: {error}", file=sys.stderr)
        return 1
    endpoint = link.where()
    values = {"endpoint": endpoint, "world": world, "name": agent}
    command = [filled(argument, values) for argument in options.command]
    environment = {f"IW_{name.upper()}": value for name, value in values.items()}
    patience = Patience(options.start_within, options.answer_within, options.leave_within)
    passed = checked = 0
    try:
        with NetworkProbe(command, environment, link, agent, floor("room"), stop) as probe:
            for outcome in check(probe, world, agent, robot("intellwheels"), patience):
                _show(outcome)
                checked += 1
                passed += outcome.passed is True
    except (ConnectionError, OSError) as error:
        print(f"iw-check-agent: {error}", file=sys.stderr)
        return 1
    print(f"{passed} of {checked} points passed")
    return 0 if passed == checked else 1


def _link(world: str, listen: str | None, connect: str | None, identity: Path | None) -> Link:
    """Return where the simulator of the check is.

    Raises:
        WireError: An endpoint or the identity is wrong, or there are two endpoints.
    """
    if identity is not None and listen is not None:
        raise WireError("value", "--identity: expected --connect to a router, got --listen", "--identity")
    connect = next(iter(router_of(identity)), None) if connect is None else connect
    if identity is not None and connect is None:
        text = "--identity: expected --connect with an endpoint of the router, or a file that names one, got neither"
        raise WireError("value", text, "--identity")
    if listen is not None and connect is not None:
        raise WireError("value", "--listen: expected one of --listen and --connect, got both", "--listen")
    listens = () if connect is not None else (free_endpoint() if listen is None else listen,)
    link = Link(world, listens, () if connect is None else (connect,), identity=identity)
    check_link(link)
    return link


def _check_program(program: str) -> None:
    """Check that the first word of the command is a program.

    Raises:
        WireError: It is not.
    """
    if shutil.which(program) is None:
        raise WireError("value", f"COMMAND: expected a program that can be run, got {program!r}", "COMMAND")


def _show(outcome: Outcome) -> None:
    if outcome.passed:
        print(f"passed  {outcome.point:<10} {outcome.expected}", flush=True)
        return
    how = "skipped" if outcome.passed is None else "FAILED "
    print(f"{how} {outcome.point:<10} expected {outcome.expected}\n{'':19}got {outcome.got}")
    for line in outcome.output.splitlines()[-10:]:
        print(f"{'':19}| {line}")
    sys.stdout.flush()


if __name__ == "__main__":
    sys.exit(main())
