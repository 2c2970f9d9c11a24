from __future__ import annotations

from xml.etree import ElementTree

from intellwheels_maps import floor, names
from intellwheels_maps.draw import draw
from intellwheels_schemas.messages import Corner, Grid, Map, Place, Route, Wall, Zone
from tests.every_case import every_case

SVG = "{http://www.w3.org/2000/svg}"


@every_case("name", names("floors"))
def test_plan_shows_every_wall_obstacle_doorway_zone_and_place(name: str) -> None:
    document = floor(name)
    assert document.grid
    root = ElementTree.fromstring(draw(document))
    drawn = [element.get("class") for element in root.iter()]
    assert drawn.count("line") + drawn.count("wall") == len(document.wall)
    assert drawn.count("obstacle") + drawn.count("overhead") == len(document.obstacle)
    assert drawn.count("doorway") == 2 * len(document.doorway)
    assert drawn.count("zone") == len(document.zone)
    assert len(root.findall(f".//{SVG}circle")) == len(document.grid.position)
    texts = {element.text for element in root.iter(f"{SVG}text")}
    assert texts >= {zone.title for zone in document.zone}
    assert texts >= {place.name for place in document.grid.position}


def test_north_is_up_and_east_is_right() -> None:
    places = (Place(name="south-west", x=0.0, y=0.0), Place(name="north-east", x=3.0, y=2.0))
    root = ElementTree.fromstring(draw(Map(format="iw.v1", name="f", grid=Grid(position=places))))
    one, other = root.findall(f".//{SVG}circle")
    assert float(one.get("cx", "")) < float(other.get("cx", ""))
    assert float(one.get("cy", "")) > float(other.get("cy", ""))


def test_everything_lies_inside_the_view() -> None:
    corners = (Corner(x=-3.0, y=-1.0), Corner(x=4.0, y=-1.0), Corner(x=4.0, y=2.5))
    root = ElementTree.fromstring(draw(Map(format="iw.v1", name="f", wall=(Wall(corner=corners),))))
    left, top, width, height = map(float, root.get("viewBox", "").split())
    polygon = root.find(f"{SVG}polygon")
    assert polygon is not None
    for pair in polygon.get("points", "").split():
        x, y = map(float, pair.split(","))
        assert left < x < left + width
        assert top < y < top + height


def test_titles_with_special_characters_are_escaped() -> None:
    corners = (Corner(x=0.0, y=0.0), Corner(x=1.0, y=0.0), Corner(x=0.0, y=1.0))
    zone = Zone(name="z", title="Ear, Nose & Throat <3>", corner=corners)
    root = ElementTree.fromstring(draw(Map(format="iw.v1", name="f", zone=(zone,))))
    assert "Ear, Nose & Throat <3>" in {element.text for element in root.iter(f"{SVG}text")}


def test_empty_floor_can_be_drawn() -> None:
    assert ElementTree.fromstring(draw(Map(format="iw.v1", name="empty"))).tag == f"{SVG}svg"


def test_route_is_a_line_between_its_places() -> None:
    places = tuple(Place(name=name, x=x, y=1.0) for name, x in (("a", 0.0), ("b", 2.0)))
    document = Map(format="iw.v1", name="m", grid=Grid(position=places), route=(Route(name="r", places=("a", "b")),))
    assert '<polyline class="route" points="0,-100 200,-100"><title>r</title></polyline>' in draw(document)
