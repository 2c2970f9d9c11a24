"""Many small cases in one test: for what takes microseconds, a test for each case costs more than the cases."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import pytest

Test = Callable[..., None]


class CasesFailedError(ExceptionGroup[Exception]):
    """All failures of a test, each with a note that names its case.

    Attributes:
        failed: The name of each case that failed, and its failure.
    """

    failed: list[tuple[str, Exception]]

    def __new__(cls, failed: list[tuple[str, Exception]]) -> CasesFailedError:
        """Return the failures as one, with the names in its message."""
        names = "; ".join(name for name, _ in failed)
        made = super().__new__(cls, f"failed cases: {names}", [error for _, error in failed])
        made.failed = failed
        return made


def every_case(
    names: str | Sequence[str],
    cases: Iterable[Any],
    *,
    ids: Callable[[Any], object] | Sequence[str] | None = None,
) -> Callable[[Test], Test]:
    """Return a decorator that runs a test for every case, also after one has failed.

    It takes what `pytest.mark.parametrize` takes, and may stand on another of its kind. Fixtures are shared by the
    cases of a test. A test whose cases skip, have marks or take long is parametrised instead.

    Args:
        names: The arguments that a case gives, as a sequence or separated by commas.
        cases: For each case the value of the argument, or as many values as there are names, or a `pytest.param`.
        ids: The names of the cases, or a function from a value to its name. By default values are shown as by `repr`.
    """
    wanted = [name.strip() for name in names.split(",")] if isinstance(names, str) else list(names)
    rows = [_row(case, len(wanted)) for case in cases]
    assert rows, "expected at least one case"
    if ids is not None and not callable(ids):
        assert len(ids) == len(rows), f"expected {len(rows)} ids, got {len(ids)}"
        rows = [(name, values) for name, (_, values) in zip(ids, rows, strict=True)]
    shown = ids if callable(ids) else repr

    def decorate(test: Test) -> Test:
        signature = inspect.signature(test)
        left = [parameter for name, parameter in signature.parameters.items() if name not in wanted]
        assert len(left) + len(wanted) == len(signature.parameters), f"expected the arguments {wanted}, got {signature}"

        @functools.wraps(test)
        def run(**fixtures: Any) -> None:
            failed: list[tuple[str, Exception]] = []
            for name, values in rows:
                try:
                    test(**dict(zip(wanted, values, strict=True)), **fixtures)
                except (Exception, pytest.fail.Exception) as error:
                    failed += _failures(name or "-".join(str(shown(value)) for value in values), error)
            if failed:
                raise CasesFailedError(failed)

        # What is left are fixtures.
        run.__dict__["__signature__"] = signature.replace(parameters=left)
        return run

    return decorate


def _row(case: Any, count: int) -> tuple[str | None, tuple[Any, ...]]:
    """Return the name that a case brings along, and its values."""
    name = None
    if isinstance(case, type(pytest.param())):
        assert not case.marks, f"expected a case without marks, got {case}"
        name, case = case.id, case.values if count > 1 else case.values[0]
    values = tuple(case) if count > 1 else (case,)
    assert len(values) == count, f"expected {count} values, got {values}"
    return (None if name is None else str(name)), values


def _failures(name: str, error: BaseException) -> list[tuple[str, Exception]]:
    """Return the failures of one case: several, if it has cases of its own."""
    if isinstance(error, CasesFailedError):
        return [(f"{name}, {inner}", one) for inner, one in error.failed]
    if not isinstance(error, Exception):
        error = AssertionError(str(error))
    error.add_note(f"case: {name}")
    return [(name, error)]
