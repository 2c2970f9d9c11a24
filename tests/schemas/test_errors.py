from __future__ import annotations

from intellwheels_schemas.errors import RequestRefusedError, WireError


def test_errors_carry_code_words_and_place() -> None:
    wrong = WireError("value", "Actions.Tick: expected a whole number, got 'x'", "Actions.Tick")
    assert (wrong.code, wrong.where, str(wrong)) == ("value", "Actions.Tick", wrong.text)
    refused = RequestRefusedError("overlaps", "place 'bed1' is taken")
    assert (refused.code, str(refused)) == ("overlaps", refused.text)
