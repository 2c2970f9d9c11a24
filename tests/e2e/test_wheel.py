"""What is included is whole: the wheel has what it needs, and runs a scene far from the checkout."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from tests.commands import SCRIPTS

ROOT = Path(__file__).parent.parent.parent
PACKAGES = ("intellwheels_schemas", "intellwheels_server", "intellwheels_agents", "intellwheels_experiments",
            "intellwheels_maps", "intellwheels_viewer")  # fmt: skip


def finished(*command: str, cwd: Path, timeout: float = 300.0) -> str:
    """Run a command without the checkout in reach; return what it printed."""
    clean = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "VIRTUAL_ENV"))}
    done = subprocess.run(command, cwd=cwd, env=clean, capture_output=True, text=True, timeout=timeout, check=False)
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
def clean(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The commands of an environment in which the wheel and pytest are installed."""
    folder = tmp_path_factory.mktemp("clean")
    environment = folder / "venv"
    finished(sys.executable, "-m", "venv", str(environment), cwd=folder)
    python = environment / "bin" / "python"
    finished(str(python), "-m", "pip", "install", "--quiet", f"{wheel}[all]", "pytest", cwd=folder)
    where = finished(str(python), "-c", "import intellwheels_server; print(intellwheels_server.__file__)", cwd=folder)
    assert where.startswith(str(environment))
    return environment / "bin"


def test_wheel_installed_in_a_clean_environment_runs_a_scene(clean: Path, tmp_path: Path) -> None:
    for command in SCRIPTS:
        assert "usage: " + command in finished(str(clean / command), "--help", cwd=tmp_path)
    finished(str(clean / "iw-run"), "figure6", "--json", "result.json", cwd=tmp_path)
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
