from __future__ import annotations

import pytest

from intellwheels_agents.bridge import main
from tests.every_case import every_case


@every_case(
    ("words", "expected"),
    [
        (["serial", "--name", "chair1"], "--port: expected a device with the driver serial"),
        (["world", "--name", "chair1", "--port", "x"], "--port: expected with the driver serial, got world"),
        (["luci", "--name", "chair1"], "--address: expected the host of the unit with the driver luci, got none"),
        (["rnet", "--name", "chair1"], "--channel: expected a CAN bus with the driver rnet, got none"),
        (
            ["luci", "--name", "c", "--address", "h", "--allow-injection"],
            "--allow-injection: expected with the driver rnet, got luci",
        ),
        (
            ["rnet", "--name", "c", "--channel", "x", "--sensors", "real"],
            "--sensors: expected virtual with the driver rnet, which reads none, got real",
        ),
        (["luci", "--name", "c", "--address", "http://h"], "--address: expected HOST or HOST:PORT, got 'http://h'"),
        (["rnet", "--name", "c", "--channel", "x", "--can-option", "fd=1"], "--can-option: expected KEY=VALUE, each"),
        (["world", "--name", "Chair 1"], "--name: expected a name"),
        (["world", "--name", "chair1", "--robot", "tank"], "got 'tank'"),
        (["world", "--name", "chair1", "--chair", "table"], "--chair: expected a robot with encoders"),
        (["world", "--name", "chair1", "--chair-option", "left=1"], "--chair-option: expected FIELD=VALUE, each field"),
        (["world", "--name", "chair1", "--lab-world", "a/b"], "--lab-world: expected a name"),
        (["world", "--name", "chair1", "--lab-connect", "lab:1"], "--lab-connect: expected an endpoint"),
        (["world", "--name", "chair1", "--lab-place", "a b"], "--lab-place: expected a word"),
        (["world", "--name", "chair1", "--baud", "9600"], "--baud: expected with the driver serial, got world"),
        (
            ["serial", "--name", "c", "--port", "/x", "--fix-every", "2"],
            "--fix-every: expected with the driver world, got serial",
        ),
        (["serial", "--name", "c", "--port", "http://x"], "--port: expected a device such as /dev/ttyUSB0, or a URL"),
    ],
)
def test_wrong_usage_is_refused_with_exit_code_2(
    words: list[str], expected: str, capsys: pytest.CaptureFixture[str]
) -> None:
    try:
        code: object = main(words)
    except SystemExit as ended:
        code = ended.code
    assert code == 2
    assert expected in capsys.readouterr().err


@pytest.mark.process
@pytest.mark.parametrize(
    "driver",
    [
        ["world", "--lab-connect", "tcp/127.0.0.1:1"],
        ["serial", "--port", "/nowhere/tty"],
        ["luci", "--address", "127.0.0.1:1"],
        ["rnet", "--channel", "nowhere0"],
    ],
)
def test_a_missing_chair_ends_the_bridge_with_exit_code_1(
    driver: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*driver, "--name", "chair1", "--retry-for", "0.5", "--connect", "tcp/127.0.0.1:1"]) == 1
    assert "bridged agent=chair1 poses=0" in capsys.readouterr().out
