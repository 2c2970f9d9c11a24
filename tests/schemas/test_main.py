from __future__ import annotations

import io
from pathlib import Path
from types import SimpleNamespace

import pytest

from intellwheels_schemas.__main__ import main

VECTORS = Path(__file__).parents[2] / "schemas" / "vectors"


def run(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str]:
    code = main(["check", *arguments])
    out, err = capsys.readouterr()
    return code, (out + err).strip()


@pytest.mark.parametrize("name", ["Actions-say.json", "Actions-say.xml", "Map.xml", "OperatorSay.json"])
def test_valid_document_is_called_so(capsys: pytest.CaptureFixture[str], name: str) -> None:
    path = str(VECTORS / name)
    assert run(capsys, path) == (0, f"{path}: a valid {name.replace('.', '-').partition('-')[0]}")


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("Robot-cone-zero.xml", ":1: Robot.Proximity[0].ConeDeg: expected degrees in (0, 360], got 0 (value)"),
        ("Robot-cone-zero.json", ": Robot.Proximity[0].ConeDeg: expected degrees in (0, 360], got 0 (value)"),
        ("Actions-another-root.xml", ": expected a root of Robot, Joined,"),
        ("UserInput-long.xml", ": expected at most 4096 bytes, got 4119 (too-long)"),
    ],
)
def test_wrong_document_is_told_with_its_place(capsys: pytest.CaptureFixture[str], name: str, words: str) -> None:
    path = str(VECTORS / "refused" / name)
    code, said = run(capsys, path)
    assert code == 1
    assert said.startswith(f"{path}{words}")


def test_help_of_check_has_its_own_usage_line(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["check", "--help"])
    assert capsys.readouterr().out.startswith("usage: python -m intellwheels_schemas check [-h] [--as CLASS] FILE\n")


def test_class_can_be_said(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    path = tmp_path / "mine.json"
    path.write_bytes(b'{"Session":"c0ffee0012345678","Text":"open"}\n')
    code, said = run(capsys, str(path))
    assert code == 2
    assert said.endswith("give the class with --as")
    assert run(capsys, str(path), "--as", "Say")[0] == 0
    assert run(capsys, str(path), "--as", "Actions")[0] == 1


def test_document_may_come_on_standard_input(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        "sys.stdin", SimpleNamespace(buffer=io.BytesIO(b'<Actions Session="c0ffee0012345678" Tick="5"/>'))
    )
    assert run(capsys, "-") == (0, "-: a valid Actions")


def test_missing_file_and_unknown_class_are_wrong_usage(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(capsys, "/none.json")[0] == 2
    with pytest.raises(SystemExit) as caught:
        main(["check", "x", "--as", "Aktion"])
    assert caught.value.code == 2
