from __future__ import annotations

from intellwheels_schemas.errors import RequestRefusedError, WireError, got_of, wrong_value


def test_errors_carry_code_words_and_place() -> None:
    wrong = WireError("value", "Actions.Tick: expected a whole number, got 'x'", "Actions.Tick")
    assert (wrong.code, wrong.where, str(wrong)) == ("value", "Actions.Tick", wrong.text)
    refused = RequestRefusedError("overlaps", "place 'bed1' is taken")
    assert (refused.code, str(refused)) == ("overlaps", refused.text)


def test_wrong_value_says_where_what_was_expected_and_what_came() -> None:
    error = wrong_value("Actions.LeftMotor", "a number in [-1, 1]", "'fast'")
    assert (error.code, error.where) == ("value", "Actions.LeftMotor")
    assert error.text == "Actions.LeftMotor: expected a number in [-1, 1], got 'fast'"


def test_file_that_is_not_there_is_none() -> None:
    assert got_of(FileNotFoundError(2, "No such file or directory")) == "none"
    assert got_of(PermissionError(13, "Permission denied")) == "permission denied"
