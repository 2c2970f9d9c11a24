"""The starter is complete and valid, and overwrites nothing. `tests/e2e/test_wheel.py` runs its test."""

from __future__ import annotations

from pathlib import Path

import pytest

from intellwheels_agents import starter
from intellwheels_agents.__main__ import main
from intellwheels_agents.minds import find
from intellwheels_maps import scene


def test_every_file_of_the_template_is_written(tmp_path: Path) -> None:
    template = Path(starter.__file__).parent / "template"
    assert {path.name for path in template.iterdir() if path.is_file()} == set(starter.FILES)
    written = starter.write(tmp_path / "a" / "b")
    assert sorted(path.name for path in written) == sorted(path.name for path in (tmp_path / "a" / "b").iterdir())
    assert all(path.stat().st_size > 0 for path in written)


def test_scene_robot_and_mind_of_the_starter_are_valid(tmp_path: Path) -> None:
    starter.write(tmp_path)
    (cast,) = scene(str(tmp_path / "scene.xml")).cast
    assert callable(find(str(tmp_path / cast.mind)).make)


def test_command_lists_the_files_and_the_next_steps(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "my-chair"
    assert main(["new", str(folder)]) == 0
    said = capsys.readouterr().out
    assert str(folder / "test_mind.py") in said
    assert f"iw-run {folder / 'scene.xml'}" in said


def test_existing_files_are_kept_and_nothing_is_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "mind.py").write_text("mine")
    assert main(["new", str(tmp_path)]) == 1
    assert "got mind.py" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["mind.py"]
    assert (tmp_path / "mind.py").read_text() == "mine"


def test_new_without_a_folder_is_wrong_usage() -> None:
    with pytest.raises(SystemExit) as end:
        main(["new"])
    assert end.value.code == 2
