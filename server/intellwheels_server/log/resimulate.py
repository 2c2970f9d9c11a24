"""Running a log again: the same inputs must give the same hash at every tick."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from intellwheels_server.log.input_log import Header, Line, LogError, read_header, read_lines
from intellwheels_server.world import Outputs, State, advance, apply, begin, digest


@dataclass(frozen=True, slots=True)
class Finding:
    """What came of running a log again.

    Attributes:
        ticks: Steps that were made.
        tick: Where the run is.
        hash: The hash after the last step, which is the one a run that ended told; who left after it does not count.
        cut: Whether the last line was cut and dropped.
        differs: In words, the first tick whose hash differs, or None.
    """

    ticks: int
    tick: int
    hash: str
    cut: bool = False
    differs: str | None = None


def first_state(header: Header, name: str) -> State:
    """Return the state at the beginning of a log.

    Raises:
        LogError: There is no such world.
    """
    try:
        return begin(header.world_setup(), header.run)
    except ValueError as error:
        raise LogError(f"{name}:1: {error}") from None


def replay(state: State, line: Line, where: str) -> tuple[State, Outputs]:
    """Return the state after a line of a log, and what came out.

    Raises:
        LogError: The line is of another tick.
    """
    if not line.stepped:
        return apply(state, line.inputs.changes)
    if line.tick != state.tick:
        raise LogError(f"{where}: expected tick {state.tick}, got {line.tick}")
    return advance(state, line.inputs)


def difference(state: State, line: Line, number: int, found: str) -> str:
    """Return in words that the hash after a line is not the recorded one."""
    return f"tick {line.tick} of run {state.run} (line {number}): expected hash {line.hash}, got {found}"


def resimulate(path: Path, progress: Callable[[int], None] = lambda _ticks: None) -> Finding:
    """Run a log again and compare every hash.

    Args:
        path: The log.
        progress: Called with the number of steps, every thousand.

    Raises:
        LogError: The file is no log, or its lines do not follow each other.
        OSError: The file cannot be read.
    """
    with path.open("rb") as file:
        header = read_header(file, str(path))
        state = first_state(header, str(path))
        steps, last = 0, digest(state)
        for number, line in enumerate(read_lines(file, str(path)), start=2):
            if line is None:
                return Finding(steps, state.tick, last, cut=True)
            state, _ = replay(state, line, f"{path}:{number}")
            if line.stepped:
                steps += 1
                if steps % 1000 == 0:
                    progress(steps)
            found = digest(state)
            if line.stepped:
                last = found
            if found != line.hash:
                return Finding(steps, state.tick, found, differs=difference(state, line, number, found))
    return Finding(steps, state.tick, last)
