"""Every row of `reports.py` has the right value, or names a test that exists. No fault of this project is left out."""

from __future__ import annotations

import ast
from functools import cache
from pathlib import Path

from tests.every_case import every_case
from tests.reports import REPORTS, Report

ROOT = Path(__file__).parent.parent

FAULTS = {*(f"S{number}" for number in range(1, 8)), *(str(number) for number in range(1, 19))}
"""The faults that were found in use, by their number."""

ELSEWHERE = [report for report in REPORTS if report.held_by]
HERE = [report for report in REPORTS if not report.held_by]


@cache
def _tests_in(file: str) -> frozenset[str]:
    tree = ast.parse((ROOT / file).read_text())
    return frozenset(node.name for node in tree.body if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)))


@every_case("report", HERE, ids=lambda report: report.about)
def test_the_value_is_right(report: Report) -> None:
    assert report.case is not None
    assert report.case() == report.right


@every_case("report", ELSEWHERE, ids=lambda report: report.about)
def test_the_test_that_holds_it_exists(report: Report) -> None:
    assert report.case is None, "expected an input or the name of a test, got both"
    file, _, name = report.held_by.partition("::")
    assert name.startswith("test_")
    assert name in _tests_in(file)


def test_every_fault_of_this_project_has_a_row() -> None:
    found = {report.fault for report in REPORTS if report.fault}
    assert found - FAULTS == set()
    assert FAULTS - found == set()


def test_no_report_is_there_twice() -> None:
    abouts = [report.about for report in REPORTS]
    assert len(set(abouts)) == len(abouts)
