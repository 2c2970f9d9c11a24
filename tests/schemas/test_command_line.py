from __future__ import annotations

import pytest

from intellwheels_schemas.command_line import check_placeholders, filled, words_of
from intellwheels_schemas.errors import WireError


def test_words_are_those_of_a_shell_and_other_braces_stay() -> None:
    words = words_of("""node 'my agent.js' {name} --at={endpoint} '{"a": 1}'""", "Command")
    assert words == ["node", "my agent.js", "{name}", "--at={endpoint}", '{"a": 1}']
    values = {"name": "chair1", "endpoint": "tcp/127.0.0.1:7447"}
    assert [filled(word, values) for word in words][2:] == ["chair1", "--at=tcp/127.0.0.1:7447", '{"a": 1}']


@pytest.mark.parametrize(
    ("line", "text"),
    [
        ("", "Command: expected a command line, got no word"),
        ("mine '{name}", 'Command: expected a command line, got "mine \'{name}" (no closing quotation)'),
        (
            "mine {nmae}",
            "Command: expected the placeholders {name}, {endpoint}, {world}, got {nmae}; did you mean {name}?",
        ),
        ("mine {x}", "Command: expected the placeholders {name}, {endpoint}, {world}, got {x}"),
    ],
)
def test_wrong_line_is_refused(line: str, text: str) -> None:
    with pytest.raises(WireError) as error:
        words_of(line, "Command")
    assert error.value.text == text


def test_known_placeholders_may_occur_anywhere() -> None:
    check_placeholders(["{name}{name}", "x{world}", "{}", "{ name }"], "COMMAND")
