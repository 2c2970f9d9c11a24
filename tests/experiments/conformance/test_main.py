"""The command, with real programs: one without a fault passes, and one fault fails one point."""

from __future__ import annotations

import os
import re
import select
import subprocess
import sys
from pathlib import Path

import pytest

from tests.e2e.stage import is_gone

pytestmark = pytest.mark.process

DEADLINE = 60.0
FAULTY = str(Path(__file__).parent / "faulty.py")


def check(*words: str, timeout: float = 60.0) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "intellwheels_experiments.conformance", *words],
        capture_output=True,
        text=True,
        timeout=timeout,
        check=False,
    )


def failed(printed: str) -> list[str]:
    return re.findall(r"^FAILED  (\w+)", printed, re.MULTILINE)


def test_program_without_a_fault_passes_all_points() -> None:
    done = check("--", sys.executable, FAULTY, "none", "{name}", "{endpoint}")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "16 of 16 points passed" in done.stdout


@pytest.mark.parametrize(
    ("fault", "point", "expected", "got"),
    [
        ("ignores-refusal", "refusal", "no Actions after a refused join", r'got \{"Tick": \d'),
        ("answers-old-ticks", "late", r"no answer to tick \d+ after tick \d+", r'got \{.*"Tick": \d+'),
        ("ignores-run", "reset", r"Actions with Tick 0, Run [0-9a-f]{16}", "got nothing in answer to"),
        ("refuses-unknown-fields", "unknown", "Actions with Tick", 'got nothing in answer to .*"Weather"'),
        ("blocks", "congestion", "the congestion control drop", "got block"),
        ("drives-on", "leave", r"no Actions after it left \(asked to leave\)", r'got \{.*"Tick": \d+'),
    ],
)
def test_one_fault_fails_its_point_and_no_other(fault: str, point: str, expected: str, got: str) -> None:
    done = check("--answer-within", "1", "--", sys.executable, FAULTY, fault, "{name}", "{endpoint}")
    assert done.returncode == 1
    assert failed(done.stdout) == [point], done.stdout + done.stderr
    assert "15 of 16 points passed" in done.stdout
    words = done.stdout.partition("FAILED")[2]
    assert re.search(expected, words)
    assert re.search(got, words)


def test_shipped_minds_keep_the_contract_in_xml_and_as_the_mind_of_another_body() -> None:
    agent = (sys.executable, "-m", "intellwheels_agents", "avoid", "--name", "{name}", "--connect", "{endpoint}")
    for words in (("--encoding", "xml"), ("--role", "mind")):
        done = check("--world", "ward", "--name", "blue", "--", *agent, "--world", "{world}", *words)
        assert done.returncode == 0, done.stdout + done.stderr


def test_program_that_never_asks_fails_the_first_point_and_the_rest_is_skipped() -> None:
    program = "import os; print(os.environ['IW_NAME'], os.environ['IW_WORLD'], os.environ['IW_ENDPOINT'][:14])"
    done = check("--", sys.executable, "-c", program)
    assert done.returncode == 1
    assert failed(done.stdout) == ["join"]
    assert "got the end of the program, exit code 0" in done.stdout
    assert "| chair1 main tcp/127.0.0.1:" in done.stdout
    assert done.stdout.count("skipped") == 15


def test_kill_of_the_check_ends_the_program(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pid")
    told = os.open(tmp_path / "pid", os.O_RDWR)
    program = (
        "import os, signal, sys; open(sys.argv[1], 'w').write(f'{os.getpid()}\\n'); signal.alarm(90); signal.pause()"
    )
    words = ["--", sys.executable, "-c", program, str(tmp_path / "pid")]
    with subprocess.Popen(
        [sys.executable, "-m", "intellwheels_experiments.conformance", *words], stdout=subprocess.DEVNULL
    ) as process:
        try:
            assert select.select([told], [], [], DEADLINE)[0]
            pid = int(os.read(told, 64))
            assert not is_gone(pid)
        finally:
            process.kill()
            os.close(told)
    assert is_gone(pid, DEADLINE)


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        ((), 2, "COMMAND"),
        (("--name", "Chair 1", "--", "true"), 2, "--name: expected a name"),
        (("--identity", __file__, "--listen", "tcp/127.0.0.1:1", "--", "true"), 2, "--identity: expected --connect"),
        (("--listen", "tcp/127.0.0.1:1", "--connect", "tcp/127.0.0.1:1", "--", "true"), 2, "got both"),
        (
            ("--", "true", "{nmae}"),
            2,
            "COMMAND: expected the placeholders {name}, {endpoint}, {world}, got {nmae}; did you",
        ),
        (("--", "/no/such/program"), 2, "COMMAND: expected a program that can be run, got '/no/such/program'"),
        (("--answer-within", "0", "--", "true"), 2, "expected seconds in (0, 1e+09], got '0'"),
    ],
)
def test_wrong_usage_is_explained(words: tuple[str, ...], code: int, said: str) -> None:
    done = check(*words)
    assert done.returncode == code
    assert said in done.stderr


def test_help_documents_the_placeholders_the_environment_and_every_point() -> None:
    shown = check("--help").stdout
    for word in ("{endpoint}", "{world}", "{name}", "IW_ENDPOINT", "IW_WORLD", "IW_NAME", "hostile", "SIGTERM"):
        assert word in shown
