from __future__ import annotations

import os
from pathlib import Path

import pytest

from intellwheels_schemas.errors import WireError
from intellwheels_schemas.output_paths import check_output_file, check_output_folder


def test_nothing_is_created_or_changed(tmp_path: Path) -> None:
    old = tmp_path / "old"
    old.write_text("old")
    check_output_file(None, "--log")
    check_output_file(old, "--log")
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
