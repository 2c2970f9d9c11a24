"""The result of a run, for people and for programs. Pure: a result in, a table, lines or JSON out."""

from __future__ import annotations

import math
import shlex
from collections.abc import Iterator
from typing import Final, Literal, TypeAlias

import msgspec
from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from intellwheels_experiments.run.verdict import AgentResult
from intellwheels_schemas.version import UNKNOWN, versions_of

Finish: TypeAlias = Literal["ended", "missed", "died", "interrupted", "overtime"]

LINES_HELP: Final = """
a run's lines, where standard output is no terminal (on a terminal a table has the same, with `turned` in degrees):
  agent    for each agent: place, its goal; reached, whether it was there at the end; distance, how far it was from it
           then; contacts, their number; path, its length; age, the mean age of its commands, 0 in lockstep;
           turned_deg, the largest angle from its first heading; `-` where a value does not apply
  run      ticks and time are simulated, wall is real; factor is time / wall; late counts ticks that began too late
  held, not-held    whether all conditions of the scene held; `failed` lines say which did not; finish is how the run
           ended: ended (as the scene says), missed (a lockstep answer did not come), died (a process ended),
           interrupted, or overtime (--timeout)
"""
"""What the lines mean, for the help of the command."""
_DISTRIBUTIONS: Final = ("intellwheels", "eclipse-zenoh", "msgspec", "numpy", "numba")
_HEADS: Final = ("agent", "mind", "robot", "place", "reached", "distance", "contacts", "path", "age", "turned")


class Result(msgspec.Struct, frozen=True, kw_only=True):
    """The result of a run, as `--json` writes it.

    Attributes:
        scene: The scene's name.
        map: Its map.
        seed: The seed.
        pace: The pace.
        world: The world's name.
        run: The run's id.
        finish: How it finished: `ended` as the scene says, `missed` for a lockstep answer that did not come, `died`
            for a process that ended, `interrupted` from outside, `overtime` after too much wall time.
        words: The details of that.
        held: Whether all conditions of the scene held.
        failed: A sentence for each condition that did not.
        hash: The state hash at the end; None if the run did not reach its end.
        ticks: Number of ticks.
        time: Simulated time in s.
        wall: Wall time from the first tick to the last in s.
        factor: Simulated time divided by wall time.
        late: Number of ticks that began late.
        contacts: Number of contacts.
        events: Number of events by code.
        agents: One result per agent of the cast.
        versions: Versions of Python, of this distribution and of its main dependencies.
        further: Number of runs that were started from the page after this one and reached their end. They count in no
            other field.
    """

    scene: str
    map: str
    seed: str
    pace: str
    world: str
    run: str | None
    finish: Finish
    words: str
    held: bool
    failed: tuple[str, ...]
    hash: str | None
    ticks: int
    time: float
    wall: float
    factor: float
    late: int
    contacts: int
    events: dict[str, int]
    agents: tuple[AgentResult, ...]
    versions: dict[str, str]
    further: int = 0


def to_json(result: Result) -> bytes:
    """Return the result as indented JSON with a final newline."""
    return msgspec.json.format(msgspec.json.encode(result), indent=2) + b"\n"


def show(result: Result, console: Console) -> None:
    """Print the result: a table on a terminal, plain lines elsewhere."""
    if console.is_terminal:
        console.print(_table(result))
        console.print(Text(_figures(result)), soft_wrap=True)
        for sentence in _further(result):
            console.print(Text(sentence), soft_wrap=True)
        for sentence in result.failed:
            console.print(Text(sentence, style="red"), soft_wrap=True)
        console.print(Text(_headline(result), style="bold green" if result.held else "bold red"), soft_wrap=True)
        return
    for line in lines(result):
        # Not with the console's print, which would wrap and colour what a script reads.
        console.file.write(line + "\n")
    console.file.flush()


def lines(result: Result) -> Iterator[str]:
    """Return the result as lines for a script: the verb first, then `name=value`."""
    for agent in result.agents:
        # A command line has spaces.
        cells = [shlex.quote(cell) for cell in _cells(agent)]
        yield "agent " + " ".join(f"{head}={value}" for head, value in zip(_KEYS, cells, strict=True))
    yield _figures(result)
    yield from _further(result)
    yield from (f"failed {sentence}" for sentence in result.failed)
    yield _headline(result)


def versions() -> dict[str, str]:
    """Return the versions of Python, of this distribution and of those of its main dependencies that are installed."""
    return {name: version for name, version in versions_of(*_DISTRIBUTIONS).items() if version != UNKNOWN}


_KEYS: Final = ("name", "mind", "robot", "place", "reached", "distance", "contacts", "path", "age", "turned_deg")


def _cells(agent: AgentResult) -> tuple[str, ...]:
    return (
        agent.name,
        agent.mind,
        agent.robot or "-",
        agent.place or "-",
        {True: "yes", False: "no", None: "-"}[agent.reached],
        "-" if agent.distance is None else f"{agent.distance:.3f}m",
        str(agent.contacts),
        f"{agent.path:.2f}m",
        f"{agent.command_age:.3f}s",
        f"{math.degrees(agent.turned):.0f}",
    )


def _table(result: Result) -> Table:
    title = Text(f"{result.scene}, seed {result.seed}, {result.pace}")
    table = Table(box=box.SIMPLE_HEAD, title=title, title_justify="left", padding=0)
    for index, head in enumerate(_HEADS):
        table.add_column(head, justify="left" if index < 5 else "right", no_wrap=True)
    for agent in result.agents:
        style = "red" if agent.reached is False or not agent.seen else None
        cells = _cells(agent)
        table.add_row(*cells[:-1], f"{cells[-1]}°", style=style)
    return table


def _figures(result: Result) -> str:
    return (
        f"run ticks={result.ticks} time={result.time:.2f}s wall={result.wall:.2f}s factor={result.factor:.1f} "
        f"contacts={result.contacts} late={result.late} seed={result.seed} hash={result.hash or '-'}"
    )


def _further(result: Result) -> Iterator[str]:
    """Return a sentence about runs that followed the one of the result; none if none did."""
    if result.further:
        runs = "1 further run was" if result.further == 1 else f"{result.further} further runs were"
        yield f"note this is the result of run 1; {runs} started from the page, each with a line of its own above"


def _headline(result: Result) -> str:
    held = "held" if result.held else "not-held"
    # Somebody who has just seen the fourth run must not take this for its verdict.
    which = f"run=1 further={result.further} " if result.further else ""
    return f"{held} scene={result.scene} {which}finish={result.finish} {result.words}".rstrip()
