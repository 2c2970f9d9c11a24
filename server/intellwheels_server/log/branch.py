"""A branch: a run that repeats the log of another run up to a tick, and from there follows its own agents.

Agents join at tick 0. Before the branch they get the same measures as in the parent run, and their answers have no
effect. So at the branch a mind remembers the same as in the parent run. Up to the branch all states have the hashes of
the parent, so a body that differs from the parent's is noticed at once.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import msgspec

from intellwheels_schemas.file_records import Inputs, Join, Note
from intellwheels_schemas.input_reader import cut_text
from intellwheels_server.log.input_log import Header, Line, LogError, LogReader
from intellwheels_server.world import Setup

_NOTES: Final = ("paused", "resumed", "speed")


@dataclass(frozen=True, slots=True)
class Branch:
    """The part of a log that a branch repeats.

    Attributes:
        header: The first line of the log.
        at: The first tick that is not repeated.
        lines: The steps before it, by tick.
        agents: The agents that joined before the first step, for which the branch waits.
    """

    header: Header
    at: int
    lines: Mapping[int, Line]
    agents: tuple[str, ...]

    def inputs(self, tick: int) -> Inputs | None:
        """Return the inputs of the step from a tick, without joins; None from the branch on."""
        line = self.lines.get(tick)
        return None if line is None else msgspec.structs.replace(line.inputs, changes=())

    def differs(self, tick: int, hashed: str) -> str | None:
        """Return a text if the hash after the step from a tick differs from the parent's, or None if it does not."""
        line = self.lines.get(tick)
        if line is None or line.hash == hashed:
            return None
        return f"tick {tick + 1}: expected the parent's hash {line.hash}, got {hashed}"

    def setup(self, changes: Mapping[str, object]) -> Setup:
        """Return the setup of the parent, with changes."""
        return msgspec.structs.replace(self.header.world_setup(), **changes)


def read_branch(path: Path, at: int) -> Branch:
    """Return the part of a log that a branch repeats.

    Args:
        path: The log of one run, as `iw-server --runs` or `iw-run` writes it.
        at: The tick of the branch.

    Raises:
        LogError: The file is no log, is edited, has no such tick, or has changes before it that a branch cannot repeat.
        OSError: The file cannot be read.
    """
    lines: dict[int, Line] = {}
    agents: list[str] = []
    with path.open("rb") as file:
        reader = LogReader(file, str(path))
        done = False
        for line in reader.read_all(file):
            # The rest is read for its checksums only.
            done = done or (line.stepped and line.tick >= at)
            if done:
                continue
            for change in line.inputs.changes:
                if isinstance(change, Join) and line.tick == 0:
                    agents.append(change.agent)
                elif not (isinstance(change, Note) and change.code in _NOTES):
                    what = type(change).__name__
                    raise LogError(f"{path}:{reader.lines}: expected only joins at tick 0 before a branch, got {what}")
            if line.stepped:
                lines[line.tick] = line
    if len(lines) < at:
        why = f": {cut_text(str(path), len(lines))}" if reader.cut else ""
        raise LogError(f"{path}: expected a tick in [0, {len(lines)}] to branch at, got {at}{why}")
    return Branch(reader.first, at, lines, tuple(dict.fromkeys(agents)))
