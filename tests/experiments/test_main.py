"""The command says what is wrong before it starts anything."""

from __future__ import annotations

import pytest

from intellwheels_experiments.__main__ import main


def test_unknown_scene_is_wrong_usage_and_the_known_are_named(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["nowhere"]) == 2
    assert "figure6" in capsys.readouterr().err


@pytest.mark.parametrize(
    "words", [["figure6", "--world", "A b"], ["figure6", "--speed", "0"], ["figure6", "--pace", "x"]]
)
def test_wrong_option_is_wrong_usage(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(words)
    assert ended.value.code == 2
    assert words[1] in capsys.readouterr().err
