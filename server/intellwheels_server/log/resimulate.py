"""Re-simulation: the inputs of a log must give the recorded hash at every tick."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from intellwheels_server.log.input_log import Header, Line, LogError, LogReader
from intellwheels_server.world import Outputs, State, advance, apply, begin, digest


@dataclass(frozen=True, slots=True)
class Resimulation:
    """The result of a re-simulation.

    Attributes:
        ticks: Steps made.
        tick: The last tick.
        hash: The hash after the last step, as the run printed it; leaves after that step are ignored.
        header: The first line of the log.
        runs: Runs in the log: a reset or a restored state begins another one.
        cut: Whether the end of the log is missing.
        differs: Where the first hash differs, as text, or None.
        chain: The checksum of all lines; empty for a log without checksums.
    """

    ticks: int
    tick: int
    hash: str
    header: Header = field(repr=False)
    runs: int = 1
    cut: bool = False
    differs: str | None = None
    chain: str = ""


def first_state(header: Header, name: str) -> State:
    """Return the first state of a log.

    Raises:
        LogError: No such world can be made.
    """
    try:
        return begin(header.world_setup(), header.run)
    except ValueError as error:
        raise LogError(f"{name}:1: {error}") from None


def replay(state: State, line: Line, where: str) -> tuple[State, Outputs]:
    """Return the state after a line of a log, and its outputs.

    Raises:
        LogError: The line belongs to another tick.
    """
    if not line.stepped:
        return apply(state, line.inputs.changes)
    if line.tick != state.tick:
        raise LogError(f"{where}: expected tick {state.tick}, got {line.tick}")
    return advance(state, line.inputs)


def difference(state: State, line: Line, number: int, found: str) -> str:
    """Return a text that says where a hash differs from the recorded one."""
    return f"tick {line.tick} of run {state.run} (line {number}): expected hash {line.hash}, got {found}"


def resimulate(path: Path, progress: Callable[[int], None] = lambda _ticks: None) -> Resimulation:
    """Run a log again and compare every hash, up to the first that differs.

    Args:
        path: The log.
        progress: Called with the number of steps, every thousand steps.

    Raises:
        LogError: The file is no log, it is edited, or a line is missing.
        OSError: The file cannot be read.
    """
    with path.open("rb") as file:
        reader = LogReader(file, str(path))
        header = reader.first
        state = first_state(header, str(path))
        steps, last, runs = 0, digest(state), 1
        for line in reader.read_all(file):
            before = state.run
            state, _ = replay(state, line, f"{path}:{reader.lines}")
            runs += state.run != before
            if line.stepped:
                steps += 1
                if steps % 1000 == 0:
                    progress(steps)
            found = digest(state)
            if line.stepped:
                last = found
            if found != line.hash:
                text = difference(state, line, reader.lines, found)
                return Resimulation(steps, state.tick, found, header, runs, differs=text, chain=reader.chain)
    return Resimulation(steps, state.tick, last, header, runs, cut=reader.cut, chain=reader.chain)
