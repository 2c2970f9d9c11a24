from __future__ import annotations

import pytest

from intellwheels_schemas import elements
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Actions, Map, Result


def plain(text: str, *, strict: bool = True) -> elements.Plain:
    return elements.to_plain(elements.parse(text.encode(), "Actions"), Actions, "Actions", strict=strict)


def test_numbers_become_numbers_and_what_is_none_stays_text() -> None:
    assert plain('<Actions Tick="5" LeftMotor="-1e-1" Leave="true" RightMotor="fast"/>') == {
        "Tick": 5,
        "LeftMotor": -0.1,
        "Leave": True,
        "RightMotor": "fast",
    }


def test_text_is_kept_to_the_character() -> None:
    say = " ]]> <&\"'\n\té 😀 "
    assert plain(elements.to_xml(Actions(say=say))) == {"Say": say}
    assert plain(elements.to_xml(Actions(say=""))) == {"Say": ""}


def test_attributes_keep_line_feeds_tabs_and_quotes() -> None:
    floor = Map(format="iw.v1", name="m", title='a\n\t"b" <c> & d')
    text = elements.to_xml(floor)
    assert text == '<Map Format="iw.v1" Name="m" Title="a&#10;&#9;&quot;b&quot; &lt;c&gt; &amp; d"/>'
    read = elements.to_plain(elements.parse(text.encode(), "Map"), Map, "Map", strict=True)
    assert read["Title"] == floor.title


def test_text_that_may_be_absent_is_absent_when_empty() -> None:
    element = elements.parse(b'<Result Code="ok"></Result>', "Result")
    assert elements.to_plain(element, Result, "Result", strict=True) == {"Code": "ok"}


def test_what_a_document_says_of_its_schema_is_not_read() -> None:
    xsi = 'xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:noNamespaceSchemaLocation="iw.xsd"'
    assert plain(f"<Actions {xsi} Tick='1'/>") == {"Tick": 1}


def test_unknown_things_are_left_out_where_they_may_be() -> None:
    assert plain('<Actions New="1" Tick="2"><New><Say>x</Say></New></Actions>', strict=False) == {"Tick": 2}


def test_document_type_within_text_is_text() -> None:
    assert plain("<Actions><Say><![CDATA[<!DOCTYPE a>]]></Say></Actions>") == {"Say": "<!DOCTYPE a>"}


@pytest.mark.parametrize("head", ["", " ", "<?xml version='1.0'?>", "<!-- <a> -->", "\ufeff", "<?x y?> <!---->"])
def test_document_type_is_found_behind_anything(head: str) -> None:
    with pytest.raises(WireError, match="without a document type"):
        elements.parse(f"{head}<!DOCTYPE a SYSTEM 'file:///etc/passwd'><a/>".encode(), "a")


def test_places_have_lines() -> None:
    text = b"<Map>\n<Wall/>\n<Wall>\n<Corner/><Corner/>\n</Wall>\n<Grid><Position/></Grid></Map>"
    assert dict(elements.places(elements.parse(text, "Map"), Map, "Map")) == {
        "Map": 1,
        "Map.Wall[0]": 2,
        "Map.Wall[1]": 3,
        "Map.Wall[1].Corner[0]": 4,
        "Map.Wall[1].Corner[1]": 4,
        "Map.Grid": 6,
        "Map.Grid.Position[0]": 6,
    }
