"""The included scenes are consistent: floor, robots, places, and the path through the door."""

from __future__ import annotations

from shapely.geometry import LineString, box

from intellwheels_maps import floor, names, robot, scene
from tests.every_case import every_case


@every_case("name", names("scenes"))
def test_scene_names_existing_floors_and_robots(name: str) -> None:
    document = scene(name)
    assert document.name == name
    assert floor(document.map).grid
    for cast in document.cast:
        assert robot(cast.robot).kind


def test_figure_six_has_three_different_chairs_a_table_and_a_door() -> None:
    document = scene("figure6")
    kinds = sorted(robot(cast.robot).kind for cast in document.cast)
    assert kinds == ["door", "table", "wheelchair", "wheelchair", "wheelchair"]
    chairs = [robot(cast.robot) for cast in document.cast if robot(cast.robot).kind == "wheelchair"]
    assert len({chair.acceleration_curve for chair in chairs}) == 3
    assert len({(chair.part[0].length, chair.part[0].x) for chair in chairs}) == 3


def test_figure_six_is_judged_on_every_chair_and_on_contacts() -> None:
    document = scene("figure6")
    assert document.end
    assert document.end.timeout
    assert document.hold
    chairs = {cast.name for cast in document.cast if robot(cast.robot).kind == "wheelchair"}
    assert {reach.agent for reach in document.end.reach} == chairs
    assert (document.hold.contacts, document.hold.reached) == (0, "all")
    assert (document.pace, document.miss) == ("lockstep", "strict")


def test_one_chair_of_figure_six_ends_behind_the_door() -> None:
    document = scene("figure6")
    ground = floor(document.map)
    assert document.end
    assert ground.grid
    [doorway] = ground.doorway
    sides = {place.name: place.x > doorway.x for place in ground.grid.position}
    starts = {cast.name: cast.place for cast in document.cast}
    through = [reach.agent for reach in document.end.reach if sides[reach.place] != sides[starts[reach.agent] or ""]]
    assert through == ["chair1"]


def test_path_through_the_door_leads_through_its_middle() -> None:
    document = scene("figure6")
    [doorway] = floor(document.map).doorway
    [chair] = [cast for cast in document.cast if cast.name == "chair1"]
    [points] = [option.value.split() for option in chair.option if option.name == "points"]
    numbers = [float(number) for number in points]
    way = LineString(list(zip(numbers[::2], numbers[1::2], strict=True)))
    partition = box(doorway.x - 0.01, -100, doorway.x + 0.01, 100)
    crossed = way.intersection(partition)
    assert crossed.length > 0
    # The open leaf covers part of the opening at one jamb, so the middle of the rest is slightly off-centre.
    assert abs(crossed.centroid.y - doorway.y) <= 0.1
