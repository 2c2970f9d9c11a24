from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

from intellwheels_agents.mind_error import failed, place_in, wrong_answer


class Mind:
    def decide(self, measures: object) -> object:
        return json.loads(str(measures))


def test_line_is_that_of_the_mind_and_not_of_the_library_that_it_calls(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(Path(__file__).parent)
    mind = Mind()
    try:
        mind.decide("{")
    except ValueError as error:
        text = str(failed(mind, error))
    line = Mind.decide.__code__.co_firstlineno + 1
    assert text.startswith(f"test_mind_error.py:{line}: decide: JSONDecodeError: Expecting property name")


def test_exception_without_a_line_is_told_too() -> None:
    assert str(failed(Mind, ValueError("no"))) == "a mind: ValueError: no"


def test_answer_is_shown_in_short() -> None:
    text = str(wrong_answer(Mind(), "Actions", "x" * 1000))
    assert text.endswith("(str)")
    assert len(text) < 300


def test_place_of_a_thread_is_outside_of_libraries() -> None:
    assert "test_mind_error.py:" in place_in(sys._getframe())
    assert place_in(None) == "an unknown place"
