"""The rows of a sweep are in the cell of their levels."""

from __future__ import annotations

from intellwheels_experiments.batch.experiment_rows import Row, rows_of
from intellwheels_experiments.batch.summary import summarize
from intellwheels_experiments.batch.sweep import sweep
from intellwheels_maps import scene
from tests.experiments.runs import stored

DOOR = scene("door")


def test_every_row_is_where_its_levels_cross() -> None:
    rows = rows_of(DOOR)
    summary = summarize(rows, [stored(row.name, "1") for row in rows], DOOR.experiment)
    found = sweep(DOOR.experiment, summary.lines)
    assert found is not None
    assert found.down == ("Speed", "Swing")
    assert found.across == ("Range of its sensors", "Opening time")
    assert (len(found.rows), len(found.columns)) == (3 * 2, 4 * 2)
    for titles, cells in found.rows:
        for column, line in zip(found.columns, cells, strict=True):
            assert line is not None
            assert line.title == ", ".join((*titles, *column))


def test_row_that_was_not_run_is_an_empty_cell() -> None:
    rows = rows_of(DOOR)[:3]
    summary = summarize(rows, [stored(row.name, "1") for row in rows], DOOR.experiment)
    found = sweep(DOOR.experiment, summary.lines)
    assert found is not None
    [(titles, cells)] = found.rows
    assert titles == ("0.5 m/s", "opens away")
    assert [line.name if line else None for line in cells] == [*(row.name for row in rows), *[None] * 5]


def test_one_factor_is_no_grid() -> None:
    rows = rows_of(scene("follow"))
    summary = summarize(rows, [stored(row.name, "1") for row in rows], None)
    assert sweep(scene("follow").experiment, summary.lines) is None
    assert sweep(None, summary.lines) is None


def test_rows_that_are_not_of_the_experiment_are_no_grid() -> None:
    rows = [Row(name, name, False, DOOR, (), {}) for name in ("parent", "branch")]
    summary = summarize(rows, [stored(row.name, "1") for row in rows], None)
    assert sweep(DOOR.experiment, summary.lines) is None
