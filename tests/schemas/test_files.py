from __future__ import annotations

from pathlib import Path

import pytest

from intellwheels_schemas.errors import WireError
from intellwheels_schemas.files import read_bytes, read_with_lines, write_file
from intellwheels_schemas.messages import Map, Record, Robot, Scene
from intellwheels_schemas.vectors import DOOR, ROOM, VALID

FLOOR = """<?xml version="1.0" encoding="UTF-8"?>
<!-- A floor for people. -->
<Map Format="iw.v1" Name="m">
  <Wall Height="2.0">
    <Corner X="0" Y="0"/><Corner X="1" Y="0"/>
    <Corner X="1" Y="1"/>
  </Wall>
  <Wall Thickness="0.1">
    <Corner X="0" Y="0"/>
    {corner}
  </Wall>
</Map>
"""


def write(folder: Path, corner: str) -> Path:
    path = folder / "m.xml"
    path.write_text(FLOOR.format(corner=corner), encoding="utf-8")
    return path


def refusal(path: Path, cls: type[Record] = Map) -> WireError:
    with pytest.raises(WireError) as caught:
        read_with_lines(cls, path)
    return caught.value


def test_file_is_read_and_its_elements_have_lines(tmp_path: Path) -> None:
    path = write(tmp_path, '<Corner X="2" Y="0"/>')
    floor, lines = read_with_lines(Map, path)
    assert floor == read_with_lines(Map, str(path))[0]
    assert floor.wall[1].corner[1].x == 2.0
    assert lines.at("Map.Wall[0]") == 4
    assert lines.at("Map.Wall[0].Corner[2]") == 6
    assert lines.at("Map.Wall[1]") == 8
    assert lines.at("Map.Wall[7]") == 3
    assert lines.at("Map.Wall[1].Corner[1].X") == 10


@pytest.mark.parametrize(
    ("corner", "line", "words"),
    [
        ("", 8, "Map.Wall[1]: expected at least 2 corners, got 1"),
        ('<Corner X="2"/>', 10, "Map.Wall[1].Corner[1].Y: expected metres in [-10000, 10000], got nothing"),
        ('<Corner X="2" Y="far"/>', 10, "Map.Wall[1].Corner[1].Y: expected metres in [-10000, 10000], got 'far'"),
        ('<Corner X="2" Y="0" Z="0"/>', 10, "Map.Wall[1].Corner[1].Z: expected a field of Corner, got 'Z'"),
        ("<Korner/>", 8, "Map.Wall[1].Korner: expected a field of Wall, got 'Korner'; did you mean Corner?"),
    ],
)
def test_error_has_file_line_and_element(tmp_path: Path, corner: str, line: int, words: str) -> None:
    path = write(tmp_path, corner)
    error = refusal(path)
    assert error.text == f"{path}:{line}: {words}"
    assert error.where == f"{path}:{line}"


def test_broken_xml_has_its_line(tmp_path: Path) -> None:
    path = write(tmp_path, '<Corner X="2" Y=0/>')
    assert refusal(path).text.startswith(f"{path}:10: Map: expected well-formed XML, got ")


def test_file_that_is_not_there_or_is_something_else_is_told(tmp_path: Path) -> None:
    assert refusal(tmp_path / "none.xml").text == f"{tmp_path}/none.xml: expected a file, got none"
    path = write(tmp_path, "")
    assert refusal(path, Scene).text == f"{path}:3: expected <Scene>, got <Map>"


@pytest.mark.parametrize("message", [ROOM, DOOR, VALID["Scene"], VALID["Actions-text"]])
def test_what_was_written_for_people_is_read_again(message: Record) -> None:
    text = write_file(message)
    assert text.endswith(">\n")
    assert read_bytes(type(message), text.encode(), "f")[0] == message


def test_written_file_has_an_element_a_line() -> None:
    assert write_file(Robot(format="iw.v1", length=1.0, width=0.5, encoders=DOOR.encoders)) == (
        '<Robot Format="iw.v1" Length="1.0" Width="0.5"/>\n'
    )
    assert write_file(DOOR).splitlines()[1].startswith('  <Proximity Id="in-left"')


def test_text_that_is_not_utf_8_is_named_with_its_line(tmp_path: Path) -> None:
    path = tmp_path / "map.xml"
    path.write_bytes(b'<Map Format="iw.v1"\nName="a" Title="caf\xe9"/>')
    error = refusal(path)
    assert error.text == f"{path}:2: expected text in UTF-8, got the byte 0xe9; save the file as UTF-8"
    path.write_bytes('<?xml version="1.0" encoding="UTF-16"?><Map Format="iw.v1" Name="a"/>'.encode("utf-16"))
    assert refusal(path).text == f"{path}:1: expected text in UTF-8, got the byte 0xff; save the file as UTF-8"
