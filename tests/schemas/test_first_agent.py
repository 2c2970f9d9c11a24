"""The page for programmers of any language: its bytes are true."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from intellwheels_experiments.run.endpoints import free_endpoint
from intellwheels_schemas.codec import Encoding, decode, encode
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import Actions, Joined, Measures, Record, Refused, Robot
from intellwheels_schemas.vectors import CHAIR

DEADLINE = 120.0

ROOT = Path(__file__).parents[2]
ROOMS = [ROOT / room for room in ("schemas", "server", "agents", "viewer")]
PAGE = (ROOT / "schemas" / "FIRST-AGENT.md").read_text(encoding="utf-8")
LINES = [line.strip() for line in PAGE.splitlines()]
OBJECTS = [line for line in LINES if line.startswith('{"')]
ELEMENTS = [line for line in LINES if re.match(r"<[A-Z]", line)]
CLASSES: dict[str, type[Record]] = {"Robot": Robot, "Measures": Measures, "Actions": Actions}


def test_page_has_the_four_messages() -> None:
    robot, joined, measures, actions = OBJECTS
    accepted = encode(CHAIR).decode()
    for cls, text in (
        (Robot, robot),
        (Joined, joined.replace("{...as accepted...}", accepted)),
        (Measures, measures),
        (Actions, actions),
    ):
        assert encode(decode(cls, text.encode())).decode() == text


def test_actions_that_other_pages_show_are_accepted() -> None:
    pages = [path for room in ROOMS for path in room.rglob("*.md")]
    shown = [text for page in pages for text in re.findall(r"<Actions [^>]*/>", page.read_text(encoding="utf-8"))]
    assert shown
    for text in shown:
        assert decode(Actions, text.encode(), Encoding.XML).session


@pytest.mark.parametrize("text", ELEMENTS)
def test_page_says_the_same_in_xml(text: str) -> None:
    cls = CLASSES[re.split(r"[ <]", text)[1]]
    message = decode(cls, text.encode(), Encoding.XML)
    assert encode(message, Encoding.XML).decode() == text
    assert encode(message).decode() in OBJECTS


def test_page_shows_a_refusal() -> None:
    refusal = re.search(r'`(\{"Code".*?\})`', PAGE)
    assert refusal is not None
    assert decode(Refused, refusal[1].encode()).code == "already-here"


def test_page_uses_the_keys_of_the_contract() -> None:
    keys = Keys("main")
    for key in (
        keys.outs("chair1"),
        keys.token("chair1", "both", "5f0c2a9be1d84377"),
        keys.actions("chair1"),
        keys.join("chair1"),
        keys.alive,
    ):
        assert f"`{key}`" in PAGE


@pytest.mark.process
def test_whole_agent_of_the_page_has_25_lines_and_keeps_the_contract(tmp_path: Path) -> None:
    (program,) = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    assert len([line for line in program.splitlines() if line]) == 25
    file = tmp_path / "agent.py"
    file.write_text(program, encoding="utf-8")
    check = (sys.executable, "-m", "intellwheels_experiments.conformance", "--", sys.executable, str(file))
    done = subprocess.run(
        [*check, "{name}", "{endpoint}"], capture_output=True, text=True, timeout=DEADLINE, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.process
def test_whole_agent_of_the_page_waits_for_a_simulator_until_it_is_interrupted(tmp_path: Path) -> None:
    (program,) = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    # It says when it is about to connect, so that the test need not guess.
    file = tmp_path / "agent.py"
    file.write_text(program.replace("with zenoh.open", "print('connects', flush=True)\nwith zenoh.open"))
    command = [sys.executable, str(file), "chair1", free_endpoint()]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as agent:
        assert agent.stdout is not None
        try:
            assert agent.stdout.readline() == "connects\n"
            with pytest.raises(subprocess.TimeoutExpired):
                agent.wait(1.0)
            agent.send_signal(signal.SIGINT)
            assert agent.wait(DEADLINE) == -signal.SIGINT
            assert agent.stderr is not None
            assert agent.stderr.read() == ""
        finally:
            agent.kill()
