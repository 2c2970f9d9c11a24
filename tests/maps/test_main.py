from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import pytest

from intellwheels_maps import floor, names
from intellwheels_maps.__main__ import main
from intellwheels_maps.hospital import hospital


def test_list_prints_floors_robots_and_scenes(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == f"floors: {' '.join(names('floors'))}"
    assert [line.split(":")[0] for line in lines] == ["floors", "robots", "scenes"]


def test_hospital_is_printed_as_a_floor_that_reads_back(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["hospital", "--seed", "3"]) == 0
    path = tmp_path / "hospital.xml"
    path.write_text(capsys.readouterr().out, encoding="utf-8")
    assert floor(path) == hospital(3)
    assert main(["check", str(path)]) == 0
    assert capsys.readouterr().out == f"{path}: a valid Map\n"


def test_check_warns_of_places_where_a_chair_cannot_turn(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "mine.xml"
    path.write_text(
        '<Map Format="iw.v1" Name="mine">'
        '<Wall><Corner X="0.7" Y="-1"/><Corner X="1" Y="-1"/><Corner X="1" Y="1"/></Wall>'
        '<Grid><Position Name="p" X="0.1" Y="-1"/></Grid></Map>'
    )
    assert main(["check", str(path)]) == 0
    printed = capsys.readouterr()
    assert printed.out == f"{path}: a valid Map\n"
    assert (
        "warning: Map.Grid.Position[0]: place 'p' is too narrow for 'rear-wheel': "
        "it needs 0.905 m to turn on the spot, got 0.600 m to Wall[0]"
    ) in printed.err.splitlines()
    assert "'person'" not in printed.err
    scene = tmp_path / "scene.xml"
    scene.write_text(
        '<Scene Format="iw.v1" Name="s" Map="mine.xml">'
        '<Cast Name="a" Robot="mid-wheel" Mind="drive" Place="p"/></Scene>'
    )
    assert main(["check", str(scene)]) == 0
    assert capsys.readouterr().err == (
        "warning: Scene.Cast[0]: agent 'a': place 'p' is too narrow: it needs 0.662 m to turn on the spot, "
        "got 0.600 m to Wall[0]\n"
    )


def test_draw_writes_a_plan(tmp_path: Path) -> None:
    path = tmp_path / "ward.svg"
    assert main(["draw", "ward", str(path)]) == 0
    assert ElementTree.parse(path).getroot().tag.endswith("svg")


@pytest.mark.parametrize(
    ("text", "error"),
    [
        ('<Map Format="iw.v1" Name="m">\n<Wall><Corner X="0" Y="0"/></Wall></Map>', ":2: "),
        ("<Measures/>", ": expected the root Map, Robot or Scene, got Measures"),
        ("<Map", ": expected well-formed XML, got "),
        ("", ":"),
    ],
)
def test_check_names_the_place_in_a_wrong_file_and_exits_with_1(
    text: str, error: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "mine.xml"
    path.write_text(text, encoding="utf-8")
    assert main(["check", str(path)]) == 1
    assert capsys.readouterr().err.startswith(f"{path}{error}")


@pytest.mark.parametrize("command", [["check", "none.xml"], ["draw", "wart", "out.svg"]])
def test_missing_file_is_wrong_usage(command: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    try:
        code: object = main(command)
    except SystemExit as ended:
        code = ended.code
    assert code == 2
    printed = capsys.readouterr().err
    assert printed.startswith("python -m intellwheels_maps")
    assert "expected" in printed
    assert printed.count("\n") == 1


def test_wrong_usage_exits_with_2(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as caught:
        main(["dance"])
    assert caught.value.code == 2
    capsys.readouterr()


LAB = (
    '<Lab Name="l" Height="5" Width="6">'
    '<Wall Height="1"><Corner X="1" Y="1"/><Corner X="2" Y="1"/><Corner X="1" Y="2"/></Wall></Lab>'
)


def test_import_writes_a_map_and_lists_what_was_left_out(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lab, map_file = tmp_path / "MyLab.xml", tmp_path / "map.xml"
    lab.write_text(LAB)
    assert main(["import", str(lab), "-o", str(map_file)]) == 0
    printed = capsys.readouterr()
    assert printed.err == "left out: MyLab.xml: start grid: there is no file of its name with Grid for Lab\n"
    assert printed.out == (f"{map_file}: walls=2 obstacles=0 zones=0 doorways=0 doors=0 places=0 routes=0 left-out=1\n")
    assert floor(map_file) == floor(lab)
    assert main(["check", str(lab)]) == 0


def test_export_writes_image_head_and_places(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "ward.yaml"
    assert main(["export", "ward", "-o", str(out), "--resolution", "0.1"]) == 0
    assert capsys.readouterr().out.startswith(f"{out}: ")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["ward.pgm", "ward.places.yaml", "ward.yaml"]
    assert len(floor(out).wall) > 5
    back = tmp_path / "back.xml"
    assert main(["import", str(out), "-o", str(back)]) == 0
    assert "doorways=14 doors=0 places=39 routes=0 left-out=0" in capsys.readouterr().out
    assert floor(back).grid == floor("ward").grid


@pytest.mark.parametrize(
    ("words", "code", "text"),
    [
        (["import", "none.dxf", "-o", "x.xml"], 1, "none.dxf: expected a file"),
        (["import", "map.txt", "-o", "x.xml"], 2, "FILE: expected a name that ends in"),
        (["import", "none.dxf", "-o", "x.svg"], 2, "--output: expected a name that ends in .xml"),
        (["export", "ward", "-o", "x.pgm"], 2, "--output: expected a name that ends in .yaml"),
        (["export", "wart", "-o", "x.yaml"], 1, "MAP: expected one of the maps"),
    ],
)
def test_wrong_imports_and_exports(
    words: list[str], code: int, text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    assert main(words) == code
    assert text in capsys.readouterr().err


@pytest.mark.parametrize("words", [
    ["draw", "ward", "old.svg"], ["import", "floor.geojson", "-o", "old.xml"], ["export", "ward", "-o", "old.yaml"],
    ["export", "ward", "-o", "pair.yaml"],
])  # fmt: skip
def test_file_that_exists_is_not_replaced(
    words: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("old.svg", "old.xml", "old.yaml", "pair.places.yaml"):
        Path(name).write_text("old")
    assert main(words) == 2
    assert "the file exists; --overwrite replaces it" in capsys.readouterr().err
    assert {path.read_text() for path in tmp_path.iterdir()} == {"old"}


def test_file_is_replaced_if_that_is_wanted(tmp_path: Path) -> None:
    plan = tmp_path / "plan.svg"
    plan.write_text("old")
    assert main(["draw", "ward", str(plan), "--overwrite"]) == 0
    assert plan.read_text() != "old"
