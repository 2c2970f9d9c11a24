from __future__ import annotations

import pytest

from intellwheels_schemas.errors import WireError
from intellwheels_schemas.names import check_agent, check_name, is_hex, is_name, new_hex
from tests.every_case import every_case


@pytest.mark.parametrize("text", ["a", "chair1", "a-b_c", "a" * 32])
def test_name_is_returned(text: str) -> None:
    assert check_name(text) == text
    assert is_name(text)


@every_case("text", ["", "1a", "A", "a b", "*", "@x", "a/b", "a\n", "a" * 33, "é", "a.b", "$*"])
def test_what_is_no_name_is_refused_with_its_place(text: str) -> None:
    with pytest.raises(WireError) as caught:
        check_name(text, "--world")
    assert caught.value.code == "value"
    assert caught.value.where == "--world"
    assert caught.value.text.startswith("--world: expected a name of a-z")
    assert not is_name(text)


def test_place_may_be_left_out() -> None:
    with pytest.raises(WireError, match=r"^expected a name"):
        check_name("*")


def test_reserved_name_is_a_name_but_no_agents() -> None:
    assert check_name("operator") == "operator"
    with pytest.raises(WireError, match="agent: expected a name that is not reserved, got 'operator'"):
        check_agent("operator", "agent")


def test_new_hex_is_hex_and_new() -> None:
    assert is_hex(new_hex())
    assert new_hex() != new_hex()
    assert not is_hex("9F3C21D4A0B1C2D3")
    assert not is_hex("9f3c21d4a0b1c2d3\n")
