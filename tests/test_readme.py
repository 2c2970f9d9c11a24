"""The README is a promise: what it shows runs."""

import importlib
import importlib.util
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from intellwheels_agents.minds import find
from intellwheels_experiments.run.child_processes import ChildProcesses
from intellwheels_experiments.run.endpoints import free_endpoint
from intellwheels_server.service import lab_keys
from tests.commands import MODULES

README = (Path(__file__).parents[1] / "README.md").read_text()
BLOCKS = re.findall(r"```python\n(.*?)```", README, re.DOTALL)


def test_mind_of_the_readme_is_one(tmp_path: Path) -> None:
    (block,) = [block for block in BLOCKS if block.startswith("# forward.py")]
    file = tmp_path / "forward.py"
    file.write_text(block)
    assert callable(find(str(file)).make)


@pytest.mark.process
def test_test_of_the_readme_passes(tmp_path: Path) -> None:
    blocks = {block.split()[1].rstrip(":"): block for block in BLOCKS if block.startswith("# ")}
    for name in ("forward.py", "test_forward.py"):
        (tmp_path / name).write_text(blocks[name])
    # By the file and not by the entry point: a checkout may be newer than what is installed.
    words = ["-p", "no:intellwheels", "-p", "intellwheels_experiments.testing.plugin", "-p", "no:cacheprovider"]
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-W", "error", *words, str(tmp_path)],
        cwd=tmp_path, capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    assert "2 passed" in done.stdout


def test_world_of_the_readme_runs(capsys: pytest.CaptureFixture[str]) -> None:
    (block,) = [block for block in BLOCKS if "begin(Setup" in block]
    (together,) = [block for block in BLOCKS if "advance_many(" in block]
    exec(compile(block + together, "README.md", "exec"), {})
    said = capsys.readouterr().out
    assert said.startswith("Measures(")
    assert "tick=20, time=1.0" in said


@pytest.mark.process
def test_control_verbs_of_the_readme_save_and_restore(tmp_path: Path) -> None:
    (block,) = [block for block in BLOCKS if block.startswith("# control_verbs.py")]
    endpoint, world = free_endpoint(), "readme-control"
    # Its own address and world: another simulator may run on this machine.
    script = block.replace("tcp/127.0.0.1:7447", endpoint).replace("iw/v1/main/", f"iw/v1/{world}/")
    assert endpoint in script
    assert world in script
    words = ["-m", "intellwheels_server", "--map", "room", "--listen", endpoint, "--world", world]
    with ChildProcesses(tmp_path) as children:
        child = children.launch("server", lambda lifeline: [sys.executable, *words, "--lifeline", str(lifeline)])
        children.wait(lambda: children.find_line(child, "ready"), "the simulator", 180.0, unless=child)
        done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60.0, check=False)
    assert done.returncode == 0, done.stderr
    assert "'Code': 'ok'" in done.stdout


def test_second_example_of_the_public_interface_runs(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # it also runs a log again where one is there
    (block,) = [block for block in BLOCKS if "wilson(38, 40)" in block]
    exec(compile(block, "README.md", "exec"), {})
    printed = capsys.readouterr().out
    assert '{"Session":"c0ffee0012345678","Tick":5,"LeftMotor":0.5} iw/v1/main/in/chair1/actions' in printed
    assert "'ward'" in printed


def test_learning_environments_of_the_readme_run() -> None:
    (block,) = [block for block in BLOCKS if "import gymnasium" in block]
    assert len(block.splitlines()) <= 10
    names: dict[str, object] = {}
    exec(compile(block, "README.md", "exec"), names)
    assert names["terminated"] is False
    assert names["info"]["seed"] == "1"  # type: ignore[index]


@pytest.mark.process
def test_lab_of_the_readme_runs_command_by_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    block = README.partition("<!-- lab-commands -->")[2].partition("<!-- end -->")[0]
    commands = [shlex.split(line, comments=True) for line in block.splitlines() if line.startswith("iw-")]
    assert len(commands) <= 10
    monkeypatch.chdir(tmp_path)
    os.mkfifo("ask")
    # Its own port, and a stand-in for the serial line of the chair.
    changes = {"tls/127.0.0.1:7447": f"tls/{free_endpoint().partition('/')[2]}", "/dev/ttyUSB0": str(tmp_path / "tty")}
    with ChildProcesses(tmp_path) as children:
        children.start("firmware", "intellwheels_agents.bridge.firmware_stand_in", "--link", "tty", "--ask", "ask")
        children.line("firmware", "ready")
        for command, *given in commands:
            words = [changes.get(word, word) for word in given]
            if command == "iw-lab":
                assert lab_keys.main(words) == 0
                continue
            child = children.start(command, MODULES[command], *words, *(["--port", "0"] if "viewer" in command else []))
            children.line(child, "joined" if command in ("iw-agent", "iw-bridge") else "ready", 120.0)
        children.line("firmware", "moving")


def test_public_imports_are_there() -> None:
    table = README.split("## Use it from Python")[1].split("```")[0]
    rows = re.findall(r"^\| `(intellwheels_[\w.]+)` \| (.+) \|$", table, re.MULTILINE)
    assert len(rows) == 10
    for package, uses in rows:
        for name in re.findall(r"`([\w.]+)`", uses.split(":")[0]):
            if name == "intellwheels":  # the fixture
                continue
            module = importlib.import_module(package)
            first = name.split(".")[0]
            assert hasattr(module, first) or importlib.util.find_spec(f"{package}.{first}"), f"{package}: {name}"


def test_modules_that_the_readme_runs_are_there() -> None:
    modules = set(re.findall(r"python3? -m ([\w.]+)", README))
    assert modules >= {"intellwheels_schemas", "tests.bench"}
    assert [module for module in modules if importlib.util.find_spec(module) is None] == []


def test_files_the_readme_points_at_are_there() -> None:
    root = Path(__file__).parents[1]
    for target in re.findall(r"\]\((?!http)([^)#]+)\)", README):
        assert (root / target).exists(), target
