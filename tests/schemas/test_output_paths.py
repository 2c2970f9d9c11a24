from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from intellwheels_schemas.errors import WireError
from intellwheels_schemas.output_paths import (
    check_output_file,
    check_output_folder,
    open_output,
    reserved_output,
    write_reserved,
)


def test_nothing_is_created_or_changed(tmp_path: Path) -> None:
    old = tmp_path / "old"
    old.write_text("old")
    check_output_file(None, "--log")
    check_output_file(old, "--log", overwrite=True)
    check_output_file(tmp_path / "new", "--log")
    check_output_folder(None, "--out")
    check_output_folder(tmp_path, "--out")
    check_output_folder(tmp_path / "a" / "b", "--out")
    assert old.read_text() == "old"
    assert list(tmp_path.iterdir()) == [old]


def test_devices_may_be_written() -> None:
    check_output_file(Path(os.devnull), "--log")


@pytest.mark.parametrize(
    ("name", "words"), [("", "expected a file, got the folder"), ("a/b", "expected a folder that exists, got")]
)
def test_impossible_file_is_refused_with_its_option(name: str, words: str, tmp_path: Path) -> None:
    with pytest.raises(WireError, match=f"^--json: {words}"):
        check_output_file(tmp_path / name, "--json")


def test_file_is_no_folder(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    for path in (tmp_path / "file", tmp_path / "file" / "below"):
        with pytest.raises(WireError, match=r"^--out: expected a folder, got the file .*/file$"):
            check_output_folder(path, "--out")


@pytest.fixture
def refusing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Answer as for a user without rights: tests may run as root."""
    monkeypatch.setattr(os, "access", lambda *_: False)


@pytest.mark.usefixtures("refusing")
def test_what_may_not_be_written_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(WireError, match=r"^--log: expected a file that may be written"):
        check_output_file(tmp_path / "file", "--log")
    with pytest.raises(WireError, match=r"^--log: expected a folder that may be written"):
        check_output_file(tmp_path / "new", "--log")
    with pytest.raises(WireError, match=r"^--out: expected a folder that may be written"):
        check_output_folder(tmp_path / "new", "--out")


def test_file_that_exists_is_replaced_only_if_that_is_wanted(tmp_path: Path) -> None:
    old = tmp_path / "old"
    old.write_text("old")
    with pytest.raises(WireError, match=r"^--log: expected a new file, got .*/old: the file exists; --overwrite"):
        check_output_file(old, "--log")
    for refused in (open_output, reserved_output):
        with pytest.raises(FileExistsError, match="--overwrite replaces it"), refused(old, overwrite=False):
            pass
    assert old.read_text() == "old"
    with open_output(old, overwrite=True) as file:
        file.write(b"new")
    assert old.read_text() == "new"


def test_empty_file_is_no_loss(tmp_path: Path) -> None:
    (tmp_path / "empty").touch()
    check_output_file(tmp_path / "empty", "--log")
    open_output(tmp_path / "empty", overwrite=False).close()


def test_file_has_one_writer_at_a_time(tmp_path: Path) -> None:
    path = tmp_path / "file"
    with open_output(path) as file:
        file.write(b"first")
        with pytest.raises(WireError, match="another process is writing this file"):
            check_output_file(path, "--log", overwrite=True)
        for second in (open_output, reserved_output):
            with pytest.raises(OSError, match="another process is writing this file"), second(path, overwrite=True):
                pass
    assert path.read_bytes() == b"first"
    open_output(path).close()


@pytest.mark.process
def test_writer_that_is_killed_leaves_no_lock(tmp_path: Path) -> None:
    code = (
        "import pathlib, sys; from intellwheels_schemas.output_paths import open_output; "
        "file = open_output(pathlib.Path(sys.argv[1])); print('ready', flush=True); sys.stdin.read()"
    )
    words = [sys.executable, "-c", code, str(tmp_path / "file")]
    with subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as child:
        assert child.stdout is not None
        assert child.stdout.readline() == b"ready\n"
        with pytest.raises(WireError, match="another process is writing this file"):
            check_output_file(tmp_path / "file", "--log")
        child.kill()
        child.wait(10.0)
    open_output(tmp_path / "file").close()


def test_reserved_file_keeps_what_it_has_until_it_is_written(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_text("a long old text")
    with reserved_output(path, overwrite=True):
        assert path.read_text() == "a long old text"
    assert path.read_text() == "a long old text"
    with reserved_output(path, overwrite=True) as file:
        write_reserved(file, b"new")
    assert path.read_text() == "new"


def test_reserved_file_to_which_nothing_was_written_is_removed(tmp_path: Path) -> None:
    with reserved_output(tmp_path / "new", overwrite=False):
        pass
    assert list(tmp_path.iterdir()) == []


def test_device_has_any_number_of_writers() -> None:
    null = Path(os.devnull)
    with open_output(null), open_output(null), reserved_output(null, overwrite=False) as file:
        check_output_file(null, "--log")
        write_reserved(file, b"nothing")
