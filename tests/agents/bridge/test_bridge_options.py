from __future__ import annotations

import pytest

from intellwheels_agents.bridge.bridge_options import parser
from tests.every_case import every_case


def test_help_has_examples() -> None:
    assert "iw-bridge serial --port /dev/ttyUSB0 --name chair1" in parser().format_help()


@every_case(
    ("words", "expected"),
    [
        (["--wheel-ratio", "3"], "--wheel-ratio: expected a number in [0.5, 2], got '3'"),
        (["--loss", "2"], "--loss: expected a share in [0, 1], got '2'"),
        (["--delay", "-1"], "--delay: expected seconds in [0, 3600], got '-1'"),
        (["--delay", "long"], "--delay: expected seconds in [0, 3600], got 'long'"),
        (["--clock-offset", "nan"], "--clock-offset: expected seconds in [-1e+12, 1e+12], got 'nan'"),
        (["--baud", "fast"], "--baud: expected a whole number in [1, 2147483647], got 'fast'"),
        (["--fix-every", "0"], "--fix-every: expected a whole number in [1, 2147483647], got '0'"),
        (["--retry-for", "0"], "--retry-for: expected seconds in (0, 1e+09], got '0'"),
    ],
)
def test_an_option_out_of_range_is_refused_with_its_range(
    words: list[str], expected: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        parser().parse_args(["world", "--name", "chair1", *words])
    assert ended.value.code == 2
    assert expected in capsys.readouterr().err
