"""The README is a promise: what it shows runs."""

import re
from pathlib import Path

import pytest

from intellwheels_agents.minds import find

README = (Path(__file__).parents[1] / "README.md").read_text()
BLOCKS = re.findall(r"```python\n(.*?)```", README, re.DOTALL)


def test_mind_of_the_readme_is_one(tmp_path: Path) -> None:
    (block,) = [block for block in BLOCKS if block.startswith("# forward.py")]
    file = tmp_path / "forward.py"
    file.write_text(block)
    assert callable(find(str(file)).make)


def test_world_of_the_readme_runs(capsys: pytest.CaptureFixture[str]) -> None:
    (block,) = [block for block in BLOCKS if "begin(Setup" in block]
    exec(compile(block, "README.md", "exec"), {})
    said = capsys.readouterr().out
    assert said.startswith("Measures(")
    assert "tick=20, time=1.0" in said


def test_files_the_readme_points_at_are_there() -> None:
    root = Path(__file__).parents[1]
    for target in re.findall(r"\]\((?!http)([^)#]+)\)", README):
        assert (root / target).exists(), target
