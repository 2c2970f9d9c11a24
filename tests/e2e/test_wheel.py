"""What is included is whole: the wheel has what it needs, and runs a scene far from the checkout."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import threading
import zipfile
from pathlib import Path

import pytest

from tests.commands import SCRIPTS
from tests.viewer.browser import opened

ROOT = Path(__file__).parent.parent.parent
LIMIT = 600.0
"""Seconds for the first command of README: it installs everything and compiles the kernels."""
PACKAGES = ("intellwheels_schemas", "intellwheels_server", "intellwheels_agents", "intellwheels_experiments",
            "intellwheels_maps", "intellwheels_viewer", "intellwheels_gym")  # fmt: skip


def _without_checkout() -> dict[str, str]:
    """Return an environment without the checkout. What is installed is compiled when it is imported, and no more."""
    # pip reads the variable of an option that begins with `no` the other way round.
    own = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "VIRTUAL_ENV"))}
    return own | {"PIP_NO_COMPILE": "no"}


def finished(*command: str, cwd: Path, timeout: float = 300.0) -> str:
    """Run a command without the checkout in reach; return what it printed."""
    done = subprocess.run(
        command, cwd=cwd, env=_without_checkout(), capture_output=True, text=True, timeout=timeout, check=False
    )
    assert done.returncode == 0, f"{' '.join(command)}\n{done.stdout}{done.stderr}"
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("wheel")
    finished(sys.executable, "-m", "build", "--wheel", "--outdir", str(out), str(ROOT), cwd=out)
    (found,) = out.glob("*.whl")
    return found


def test_wheel_holds_every_package_its_types_and_its_data(wheel: Path) -> None:
    names = set(zipfile.ZipFile(wheel).namelist())
    for package in PACKAGES:
        assert f"{package}/py.typed" in names
        room = next(path.parent for path in ROOT.glob(f"*/{package}"))
        sources = {
            str(path.relative_to(room))
            for path in (room / package).rglob("*")
            if path.suffix in (".py", ".xml") and "__pycache__" not in path.parts
        }
        assert sources <= names, f"missing: {sorted(sources - names)}"
    assert any(name.startswith("intellwheels_maps/scenes/figure6") for name in names)
    assert any(name.endswith("licenses/LICENSE") for name in names)


def test_wheel_holds_nothing_else(wheel: Path) -> None:
    names = zipfile.ZipFile(wheel).namelist()
    others = [name for name in names if name.split("/")[0] not in PACKAGES and ".dist-info/" not in name]
    assert others == []
    assert [name for name in names if "__pycache__" in name or "test" in Path(name).name] == []


@pytest.fixture(scope="module")
def checkout(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the checkout without what an installation or a test run has added to it."""
    folder = tmp_path_factory.mktemp("clean") / "checkout"
    added = shutil.ignore_patterns(".*", "__pycache__", "*.egg-info", "build", "dist", "node_modules", "target")
    return shutil.copytree(ROOT, folder, ignore=added)


@pytest.fixture(scope="module")
def page_text(checkout: Path) -> str:
    """The text of the page that the first command of README shows, run as it stands but for the page's port."""
    (command,) = re.findall(r"^python3 -m venv .*iw-run .*--view$", (ROOT / "README.md").read_text(), re.MULTILINE)
    process = subprocess.Popen(
        ["bash", "-c", f"{command} --view-port 0"], cwd=checkout, env=_without_checkout(), start_new_session=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    )  # fmt: skip
    watchdog = threading.Timer(LIMIT, os.killpg, (process.pid, signal.SIGKILL))
    watchdog.start()
    printed = []
    try:
        assert process.stdout is not None
        address = None
        for line in process.stdout:
            printed.append(line)
            address = re.search(r"view it at http://[\d.]+:(\d+)", line)
            if address is not None:
                break
        assert address is not None, "".join(printed)
        with opened(int(address[1])) as browser:
            browser.wait(lambda: "chair3" in browser.text(), 60.0)
            text = browser.text()
        os.killpg(process.pid, signal.SIGINT)
        rest, _ = process.communicate()
        # A busy machine may be slower than the scene, which is over after half a minute.
        assert re.search("finish=(interrupted|ended)", rest), "".join(printed) + rest
        return text
    finally:
        watchdog.cancel()
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
            process.communicate()


@pytest.fixture(scope="module")
def clean(checkout: Path, page_text: str) -> Path:
    """The commands of the environment that the first command of README makes, and pytest."""
    assert page_text
    commands = checkout / ".venv" / "bin"
    finished(str(commands / "pip"), "install", "--quiet", "pytest", cwd=checkout)
    where = finished(
        str(commands / "python"), "-c", "import intellwheels_server; print(intellwheels_server.__file__)",
        cwd=checkout.parent,
    )  # fmt: skip
    assert where.startswith(str(checkout / ".venv"))
    return commands


def test_first_command_of_the_readme_shows_figure_6_in_the_page(page_text: str) -> None:
    for name in ("chair1", "chair2", "chair3", "door", "table"):
        assert name in page_text


def test_wheel_installed_in_a_clean_environment_runs_a_scene(clean: Path, tmp_path: Path) -> None:
    for command in SCRIPTS:
        assert "usage: " + command in finished(str(clean / command), "--help", cwd=tmp_path)
    finished(str(clean / "iw-run"), "door", "--json", "result.json", cwd=tmp_path)
    assert json.loads((tmp_path / "result.json").read_text())["held"] is True


def test_starter_passes_as_it_is_in_a_clean_environment(clean: Path, tmp_path: Path) -> None:
    finished(str(clean / "iw-agent"), "new", "my-chair", cwd=tmp_path)
    assert "3 passed" in finished(str(clean / "pytest"), "-W", "error", "my-chair", cwd=tmp_path)
    assert "held scene=mine" in finished(str(clean / "iw-run"), "my-chair/scene.xml", cwd=tmp_path)


def test_test_of_the_readme_passes_in_a_clean_environment(clean: Path, tmp_path: Path) -> None:
    blocks = re.findall(r"```python\n(# (\w+\.py).*?)```", (ROOT / "README.md").read_text(), re.DOTALL)
    for text, name in blocks:
        (tmp_path / name).write_text(text)
    assert "2 passed" in finished(str(clean / "pytest"), "-W", "error", cwd=tmp_path)
