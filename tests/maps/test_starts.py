from __future__ import annotations

from pathlib import Path

import pytest

from intellwheels_maps import names, robot, scene
from intellwheels_maps.starts import SLACK, check_starts
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Cast, Corner, Grid, Map, Obstacle, Part, Place, Robot, Scene, Wall
from tests.every_case import every_case

BOX = Robot(part=(Part(x=0.0, y=0.0, length=1.0, width=0.5, bottom=0.0, top=1.0),))
SHELF = Robot(part=(Part(x=0.0, y=0.0, length=1.0, width=0.5, bottom=1.2, top=1.5),))


def found(*places: Place, robots: tuple[Robot, ...] = (BOX, BOX), **floor: object) -> list[str]:
    ground = Map(format="iw.v1", name="m", grid=Grid(position=places), **floor)  # type: ignore[arg-type]
    cast = tuple(Cast(name=f"a{i}", robot="r", mind="m", place=place.name) for i, place in enumerate(places))
    bodies = {one.name: body for one, body in zip(cast, robots, strict=False)}
    return [
        finding.text for finding in check_starts(Scene(format="iw.v1", name="s", map="m", cast=cast), ground, bodies)
    ]


def at(name: str, x: float, y: float = 0.0, heading: float = 0.0) -> Place:
    return Place(name=name, x=x, y=y, heading_deg=heading)


def test_bodies_in_one_another_are_found() -> None:
    overlaps = ["agent 'a1': expected a free place, got one that overlaps agent 'a0'"]
    assert found(at("p", 0.0), at("q", 0.9)) == overlaps
    assert found(at("p", 0.0), at("q", 0.0)) == overlaps  # one covers the other exactly
    assert found(at("p", 0.0), at("q", 0.8, 0.0, 45.0)) == overlaps
    assert found(at("p", 0.0), at("q", 0.0), robots=(BOX, Robot(length=0.1, width=0.1))) == overlaps


def test_bodies_that_touch_or_pass_one_another_are_free() -> None:
    assert found(at("p", 0.0), at("q", 1.0)) == []
    assert found(at("p", 0.0), at("q", 1.0 - SLACK)) == []
    assert found(at("p", 0.0), at("q", 0.8, 0.0, 90.0)) == []
    assert found(at("p", 0.0), at("q", 0.0), robots=(BOX, SHELF)) == []  # above the other
    assert found(at("p", 0.0), at("q", 0.0), robots=(BOX,)) == []  # a program brings its own body


def test_a_body_in_a_wall_or_an_obstacle_is_found() -> None:
    wall = Wall(thickness=0.2, corner=(Corner(x=0.0, y=-2.0), Corner(x=0.0, y=2.0)))
    [text] = found(at("p", 0.5), wall=(wall,))
    assert text == "agent 'a0': expected a free place, got one in Wall[0]"
    assert found(at("p", 0.61), wall=(wall,)) == []
    bed = Obstacle(name="bed", top=0.5, corner=(Corner(x=0, y=0), Corner(x=9, y=0), Corner(x=9, y=9), Corner(x=0, y=9)))
    assert found(at("p", 4.0, 4.0), obstacle=(bed,)) == ["agent 'a0': expected a free place, got one in obstacle 'bed'"]
    assert found(at("p", 4.0, 4.0), robots=(SHELF,), obstacle=(bed,)) == []


@every_case("name", names("scenes"))
def test_nobody_in_an_included_scene_overlaps(name: str) -> None:
    assert scene(name).cast


def test_a_scene_with_overlapping_starts_is_refused_with_its_line(tmp_path: Path) -> None:
    (tmp_path / "m.xml").write_text(
        '<Map Format="iw.v1" Name="m"><Grid><Position Name="p" X="0.0" Y="0.0"/>'
        '<Position Name="q" X="0.3" Y="0.0"/></Grid></Map>'
    )
    path = tmp_path / "s.xml"
    path.write_text(
        '<Scene Format="iw.v1" Name="s" Map="m.xml">\n<Cast Name="a" Robot="mid-wheel" Mind="drive" Place="p"/>\n'
        '<Cast Name="b" Robot="mid-wheel" Mind="drive" Place="q"/>\n</Scene>'
    )
    assert robot("mid-wheel").part
    with pytest.raises(WireError) as caught:
        scene(path)
    assert caught.value.text == f"{path}:3: agent 'b': expected a free place, got one that overlaps agent 'a'"
