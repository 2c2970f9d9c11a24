"""A sweep at a glance: the rows of several factors as a grid, the last factors across. Pure: a batch in, cells out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Final

from intellwheels_experiments.batch.summary import Line
from intellwheels_schemas.messages import Experiment, Level, Varied

ACROSS: Final = 2
"""Factors across where there are more than two; of two it is the last."""


@dataclass(frozen=True)
class Sweep:
    """Rows as a grid.

    Attributes:
        down: Titles of the factors whose levels go down.
        across: Titles of the factors whose levels go across.
        columns: The levels of each column.
        rows: The levels of each line and its cells, in the order of the columns; None where a row was not run.
    """

    down: tuple[str, ...]
    across: tuple[str, ...]
    columns: tuple[tuple[str, ...], ...]
    rows: tuple[tuple[tuple[str, ...], tuple[Line | None, ...]], ...]


def sweep(experiment: Experiment | None, lines: Sequence[Line]) -> Sweep | None:
    """Return the rows of a batch as a grid, None of an experiment with less than two factors or with one row."""
    factors = experiment.factor if experiment else ()
    if len(factors) < 2 or len(lines) < 2:
        return None
    cut = len(factors) - (ACROSS if len(factors) > ACROSS else 1)
    known = {line.name: line for line in lines}
    columns = list(product(*(factor.level for factor in factors[cut:])))
    rows = []
    for levels in product(*(factor.level for factor in factors[:cut])):
        cells = tuple(known.get("+".join(level.name for level in (*levels, *column))) for column in columns)
        if any(cells):
            rows.append((_titles(levels), cells))
    if not rows:
        return None
    return Sweep(
        down=_titles(factors[:cut]), across=_titles(factors[cut:]),
        columns=tuple(_titles(column) for column in columns), rows=tuple(rows),
    )  # fmt: skip


def _titles(named: Sequence[Varied | Level]) -> tuple[str, ...]:
    return tuple(one.title or one.name for one in named)
