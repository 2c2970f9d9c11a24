"""Re-simulation: the inputs of a log must give the recorded hash at every tick."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from intellwheels_server.log.input_log import Header, Line, LogError, read_header, read_lines
from intellwheels_server.world import Outputs, State, advance, apply, begin, digest


@dataclass(frozen=True, slots=True)
class Resimulation:
    """The result of a re-simulation.

    Attributes:
        ticks: Steps made.
        tick: The last tick.
        hash: The hash after the last step, as the run printed it; leaves after that step are ignored.
        cut: Whether the last line was incomplete and dropped.
        differs: Where the first hash differs, as text, or None.
    """

    ticks: int
    tick: int
    hash: str
    cut: bool = False
    differs: str | None = None


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
        LogError: The file is no log, or a line is missing.
        OSError: The file cannot be read.
    """
    with path.open("rb") as file:
        header = read_header(file, str(path))
        state = first_state(header, str(path))
        steps, last = 0, digest(state)
        for number, line in enumerate(read_lines(file, str(path)), start=2):
            if line is None:
                return Resimulation(steps, state.tick, last, cut=True)
            state, _ = replay(state, line, f"{path}:{number}")
            if line.stepped:
                steps += 1
                if steps % 1000 == 0:
                    progress(steps)
            found = digest(state)
            if line.stepped:
                last = found
            if found != line.hash:
                return Resimulation(steps, state.tick, found, differs=difference(state, line, number, found))
    return Resimulation(steps, state.tick, last)
