"""Tests of many cases: each case runs, and each that fails is named."""

from __future__ import annotations

import inspect
from typing import Any

import pytest

from tests.every_case import CasesFailedError, every_case


def names(test: Any, **fixtures: object) -> list[str]:
    with pytest.raises(CasesFailedError) as found:
        test(**fixtures)
    assert all(name in str(found.value) for name, _ in found.value.failed)
    return [name for name, _ in found.value.failed]


def test_every_case_runs_and_all_that_fail_are_named() -> None:
    ran = []

    @every_case("number", range(5))
    def odd(number: int) -> None:
        ran.append(number)
        if number == 2:
            pytest.fail("two")
        assert number % 2

    assert names(odd) == ["0", "2", "4"]
    assert ran == [0, 1, 2, 3, 4]


def test_cases_without_a_failure_pass() -> None:
    @every_case("number", [1, 3])
    def odd(number: int) -> None:
        assert number % 2

    odd()


def test_cases_may_have_several_values_and_names() -> None:
    @every_case(("number", "right"), [(1, 2), pytest.param(2, 2, id="two"), pytest.param(3, 2, id="three")])
    def same(number: int, right: int) -> None:
        assert number == right

    @every_case("number", [1, 2], ids=["one", "two"])
    @every_case("text, length", [("a", 1), ("bc", 2)], ids=lambda value: f"<{value}>")
    def long(number: int, text: str, length: int) -> None:
        assert number == len(text) == length

    assert names(same) == ["1-2", "three"]
    assert names(long) == ["one, <bc>-<2>", "two, <a>-<1>"]


def test_failure_keeps_its_traceback_and_says_its_case() -> None:
    @every_case("number", [7])
    def fails(number: int) -> None:
        raise KeyError(number)

    with pytest.raises(CasesFailedError, match="failed cases: 7") as found:
        fails()
    (error,) = found.value.exceptions
    assert isinstance(error, KeyError)
    assert error.__notes__ == ["case: 7"]
    assert error.__traceback__ is not None


def test_what_is_no_case_is_a_fixture() -> None:
    @every_case("number", [1, 2])
    def same(number: int, fixture: int) -> None:
        assert number == fixture

    assert list(inspect.signature(same).parameters) == ["fixture"]
    assert names(same, fixture=2) == ["1"]


def test_skips_end_the_test() -> None:
    @every_case("number", [1, 2])
    def skips(number: int) -> None:
        pytest.skip("not here")

    with pytest.raises(pytest.skip.Exception):
        skips()


def test_a_wrong_table_is_refused_when_it_is_made() -> None:
    def test(number: int) -> None: ...

    with pytest.raises(AssertionError, match="at least one case"):
        every_case("number", [])
    with pytest.raises(AssertionError, match="expected 2 ids, got 1"):
        every_case("number", [1, 2], ids=["one"])
    with pytest.raises(AssertionError, match="without marks"):
        every_case("number", [pytest.param(1, marks=pytest.mark.xfail)])
    with pytest.raises(AssertionError, match="expected 2 values"):
        every_case("a, b", [(1, 2, 3)])
    with pytest.raises(AssertionError, match=r"expected the arguments \['other'\]"):
        every_case("other", [1])(test)
