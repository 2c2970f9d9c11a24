"""A run that begins as another went: up to a tick the inputs are those of its log, from there on those that come.

Whoever joins lives through the ticks before as well, perceives what was perceived and is asked for answers, which are
not obeyed: at the branch a mind has the memory it would have. Up to there the states are the parent's, to the hash; a
body that is another than the parent's shows at once.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import msgspec

from intellwheels_server.log.input_log import Header, Line, LogError, read_header, read_lines
from intellwheels_server.world import Setup
from intellwheels_server.world.inputs import Inputs, Join, Note

_NOTES: Final = ("paused", "resumed", "speed")


@dataclass(frozen=True, slots=True)
class Branch:
    """What of a log a branch takes.

    Attributes:
        header: Of the log.
        at: The first tick that is not taken.
        lines: The steps before it, by tick.
        agents: Who joined before the first step: whom the branch awaits.
    """

    header: Header
    at: int
    lines: Mapping[int, Line]
    agents: tuple[str, ...]

    def inputs(self, tick: int) -> Inputs | None:
        """Return what acted on the step from a tick, less who joined; None from the branch on."""
        line = self.lines.get(tick)
        return None if line is None else msgspec.structs.replace(line.inputs, changes=())

    def differs(self, tick: int, hashed: str) -> str | None:
        """Return in words that the step from a tick led elsewhere than in the parent, if it did."""
        line = self.lines.get(tick)
        if line is None or line.hash == hashed:
            return None
        return f"tick {tick + 1}: expected the parent's hash {line.hash}, got {hashed}"

    def setup(self, changes: Mapping[str, object]) -> Setup:
        """Return what the world is made of: as the parent's, with changes."""
        return msgspec.structs.replace(self.header.world_setup(), **changes)


def read_branch(path: Path, at: int) -> Branch:
    """Return what a branch takes of a log.

    Args:
        path: The log of one run, as `iw-server --runs` or `iw-run` writes it.
        at: The tick to branch at.

    Raises:
        LogError: The file is no log, has no such tick, or has changes before it that nobody can make again.
        OSError: It cannot be read.
    """
    lines: dict[int, Line] = {}
    agents: list[str] = []
    with path.open("rb") as file:
        header = read_header(file, str(path))
        for number, line in enumerate(read_lines(file, str(path)), start=2):
            if line is None or (line.stepped and line.tick >= at):
                break
            for change in line.inputs.changes:
                if isinstance(change, Join) and line.tick == 0:
                    agents.append(change.agent)
                elif not (isinstance(change, Note) and change.code in _NOTES):
                    what = type(change).__name__
                    raise LogError(f"{path}:{number}: expected only joins at tick 0 before a branch, got {what}")
            if line.stepped:
                lines[line.tick] = line
    if len(lines) < at:
        raise LogError(f"{path}: expected a tick in [0, {len(lines)}] to branch at, got {at}")
    return Branch(header, at, lines, tuple(dict.fromkeys(agents)))
