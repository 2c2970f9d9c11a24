"""The options of `iw-agent` that host many agents in one process, and the members that they describe. Pure."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from typing import Final, NamedTuple

from intellwheels_agents.options import OptionError
from intellwheels_schemas.names import check_agent, check_name, check_word
from intellwheels_schemas.rules import MAX_CREW

NUMBER: Final = "{n}"
"""Stands for the number of a member in --name, --place and --option."""


class Numbered(NamedTuple):
    """What the options say about one member of a crew.

    Attributes:
        name: Its name.
        place: The place to start at; None leaves the choice to the simulator.
        options: Its options, of the mind and of the robot.
    """

    name: str
    place: str | None
    options: dict[str, str]


def add_crew_options(parser: argparse.ArgumentParser) -> None:
    """Add the options for many agents in one process."""
    group = parser.add_argument_group("many agents in one process")
    group.add_argument(
        "--count", type=_count, metavar="N",
        help=f"host so many agents, at most {MAX_CREW}, as a crew: one message each way per tick for all of them. The "
        f"names are NAME1, NAME2 and so on, or {NUMBER} stands for the number, as in --name bed{NUMBER}-chair; so it "
        "does in --place and in the values of --option",
    )  # fmt: skip
    group.add_argument(
        "--crew", metavar="NAME",
        help=f"name of the crew, with --count (default: --name without {NUMBER} and the characters - and _ around it)",
    )  # fmt: skip


def check_crew_options(options: argparse.Namespace) -> None:
    """Check that no option contradicts `--count`.

    Raises:
        OptionError: One does.
    """
    if options.count is None:
        if options.crew is not None:
            raise OptionError("--crew: expected with --count only")
        return
    for name, given in (("--numbered", options.numbered), ("--position", options.position is not None)):
        if given:
            raise OptionError(f"{name}: expected without --count, as no two bodies have one name or position")
    if options.role == "body":
        raise OptionError("--count: expected the role both or mind, got body")
    places = options.place or []
    if len(places) > 1 or (options.count > 1 and any(NUMBER not in place for place in places)):
        raise OptionError(f"--place: expected one place with {NUMBER} for the number of the agent, got {places[-1]!r}")


def crew_name(options: argparse.Namespace, name: str) -> str:
    """Return the name of the crew.

    Args:
        options: The parsed options.
        name: The name, or the pattern of names, of its agents.

    Raises:
        WireError: It is no name.
    """
    if options.crew is not None:
        return check_name(options.crew, "--crew")
    return check_name("-".join(part.strip("-_") for part in name.split(NUMBER) if part.strip("-_")), "--crew")


def numbered(count: int, name: str, place: str | None, options: Mapping[str, str]) -> Iterator[Numbered]:
    """Yield what the options say about each member.

    Args:
        count: Number of members.
        name: The pattern of their names; without a place for the number, it comes last.
        place: The pattern of their places, if any.
        options: Their options; the number may stand in the values.

    Raises:
        WireError: A name or a place is invalid.
    """
    pattern = name if NUMBER in name else f"{name}{NUMBER}"
    for number in map(str, range(1, count + 1)):
        yield Numbered(
            check_agent(pattern.replace(NUMBER, number), "--name"),
            None if place is None else check_word(place.replace(NUMBER, number), "--place"),
            {option: value.replace(NUMBER, number) for option, value in options.items()},
        )


def _count(text: str) -> int:
    if text.isdecimal() and 1 <= int(text) <= MAX_CREW:
        return int(text)
    raise argparse.ArgumentTypeError(f"expected a number of agents from 1 to {MAX_CREW}, got {text!r}")
