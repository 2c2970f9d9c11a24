"""A sweep as a grid: factors down, the last factors across. Pure: the rows of a batch in, cells out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Final

from intellwheels_experiments.batch.summary import RowSummary
from intellwheels_schemas.messages import Experiment, Level, Varied

ACROSS: Final = 2
"""Number of factors across, if there are more than two. Of two factors the last one is across."""


@dataclass(frozen=True)
class Sweep:
    """The rows of a batch as a grid.

    Attributes:
        down: The titles of the factors whose levels go down.
        across: The titles of the factors whose levels go across.
        columns: The titles of the levels of each column.
        rows: The titles of the levels of each line, and its cells in the order of the columns; None for a row that was
            not run.
    """

    down: tuple[str, ...]
    across: tuple[str, ...]
    columns: tuple[tuple[str, ...], ...]
    rows: tuple[tuple[tuple[str, ...], tuple[RowSummary | None, ...]], ...]


def sweep(experiment: Experiment | None, summaries: Sequence[RowSummary]) -> Sweep | None:
    """Return the rows of a batch as a grid; None with fewer than two factors or fewer than two rows."""
    factors = experiment.factor if experiment else ()
    if len(factors) < 2 or len(summaries) < 2:
        return None
    cut = len(factors) - (ACROSS if len(factors) > ACROSS else 1)
    by_name = {summary.name: summary for summary in summaries}
    columns = list(product(*(factor.level for factor in factors[cut:])))
    rows = []
    for levels in product(*(factor.level for factor in factors[:cut])):
        cells = tuple(by_name.get("+".join(level.name for level in (*levels, *column))) for column in columns)
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
