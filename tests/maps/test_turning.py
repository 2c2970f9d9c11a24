"""Places at which a robot cannot turn are named, with what it needs and what is there."""

from __future__ import annotations

import math
from typing import Any

from intellwheels_maps import floor, names, robot, scene
from intellwheels_maps.turning import TurningCheck, narrow_places, narrow_starts
from intellwheels_schemas.messages import Cast, Corner, Grid, Map, Obstacle, Part, Place, Robot, Scene, Wall
from tests.every_case import every_case

CHAIRS = {name: body for name in names("robots") if (body := robot(name)).kind == "wheelchair"}
PLATE = Part(x=0.0, y=0.0, length=2.0, width=0.5, bottom=1.0, top=1.2)
BASE = Part(x=0.1, y=0.0, length=1.0, width=0.6, bottom=0.0, top=1.0)


def ring(x0: float, y0: float, x1: float, y1: float) -> tuple[Corner, ...]:
    return tuple(Corner(x=x, y=y) for x, y in ((x0, y0), (x1, y0), (x1, y1), (x0, y1)))


def ground(*places: Place, **fields: Any) -> Map:
    return Map(format="iw.v1", name="m", grid=Grid(position=places), **fields)


def test_each_part_needs_the_circle_of_its_farthest_corner_at_its_own_height() -> None:
    body = Robot(top_speed=1.0, part=(BASE, PLATE))
    low = ground(obstacle=(Obstacle(name="box", top=0.9, corner=ring(0.7, -1.0, 2.0, 1.0)),))
    high = ground(obstacle=(Obstacle(name="shelf", bottom=1.0, top=1.5, corner=ring(0.7, -1.0, 2.0, 1.0)),))
    assert math.hypot(0.6, 0.3) < 0.7 < math.hypot(1.0, 0.25)
    assert TurningCheck(low).narrowness(body, 0.0, 0.0) is None
    expected = "it needs 1.031 m to turn on the spot, got 0.700 m to obstacle 'shelf'"
    assert TurningCheck(high).narrowness(body, 0.0, 0.0) == expected
    assert (
        TurningCheck(low).narrowness(body, 0.1, 0.0)
        == "it needs 0.671 m to turn on the spot, got 0.600 m to obstacle 'box'"
    )
    assert (
        TurningCheck(low).narrowness(body, 1.0, 0.0)
        == "it needs 0.671 m to turn on the spot, got 0.000 m to obstacle 'box'"
    )


def test_what_never_turns_on_the_spot_needs_no_room() -> None:
    close = ground(wall=(Wall(thickness=0.2, corner=(Corner(x=0.3, y=-1.0), Corner(x=0.3, y=1.0))),))
    assert TurningCheck(close).narrowness(Robot(top_speed=1.0, part=(BASE,)), 0.0, 0.0) is not None
    assert TurningCheck(close).narrowness(Robot(part=(BASE,)), 0.0, 0.0) is None
    assert TurningCheck(close).narrowness(Robot(top_speed=1.0, anchored=True, part=(BASE,)), 0.0, 0.0) is None


def test_places_are_held_to_the_robots_that_use_them() -> None:
    spots = (
        Place(name="any", x=0.0, y=0.0),
        Place(name="chairs", x=0.0, y=0.0, kinds=("wheelchair",)),
        Place(name="arrive", x=0.0, y=0.0, kinds=("goal",)),
        Place(name="people", x=0.0, y=0.0, kinds=("person",)),
        Place(name="far", x=-5.0, y=0.0),
    )
    close = ground(*spots, wall=(Wall(corner=ring(0.65, -1.0, 1.0, 1.0)),))
    chair = Robot(kind="wheelchair", top_speed=1.0, part=(BASE,))
    found = [finding.element for finding in narrow_places(close, {"mine": chair, "walker": robot("person")})]
    assert found == ["Map.Grid.Position[0]", "Map.Grid.Position[1]", "Map.Grid.Position[2]"]
    [first, *_] = narrow_places(close, {"mine": chair})
    assert first.text == (
        "place 'any' is too narrow for 'mine': it needs 0.671 m to turn on the spot, got 0.650 m to Wall[0]"
    )
    cast = (Cast(name="a", robot="r", mind="m", place="any"), Cast(name="b", robot="r", mind="m", place="far"))
    [start] = narrow_starts(Scene(format="iw.v1", name="s", map="m", cast=cast), close, {"a": chair, "b": chair})
    assert (start.element, start.text[:43]) == ("Scene.Cast[0]", "agent 'a': place 'any' is too narrow: it ne")


def test_no_place_of_the_ward_is_too_narrow_for_an_included_chair() -> None:
    assert narrow_places(floor("ward"), CHAIRS) == []


@every_case("name", names("scenes"))
def test_nobody_in_an_included_scene_starts_where_it_cannot_turn(name: str) -> None:
    chosen = scene(name)
    bodies = {cast.name: robot(cast.robot) for cast in chosen.cast if cast.robot}
    assert narrow_starts(chosen, floor(chosen.map), bodies) == []


def test_solid_of_any_size_is_found_wherever_it_begins() -> None:
    body = Robot(top_speed=1.0, part=(BASE,))
    for size in (0.1, 30.0, 900.0, 9000.0):
        for x in (-7.9, 7.9, 100.3):
            near = ground(obstacle=(Obstacle(name="box", top=1.0, corner=ring(x, -size, x + size, size)),))
            check = TurningCheck(near)
            assert check.narrowness(body, x - 0.5, 0.0) is not None
            assert check.narrowness(body, x - 1.0, 0.0) is None
