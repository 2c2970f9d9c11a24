from __future__ import annotations

from pathlib import Path

import pytest

from intellwheels_maps import floor, names, robot, scene
from intellwheels_maps.importers import ENDINGS
from intellwheels_maps.library import folder_of, imported, is_foreign, is_path
from intellwheels_schemas.errors import WireError
from tests.every_case import every_case

MAP = """<Map Format="iw.v1" Name="mine">
  <Wall Thickness="0.1"><Corner X="0.0" Y="0.0"/><Corner X="4.0" Y="0.0"/></Wall>
  <!-- a comment moves the lines, not the order -->
  {wall}
  <Grid>
    <Position Name="start" X="1.0" Y="1.0"/>
    <Position Name="{place}" X="2.0" Y="1.0"/>
  </Grid>
</Map>
"""
WALL = '<Wall Thickness="0.1"><Corner X="0.0" Y="4.0"/><Corner X="4.0" Y="4.0"/></Wall>'


def write(folder: Path, name: str, text: str) -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def test_names_are_sorted_and_have_no_ending() -> None:
    for shelf in ("floors", "robots", "scenes"):
        known = names(shelf)
        assert known
        assert known == sorted(known)
        assert not any("." in name for name in known)


@every_case(
    "text",
    [
        "ward.xml",
        "./ward",
        "maps/ward",
        "/maps/ward",
        "mind.py",
        "a/mind",
        "ward.yaml",
        "b.building.yaml#L2",
        "a.ifc#g",
    ],
)
def test_text_with_a_slash_or_an_ending_is_a_path(text: str) -> None:
    assert is_path(text)
    assert folder_of(text) == Path(text).absolute().parent


def test_path_is_one_whatever_its_name() -> None:
    assert is_path(Path("ward"))


@pytest.mark.parametrize("text", ["ward", "mid-wheel", "avoid", "ward.png"])
def test_plain_word_is_a_name(text: str) -> None:
    assert not is_path(text)
    assert folder_of(text) is None


def test_unknown_shelf_is_an_error() -> None:
    with pytest.raises(ValueError, match="shelf: expected one of floors, robots, scenes"):
        names("cupboards")  # type: ignore[arg-type]


@every_case("name", names("floors"))
def test_every_shipped_floor_loads(name: str) -> None:
    assert floor(name).name == name


@every_case("name", names("robots"))
def test_every_shipped_robot_loads(name: str) -> None:
    assert robot(name).format == "iw.v1"


@every_case("name", names("scenes"))
def test_every_shipped_scene_loads(name: str) -> None:
    assert scene(name).name == name


def test_unknown_name_is_refused_with_the_known_ones() -> None:
    with pytest.raises(WireError) as caught:
        floor("wart")
    assert caught.value.text == (
        f"expected one of the maps ({', '.join(names('floors'))}) or a path ending in .xml, "
        f"{', '.join(ENDINGS[:-1])} or {ENDINGS[-1]}, got 'wart'; "
        "did you mean 'ward'?"
    )


def test_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(WireError) as caught:
        floor(tmp_path / "none.xml")
    assert caught.value.text.startswith(f"{tmp_path}/none.xml: expected a file, got ")


def test_users_floor_is_read_by_its_path_or_relative_to_a_folder(tmp_path: Path) -> None:
    path = write(tmp_path, "mine.xml", MAP.format(wall=WALL, place="goal"))
    assert floor(path) == floor(str(path)) == floor("mine.xml", beside=tmp_path)
    assert floor(path).name == "mine"


def test_finding_names_file_and_line(tmp_path: Path) -> None:
    path = write(tmp_path, "mine.xml", MAP.format(wall=WALL, place="start"))
    with pytest.raises(WireError) as caught:
        floor(path)
    assert caught.value.text == f"{path}:7: place 'start' exists twice, expected different names"
    assert caught.value.where == f"{path}:7"
    assert caught.value.code == "value"


def test_wall_of_one_corner_is_refused_with_its_line(tmp_path: Path) -> None:
    wall = '<Wall Thickness="0.1"><Corner X="0.0" Y="4.0"/></Wall>'
    path = write(tmp_path, "mine.xml", MAP.format(wall=wall, place="goal"))
    with pytest.raises(WireError) as caught:
        floor(path)
    assert caught.value.text.startswith(f"{path}:4: ")
    assert caught.value.text.endswith("at least 2 corners, got 1")


def test_all_findings_of_a_file_are_reported_together(tmp_path: Path) -> None:
    wall = WALL.replace('X="4.0"', 'X="0.0"')
    path = write(tmp_path, "mine.xml", MAP.format(wall=wall, place="start"))
    with pytest.raises(WireError) as caught:
        floor(path)
    assert [line.split(": ")[0] for line in caught.value.text.splitlines()] == [f"{path}:4", f"{path}:7"]


def test_attribute_that_is_not_a_number_is_refused_with_file_line_and_element(tmp_path: Path) -> None:
    wall = WALL.replace('X="4.0"', 'X="four"')
    path = write(tmp_path, "mine.xml", MAP.format(wall=wall, place="goal"))
    with pytest.raises(WireError) as caught:
        floor(path)
    assert f"{path}:4" in caught.value.text
    assert "Corner" in caught.value.text
    assert "four" in caught.value.text


def test_scene_finds_its_floor_and_robots_in_its_own_folder(tmp_path: Path) -> None:
    write(tmp_path, "mine.xml", MAP.format(wall=WALL, place="goal"))
    write(tmp_path, "box.xml", '<Robot Format="iw.v1" Kind="box" Length="1.0" Width="1.0" Center="0.5"/>')
    text = """<Scene Format="iw.v1" Name="s" Map="mine.xml">
  <Cast Name="a" Robot="box.xml" Mind="drive" Place="start"/>
</Scene>"""
    assert scene(write(tmp_path, "s.xml", text)).map == "mine.xml"


def test_scene_with_a_missing_laboratory_chair_is_refused(tmp_path: Path) -> None:
    write(tmp_path, "floor.xml", MAP.format(wall=WALL, place="goal"))
    text = """<Scene Format="iw.v1" Name="s" Map="floor.xml">
  <Cast Name="a" Robot="rear-wheel" Mind="drive" Place="start"/>
  <Bridge Agent="a" Chair="chiar"/>
</Scene>
"""
    with pytest.raises(WireError, match=r"chair of 'a': .*chiar"):
        scene(str(write(tmp_path, "scene.xml", text)))


def test_scene_with_an_unknown_place_or_robot_is_refused_with_its_line(tmp_path: Path) -> None:
    write(tmp_path, "mine.xml", MAP.format(wall=WALL, place="goal"))
    text = """<Scene Format="iw.v1" Name="s" Map="mine.xml">
  <Cast Name="a" Robot="crate" Mind="drive" Place="start"/>
  <Cast Name="b" Robot="create" Mind="drive" Place="bed"/>
</Scene>"""
    path = write(tmp_path, "s.xml", text)
    with pytest.raises(WireError) as caught:
        scene(path)
    place, body = caught.value.text.splitlines()
    assert place == f"{path}:3: expected one of the places of 'mine' (goal, start), got 'bed'"
    assert body.startswith(f"{path}:3: agent 'b': expected one of the robots (")
    assert body.endswith("got 'create'; did you mean 'crate'?")


ROS = "image: m.pgm\nresolution: 0.5\norigin: [0, 0, 0]\n"


def test_a_floor_of_another_program_is_a_map(tmp_path: Path) -> None:
    path = write(tmp_path, "m.yaml", ROS)
    (tmp_path / "m.pgm").write_bytes(b"P5\n3 3\n255\n" + bytes([255] * 4 + [0] + [255] * 4))
    assert len(floor(path).wall) == len(floor("m.yaml", beside=tmp_path).wall) == 1
    assert is_foreign(path)
    (tmp_path / "m.pgm").unlink()
    with pytest.raises(WireError, match=r"m\.pgm: expected a file, got none"):
        floor(path)
    with pytest.raises(WireError, match=r"m\.yaml: expected no '#' after the name"):
        floor(f"{path}#L1")
    with pytest.raises(WireError, match=r"none\.dxf: expected a file, got none"):
        imported(tmp_path / "none.dxf")


@every_case("name", ["a#b.xml", "a.yaml#b.xml", "a.xml#b.xml", "a b?.xml", "a%20b.xml", "ü#.xml"])
def test_map_opens_whatever_its_name(name: str, tmp_path: Path) -> None:
    path = write(tmp_path, name, MAP.format(wall=WALL, place="goal"))
    assert floor(str(path)) == floor(name, beside=tmp_path)
    assert not is_foreign(path)


def test_a_file_that_has_the_whole_name_is_no_level(tmp_path: Path) -> None:
    (tmp_path / "m.pgm").write_bytes(b"P5\n3 3\n255\n" + bytes([255] * 4 + [0] + [255] * 4))
    path = write(tmp_path, "a.yaml#b.yaml", ROS)
    assert is_foreign(path)
    assert len(floor(path).wall) == 1


def test_a_lab_is_told_by_its_root(tmp_path: Path) -> None:
    lab = write(tmp_path, "MyLab.xml", '<Lab Name="l" Height="5" Width="6"/>')
    assert is_foreign(lab)
    assert floor(lab).title == "l"
    assert not is_foreign(write(tmp_path, "map.xml", MAP))


def test_a_file_that_is_too_long_is_not_read(tmp_path: Path) -> None:
    path = tmp_path / "m.yaml"
    with path.open("wb") as file:
        file.truncate((64 << 20) + 1)  # a file of holes: no bytes are written
    with pytest.raises(WireError, match=r"m\.yaml.* at most 67,?108,?864 bytes"):
        floor(path)


def test_included_document_is_read_once_and_a_file_each_time(tmp_path: Path) -> None:
    assert floor("room") is floor("room")
    assert robot("table") is robot("table")
    path = write(tmp_path, "mine.xml", MAP.format(wall=WALL, place="end"))
    before = floor(path)
    path.write_text(path.read_text(encoding="utf-8").replace('"end"', '"goal"'), encoding="utf-8")
    assert before.grid
    assert floor(path).grid != before.grid
