"""Options that go together or not, and what is wrong in one."""

from __future__ import annotations

import re

import pytest

from intellwheels_agents.joystick.joystick_options import check, parser
from intellwheels_agents.joystick.lsl_channels import ChannelUse
from intellwheels_agents.joystick.sip_and_puff import DEFAULT_KEYS
from tests.every_case import every_case


def refused(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    command_line = parser()
    with pytest.raises(SystemExit) as ended:
        check(command_line, command_line.parse_args(["chair1", *words]))
    assert ended.value.code == 2
    return capsys.readouterr().err


@every_case(
    ("words", "said"),
    [
        ("--source lsl", "--stream-name, --stream-type: expected at least one with --source lsl, got none"),
        ("--axes forward=0", "--axes: expected with --source lsl, got auto"),
        ("--source scan --dwell 2", "--dwell: expected with --scan dwell, got auto"),
        ("--source scan --scan step --scan-period 2", "--scan-period: expected with --scan auto, got step"),
        ("--source scan --scan step --switch-keys x", "--switch-keys: expected two keys with --scan step, got x"),
        ("--source scan --scan dwell --latch", "--latch: expected with --scan auto or step, got dwell"),
        ("--source scan --hold 3", "--hold: expected with --latch, or with --scan dwell, for --source scan, got neit"),
        ("--source sip-puff --hold 3", "--hold: expected with --latch, .* for --source sip-puff, got neither"),
        ("--source lsl --stream-name x --axes turn=0 --threshold 2", "--threshold: expected with --commands, got none"),
        ("--source lsl --stream-name x --commands stop=0 --dead-zone 0", "--dead-zone: expected with --axes, got none"),
        ("--source scan --signals hard-puff=w", "--signals: expected with --source sip-puff, got scan"),
        ("--source words --latch", "--latch: expected with --source scan or sip-puff, got words"),
        ("--source voice --audio /dev/null --audio-rate 48000", "--audio-rate: expected with --audio mic or -"),
        (
            "--source voice --audio-rate 8000",
            r"--audio-rate: expected .* in \[16000, 48000\], got '8000'",
        ),
        ("--source scan --switch-keys a,a", "--switch-keys: expected one key, or two different ones, got 'a,a'"),
        ("--source scan --switch-keys escape", "--switch-keys: expected a character or one of space, enter"),
        ("--source sip-puff --signals puff=a", "--signals: expected SIGNAL=KEY with one of hard-puff"),
        ("--source sip-puff --signals hard-puff=left", "--signals: expected a key of its own for each signal"),
        ("--source lsl --stream-name x --axes up=1", "--axes: expected each of forward, turn at most once"),
        ("--source lsl --stream-name x --threshold nan", "--threshold: expected a number ON"),
        ('--source lsl --stream-name "a\'b\\"c"', "--stream-name: expected a printable text"),
    ],
)
def test_wrong_options_are_named(words: str, said: str, capsys: pytest.CaptureFixture[str]) -> None:
    given = [word.strip('"').replace('\\"', '"') for word in words.split()]
    assert re.search(said, refused(capsys, *given))


def test_options_are_read() -> None:
    command_line = parser()
    words = [
        "chair1",
        "--source",
        "lsl",
        "--stream-type",
        "EEG",
        "--axes",
        "turn=Fz*-0.5",
        "--threshold",
        "2,1",
        "--commands",
        "stop=1",
    ]
    options = command_line.parse_args(words)
    check(command_line, options)
    assert options.axes == (ChannelUse("turn", "Fz", -0.5),)
    assert options.threshold == (2.0, 1.0)
    options = command_line.parse_args(["chair1", "--source", "sip-puff", "--signals", "hard-puff=W, soft-sip=tab"])
    check(command_line, options)
    assert options.signals == {**DEFAULT_KEYS, "hard-puff": "w", "soft-sip": "tab"}
    options = command_line.parse_args(["chair1", "--source", "scan", "--switch-keys", "space"])
    check(command_line, options)
    assert options.switch_keys == ("space",)
    for words in (
        ["--source", "scan", "--scan", "dwell", "--hold", "3"], ["--source", "scan", "--latch", "--hold", "3"],
        ["--source", "sip-puff", "--latch", "--hold", "3"], ["--source", "words", "--hold", "3"],
    ):  # fmt: skip
        options = command_line.parse_args(["chair1", *words])
        check(command_line, options)
        assert options.hold == 3.0
