"""`iw-agent`: runs one agent as a process of its own."""

from __future__ import annotations

import argparse
import math
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from intellwheels_agents import minds, starter
from intellwheels_agents.agent_peer import run_agent
from intellwheels_agents.crew_harness import CrewMember
from intellwheels_agents.crew_options import add_crew_options, check_crew_options, crew_name, numbered
from intellwheels_agents.crew_peer import run_crew
from intellwheels_agents.harness import NAME_TAKEN, PLACE_TAKEN
from intellwheels_agents.mind_error import USER_ERRORS, MindError, failed
from intellwheels_agents.mind_help import mind_help
from intellwheels_agents.mind_trial import check_mind_options
from intellwheels_agents.options import OptionError, Options
from intellwheels_agents.robot_document import (
    DEFAULT_ROBOT,
    OWN_ROBOTS,
    default_robot,
    equipped,
    joining,
    split_options,
)
from intellwheels_maps import robot as robot_file
from intellwheels_schemas.codec import Encoding
from intellwheels_schemas.command_parser import CommandParser, add_retry_option, naming
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.link import Link, add_link_options, link_of
from intellwheels_schemas.messages import Position, Robot
from intellwheels_schemas.names import check_agent, check_word, new_hex
from intellwheels_schemas.output_paths import check_output_folder
from intellwheels_schemas.process import add_process_options, stop_on_signals

EXAMPLES = """\
examples:
  a chair that drives to a place on the map room; iw-server runs on this machine
      iw-agent waypoints --name chair1 --robot rear-wheel --place start1 --option to=spare3
  a chair with scripted motor powers: straight on, a turn to the left, a stop
      iw-agent drive --name chair1 --option script="0:0.5,0.5; 2:0.1,0.4; 4:0,0"
  a door on the map room with a noisy compass; a name that begins with a capital letter sets a field of the robot
      iw-agent door --name door --robot door --place hinge --option swing=right --option Compass.NoiseDeg=1
  a chair at coordinates instead of a place
      iw-agent avoid --name chair1 --position 3,2,90
  your own mind, a Python file with a class Mind, for a body that another process provides
      iw-agent ./my_mind.py --name chair1 --role mind
  two hundred people in one process: person1, person2 and so on, wherever there is room
      iw-agent person --count 200
  a folder to start your own project from: a mind, a robot, a scene and tests, ready to run
      iw-agent new my-chair

`iw-agent MIND --help` lists the options of an included mind, with ranges and defaults.

Standard output has `joined agent=chair1 run=... tick=...`, `run agent=chair1 run=...` when a new run begins, and
`left agent=chair1`. Exit codes: 0 done, 1 refused or failed, 2 wrong usage.
On standard error:
  erred      the simulator refused a message; printed for the 1st, 10th, 100th, ... of each code. With code=late a
             command was not used, because the mind or the machine is too slow; a few of them do no harm, as the next
             tick has another command
  counted    at the end: missed, the Measures that the mind never saw; repeated, those that it had to answer again;
             errors, the messages that were refused or could not be read
"""
FARTHEST = 10_000.0
"""Largest coordinate of --position, m; as in the contract."""
NUMBERED_COPIES = 99
"""Largest number of names that --numbered tries."""


def parser() -> argparse.ArgumentParser:
    """Return the command line."""
    result = CommandParser(
        prog="iw-agent",
        usage="iw-agent MIND [options]\n       iw-agent MIND --help\n       iw-agent new DIR",
        description="Join a simulation with a body, and let a mind drive it.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    result.add_argument(
        "mind",
        metavar="MIND",
        help=f"{', '.join(minds.names())}; or a Python file that defines a class Mind or a function "
        "make(context); `new` writes the folder DIR, to start your own project from",
    )
    result.add_argument(
        "--name", metavar="NAME", help="the agent's name (default: the name of the mind or of its file)"
    )
    result.add_argument(
        "--robot",
        metavar="NAME|FILE",
        help=f"the body: an included robot or a robot file (default: {DEFAULT_ROBOT}; for the minds "
        f"{', '.join(OWN_ROBOTS)}: the robot of that name)",
    )
    result.add_argument(
        "--numbered",
        action="store_true",
        help="if the name is taken, try NAME-2, NAME-3 and so on: for several copies of one command",
    )
    result.add_argument(
        "--place",
        action="append",
        metavar="PLACE",
        help="a place of the map to start at; may be repeated; the first free one is used (default: any free place)",
    )
    result.add_argument(
        "--position",
        type=_position,
        metavar="X,Y,DEG",
        help="coordinates to start at instead of a place: metres, and the heading in degrees, anticlockwise from x; in "
        "the frame of the map, as those that `iw list places` prints, and not in that of its site; "
        "write --position=-1,2,90 if X is negative",
    )
    result.add_argument(
        "--role",
        choices=("both", "body", "mind"),
        default="both",
        help="both: a body and its mind; body: the body only; mind: the mind of a body that another process provides "
        "(default: both)",
    )
    result.add_argument(
        "--option",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="an option of the mind or, if NAME begins with a capital letter, a field of the robot; may be repeated",
    )
    result.add_argument(
        "--encoding", choices=("json", "xml"), default="json", help="the encoding of messages (default: json)"
    )
    result.add_argument(
        "--no-barrier",
        action="store_true",
        help="do not make the simulator wait for this agent in lockstep (default: as the robot says)",
    )
    add_crew_options(result)
    add_retry_option(result)
    add_link_options(result)
    add_process_options(result)
    return result


def main(arguments: Sequence[str] | None = None) -> int:
    """Run an agent, or write a starter project; return 0 when done, 1 if refused or failed, 2 for wrong usage."""
    words = sys.argv[1:] if arguments is None else list(arguments)
    if words[:1] == ["new"]:
        return _write_starter(words[1:])
    if words[:1] and words[0] in minds.names() and not {"-h", "--help"}.isdisjoint(words):
        print(mind_help(words[0]), end="")
        return 0
    options = parser().parse_args(words)
    # Before anything else: a signal may arrive while the arguments are still being checked.
    stop = stop_on_signals(options.lifeline)
    try:
        where = link_of(options)
        _check_together(options)
        check_crew_options(options)
        source = minds.find(options.mind)
        pairs, encoding = _pairs(options.option), Encoding.XML if options.encoding == "xml" else Encoding.JSON
        name = _name_of(options.mind) if options.name is None else options.name
        if options.count is not None:
            return _run_crew(options, source, pairs, name, where, encoding, stop)
        robot_options, mind_options = split_options(pairs)
        check_agent(name, "--name")
        for place in options.place or ():
            check_word(place, "--place")
        body = _body(options, source, robot_options, mind_options)
        _check_mind(options, source, body, mind_options, name)

        def run(agent: str, place: str | None) -> int:
            robot = joining(
                body,
                agent=check_agent(agent, "--name"),
                role=options.role,
                instance=new_hex(),
                place=place,
                barrier=False if options.no_barrier else None,
                position=options.position,
            )
            return run_agent(
                robot, source.make, mind_options, where=where, encoding=encoding, retry_for=options.retry_for, stop=stop
            )

        return _run_where_free(run, _names(name, options.numbered), iter(options.place or [None]))
    except (OptionError, WireError) as error:
        print(f"iw-agent: {error}", file=sys.stderr)
        return 2
    except (ConnectionError, MindError) as error:
        print(f"iw-agent: {error}", file=sys.stderr)
        return 1


def _run_crew(
    options: argparse.Namespace,
    source: minds.Source,
    pairs: dict[str, str],
    name: str,
    where: Link,
    encoding: Encoding,
    stop: threading.Event,
) -> int:
    instance = new_hex()
    members: list[CrewMember] = []
    bodies: dict[tuple[tuple[str, str], ...], tuple[Robot, dict[str, str]]] = {}
    for each in numbered(options.count, name, next(iter(options.place or ()), None), pairs):
        key = tuple(each.options.items())
        if key not in bodies:
            robot_options, mind_options = split_options(each.options)
            body = _body(options, source, robot_options, mind_options)
            _check_mind(options, source, body, mind_options, each.name)
            bodies[key] = body, mind_options
        body, mind_options = bodies[key]
        robot = joining(
            body, agent=each.name, role=options.role, instance=instance, place=each.place,
            barrier=False if options.no_barrier else None,
        )  # fmt: skip
        members.append(CrewMember(robot, source.make, mind_options))
    crew, retry_for = crew_name(options, name), options.retry_for
    return run_crew(crew, instance, members, where=where, encoding=encoding, retry_for=retry_for, stop=stop)


def _check_mind(
    options: argparse.Namespace, source: minds.Source, body: Robot, mind_options: dict[str, str], name: str
) -> None:
    driven = source.equip(_robot(options), Options(mind_options)) if options.role == "mind" else body
    own_body = options.role != "mind"
    check_mind_options(source, driven, mind_options, own_body=own_body, agent=name, position=options.position)


def _write_starter(words: list[str]) -> int:
    new_parser = CommandParser(
        prog="iw-agent new", description="Write a mind, a robot, a scene and tests that are ready to run."
    )
    new_parser.add_argument("folder", type=Path, metavar="DIR", help="the folder to write to; created if needed")
    folder: Path = new_parser.parse_args(words).folder
    try:
        check_output_folder(folder, "DIR")
        written = starter.write(folder)
    except WireError as error:
        print(f"iw-agent new: {error}", file=sys.stderr)
        return 2
    except OSError as error:
        print(f"iw-agent new: {error}", file=sys.stderr)
        return 1
    print(f"wrote {', '.join(str(path) for path in written)}")
    print(f"next: iw-run {folder / 'scene.xml'}, and pytest {folder}")
    return 0


def _body(
    options: argparse.Namespace, source: minds.Source, robot_options: dict[str, str], mind_options: dict[str, str]
) -> Robot:
    if options.role == "mind":
        if robot_options:
            name = next(iter(robot_options))
            raise OptionError(f"option {name}: expected an option of the mind for --role mind, got a robot field")
        # `equip` also declares what the mind accepts, such as user input. That counts in every role.
        return source.equip(Robot(), Options(mind_options))
    robot = equipped(_robot(options), robot_options)
    try:
        return source.equip(robot, Options(mind_options))
    except USER_ERRORS:
        raise
    except Exception as error:
        raise failed(source.equip, error) from error


def _robot(options: argparse.Namespace) -> Robot:
    """Return the robot that is asked for, or the default one of the mind."""
    name = default_robot(options.mind) if options.robot is None else options.robot
    with naming("--robot"):
        return robot_file(name)


def _check_together(options: argparse.Namespace) -> None:
    """Check that no option is given that another one makes meaningless.

    Raises:
        OptionError: One is.
    """
    if options.place and options.position is not None:
        raise OptionError("--position: expected one of --place and --position, got both")
    if options.role == "mind":
        for name in ("robot", "place", "position"):
            if getattr(options, name) is not None:
                raise OptionError(f"--{name}: expected a role with a body, got --role mind")


def _position(text: str) -> Position:
    try:
        x, y, degrees = (float(word) for word in text.split(","))
    except ValueError:
        x = math.nan
    if math.isnan(x) or not (abs(x) <= FARTHEST and abs(y) <= FARTHEST and abs(degrees) <= 360.0):
        expected = f"expected X,Y,DEG in metres up to {FARTHEST:g} and degrees up to 360"
        raise argparse.ArgumentTypeError(f"{expected}, got {text[:40]!r}")
    return Position(x=x, y=y, heading=math.radians(degrees))


def _pairs(given: Sequence[str]) -> dict[str, str]:
    pairs: dict[str, str] = {}
    for text in given:
        name, equals, value = text.partition("=")
        if not equals or not name:
            raise OptionError(f"--option: expected NAME=VALUE, got {text!r}")
        if name in pairs:
            raise OptionError(f"--option: expected each name once, got {name!r} twice")
        pairs[name] = value
    return pairs


def _run_where_free(run: Callable[[str, str | None], int], names: Iterator[str], places: Iterator[str | None]) -> int:
    """Run with the first free name and at the first free place, and return the exit code."""
    name, place = next(names), next(places)
    while True:
        code = run(name, place)
        try:
            if code == NAME_TAKEN:
                name = next(names)
            elif code == PLACE_TAKEN:
                place = next(places)
            else:
                return code
        except StopIteration:
            return 1


def _names(name: str, numbered: bool) -> Iterator[str]:
    """Yield the names to try."""
    yield name
    if numbered:
        for number in range(2, NUMBERED_COPIES + 1):
            yield f"{name}-{number}"


def _name_of(mind: str) -> str:
    return mind.rpartition("/")[2].removesuffix(".py").replace(".", "-")


if __name__ == "__main__":
    sys.exit(main())
