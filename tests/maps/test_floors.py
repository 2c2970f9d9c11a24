"""The included floors have the dimensions that the scenes need. Shapely checks them, not the project's own geometry."""

from __future__ import annotations

import functools
import itertools
import math

import pytest
import shapely
from shapely.affinity import rotate, translate
from shapely.geometry import LineString, MultiPolygon, Point, Polygon, box
from shapely.geometry.base import BaseGeometry

from intellwheels_maps import floor, names, robot
from intellwheels_schemas.messages import Map, Place, Robot
from tests.every_case import every_case

FLOORS = names("floors")
CHAIRS = ("rear-wheel", "mid-wheel", "front-wheel", "intellwheels")


def walls(document: Map) -> BaseGeometry:
    shapes = []
    for wall in document.wall:
        corners = [(corner.x, corner.y) for corner in wall.corner]
        if wall.thickness is None:
            shapes.append(Polygon(corners))
        else:
            shapes.append(LineString(corners).buffer(wall.thickness / 2, cap_style="flat", join_style="mitre"))
    return shapely.union_all(shapes)


def solids(document: Map, bottom: float, top: float) -> BaseGeometry:
    """Walls, and the obstacles that share heights with [bottom, top)."""
    obstacles = [
        Polygon([(corner.x, corner.y) for corner in obstacle.corner])
        for obstacle in document.obstacle
        if obstacle.bottom < top and bottom < obstacle.top
    ]
    return shapely.union_all([walls(document), *obstacles])


def plan(document: Robot, place: Place) -> list[tuple[Polygon, float, float]]:
    """The parts of a robot standing at a place, with their heights."""
    if document.part:
        boxes = [(part.x, part.y, part.length, part.width, part.bottom, part.top) for part in document.part]
    else:
        assert document.length
        assert document.width
        centre = 0.5 if document.center is None else document.center
        boxes = [((0.5 - centre) * document.length, 0.0, document.length, document.width, 0.0, document.top or 1.3)]
    return [
        (
            translate(
                rotate(
                    box(x - length / 2, y - width / 2, x + length / 2, y + width / 2), place.heading_deg, origin=(0, 0)
                ),
                place.x,
                place.y,
            ),
            bottom,
            top,
        )
        for x, y, length, width, bottom, top in boxes
    ]


def places(document: Map, kind: str) -> list[Place]:
    assert document.grid
    return [place for place in document.grid.position if kind in place.kinds]


def place(document: Map, name: str) -> Place:
    assert document.grid
    return next(place for place in document.grid.position if place.name == name)


def clear_width(document: Map, name: str) -> float:
    """Return the distance between the two walls at the ends of a doorway's cross line."""
    doorway = next(doorway for doorway in document.doorway if doorway.name == name)
    heading = math.radians(doorway.heading_deg)
    across = (-math.sin(heading), math.cos(heading))
    ends = [(doorway.x + side * across[0] * 3, doorway.y + side * across[1] * 3) for side in (1, -1)]
    free = LineString(ends).difference(walls(document))
    pieces = [piece for piece in shapely.get_parts(free) if piece.distance(Point(doorway.x, doorway.y)) < 1e-9]
    return float(pieces[0].length)


@every_case("name", FLOORS)
def test_floor_has_a_title_and_a_source(name: str) -> None:
    document = floor(name)
    assert document.name == name
    assert document.title
    assert document.source


def test_all_expected_floors_are_there() -> None:
    assert FLOORS == ["corner", "corridor15m", "crossing", "door", "lounge", "room", "square", "ward"]


@every_case("name", FLOORS)
def test_every_wall_is_two_and_a_half_metres_high(name: str) -> None:
    assert {(wall.height, wall.bottom) for wall in floor(name).wall} == {(2.5, 0.0)}


@every_case("name", FLOORS)
def test_coordinates_have_few_digits(name: str) -> None:
    document = floor(name)
    corners = [corner for wall in document.wall for corner in wall.corner]
    corners += [corner for obstacle in document.obstacle for corner in obstacle.corner]
    corners += [corner for zone in document.zone for corner in zone.corner]
    for corner in corners:
        assert round(corner.x, 3) == corner.x
        assert round(corner.y, 3) == corner.y


@every_case("chair", CHAIRS)
@every_case("name", FLOORS)
def test_every_start_place_is_free_for_every_chair(name: str, chair: str) -> None:
    document = floor(name)
    body, around = robot(chair), functools.cache(functools.partial(solids, document))
    for start in places(document, "wheelchair"):
        for shape, bottom, top in plan(body, start):
            assert shape.distance(around(bottom, top)) > 0.01, start.name


@every_case("name", FLOORS)
def test_start_places_do_not_overlap_one_another(name: str) -> None:
    starts = [
        shape for start in places(floor(name), "wheelchair") for shape, _, _ in plan(robot("rear-wheel"), start)[:1]
    ]
    area = sum(shape.area for shape in starts)
    assert shapely.union_all(starts).area == pytest.approx(area, rel=1e-9)


@every_case("name", FLOORS)
def test_every_goal_is_free_for_a_chair_that_arrives_with_its_heading(name: str) -> None:
    document = floor(name)
    body, around = robot("intellwheels"), functools.cache(functools.partial(solids, document))
    for goal in places(document, "goal"):
        for shape, bottom, top in plan(body, goal):
            assert shape.distance(around(bottom, top)) > 0.01, goal.name


@pytest.mark.parametrize("name", ["door", "room", "ward"])
def test_door_leaf_swings_to_both_sides_with_0_06_m_at_the_hinge(name: str) -> None:
    document = floor(name)
    [hinge] = places(document, "door")
    solid = solids(document, 0.0, 2.0)
    # The design's bound: nearer and the leaf jams on its own jamb (its corner is 0.051 m from the hinge).
    assert Point(hinge.x, hinge.y).distance(solid) >= 0.06 - 1e-9
    for turn in range(-90, 91, 3):
        at = Place(name="hinge", x=hinge.x, y=hinge.y, heading_deg=hinge.heading_deg + turn)
        [(leaf, _, _)] = plan(robot("door"), at)
        # 0.06 m at the hinge less the leaf's nearest corner, sqrt(0.01^2 + 0.05^2).
        assert leaf.distance(solid) > 0.06 - 0.0511, turn


@pytest.mark.parametrize("name", ["door", "room", "ward"])
def test_closed_leaf_fills_its_doorway_except_for_slits(name: str) -> None:
    document = floor(name)
    [hinge] = places(document, "door")
    [(leaf, _, _)] = plan(robot("door"), hinge)
    opening = document.doorway[0]
    heading = math.radians(opening.heading_deg)
    across = (-math.sin(heading) * opening.width / 2, math.cos(heading) * opening.width / 2)
    along = LineString([(opening.x + side * across[0], opening.y + side * across[1]) for side in (1, -1)])
    slits = [slit.length for slit in shapely.get_parts(along.difference(leaf))]
    assert slits == pytest.approx([0.05, 0.05])


@pytest.mark.parametrize("name", ["door", "room", "ward"])
def test_open_leaf_lets_the_widest_chair_through(name: str) -> None:
    document = floor(name)
    [hinge] = places(document, "door")
    for turn in (-90, 90):
        at = Place(name="hinge", x=hinge.x, y=hinge.y, heading_deg=hinge.heading_deg + turn)
        [(leaf, _, _)] = plan(robot("door"), at)
        opening = document.doorway[0]
        lane = box(opening.x - 0.6, opening.y - 0.33, opening.x + 0.6, opening.y + 0.33)
        assert lane.distance(shapely.union_all([leaf, walls(document)])) > 0.1


@pytest.mark.parametrize("name", ["corridor15m", "door", "corner", "ward"])
def test_corridor_is_2_4_m_wide(name: str) -> None:
    document = floor(name)
    for x in (1.5, 3.5):
        free = LineString([(x, -3.0), (x, 3.0)]).difference(walls(document))
        [middle] = [piece for piece in shapely.get_parts(free) if piece.distance(Point(x, 0.0)) < 1e-9]
        assert middle.length == pytest.approx(2.4, abs=1e-9)
        assert middle.bounds == pytest.approx((x, -1.2, x, 1.2))


def test_second_leg_of_the_corner_is_as_wide() -> None:
    free = LineString([(5.0, 6.0), (20.0, 6.0)]).difference(walls(floor("corner")))
    [middle] = [piece for piece in shapely.get_parts(free) if piece.distance(Point(11.2, 6.0)) < 1e-9]
    assert middle.length == pytest.approx(2.4, abs=1e-9)


def test_corridor_of_fifteen_metres_has_the_blocks_of_the_first_experiment() -> None:
    document = floor("corridor15m")
    bounds = {
        obstacle.name: Polygon([(corner.x, corner.y) for corner in obstacle.corner]).bounds
        for obstacle in document.obstacle
    }
    assert bounds == {"a": (5.0, -1.2, 5.8, -0.2), "b": (10.0, 0.2, 10.8, 1.2)}
    assert place(document, "goal").x - place(document, "start").x == 15.0


def test_door_floor_has_the_hinge_of_the_second_experiment() -> None:
    hinge = place(floor("door"), "hinge")
    assert (hinge.x, hinge.y, hinge.heading_deg) == (6.0, -0.49, -90.0)
    [(leaf, _, _)] = plan(robot("door"), hinge)
    assert leaf.bounds == pytest.approx((5.95, -0.5, 6.05, 0.5))


def test_doors_of_the_ward_are_clear_between_ninety_and_a_hundred_and_fifteen() -> None:
    document = floor("ward")
    widths = {doorway.name: clear_width(document, doorway.name) for doorway in document.doorway}
    assert len(widths) >= 10
    assert min(widths.values()) == pytest.approx(0.9)
    assert max(widths.values()) == pytest.approx(1.15)


@every_case("name", FLOORS)
def test_every_doorway_states_its_clear_width(name: str) -> None:
    document = floor(name)
    for doorway in document.doorway:
        assert clear_width(document, doorway.name) == pytest.approx(doorway.width, abs=1e-9)


def test_ward_has_at_least_ten_rooms_that_a_chair_can_reach() -> None:
    """A circle with half the width of a chair can reach every start place from the corridor."""
    document = floor("ward")
    assert len([zone for zone in document.zone if zone.name not in {"corridor", "lobby"}]) >= 10
    # Grown walls leave the ground that a disc of 0.34 m, half of the widest chair and a bit, can stand on.
    ground = box(-5, -7, 36, 7).difference(solids(document, 0.0, 1.3).buffer(0.34))
    islands = list(ground.geoms) if isinstance(ground, MultiPolygon) else [ground]
    [home] = [island for island in islands if island.contains(Point(18.0, 0.3))]
    for start in places(document, "wheelchair"):
        assert home.contains(Point(start.x, start.y)), start.name


def test_every_zone_of_the_ward_is_free_of_walls() -> None:
    document = floor("ward")
    solid = walls(document)
    for zone in document.zone:
        shape = Polygon([(corner.x, corner.y) for corner in zone.corner])
        assert shape.intersection(solid).area < 1e-6, zone.name


def test_room_has_three_starts_three_goals_a_table_and_a_hinge() -> None:
    document = floor("room")
    assert document.grid
    names_there = {position.name for position in document.grid.position}
    spares = {"spare1", "spare2", "spare3", "spare4"}
    assert names_there == {"start1", "start2", "start3", "goal1", "goal2", "goal3", "table", "hinge"} | spares


def test_chair_that_drives_ahead_from_the_first_spare_place_stays_clear_of_the_door() -> None:
    document = floor("room")
    assert document.grid
    first = next(spot for spot in document.grid.position if spot.name.startswith("spare"))
    hinge = place(document, "hinge")
    heading = math.radians(first.heading_deg)
    for ahead in range(4):
        at = first.x + ahead * math.cos(heading), first.y + ahead * math.sin(heading)
        assert math.dist(at, (hinge.x, hinge.y)) > 2.0  # a leaf of 1 m, and the largest chair


def test_goal_behind_the_door_is_out_of_sight_of_its_sensors() -> None:
    """Otherwise the door would always see a chair at the goal, and never close."""
    document = floor("room")
    hinge = place(document, "hinge")
    heading = math.radians(hinge.heading_deg)
    for goal in ("goal1", "goal2", "goal3"):
        [chair, _] = plan(robot("rear-wheel"), place(document, goal))
        for sensor in robot("door").proximity:
            x = hinge.x + sensor.x * math.cos(heading) - sensor.y * math.sin(heading)
            y = hinge.y + sensor.x * math.sin(heading) + sensor.y * math.cos(heading)
            way = hinge.heading_deg + sensor.direction_deg
            rim = [math.radians(way + step) for step in range(-15, 16)]
            wedge = Polygon(
                [(x, y), *((x + sensor.max_range * math.cos(a), y + sensor.max_range * math.sin(a)) for a in rim)]
            )
            assert not wedge.intersects(chair[0]), (goal, sensor.id)


def test_every_chair_can_turn_at_each_place_of_the_ward_even_beside_another_chair() -> None:
    document = floor("ward")
    spots = [*places(document, "wheelchair"), *places(document, "goal")]
    assert len(spots) > 30
    still = Place(name="still", x=0.0, y=0.0, heading_deg=0.0)
    # Of each height interval that a chair has, the farthest corner of any chair.
    reach: dict[tuple[float, float], float] = {}
    for chair in CHAIRS:
        for shape, bottom, top in plan(robot(chair), still):
            farthest = max(math.hypot(x, y) for x, y in shape.exterior.coords)
            reach[bottom, top] = max(reach.get((bottom, top), 0.0), farthest)
    for (bottom, top), radius in reach.items():
        solid = solids(document, bottom, top)
        for spot in spots:
            assert Point(spot.x, spot.y).distance(solid) > radius + 0.01, spot.name
    starts = places(document, "wheelchair")
    apart = min(math.dist((a.x, a.y), (b.x, b.y)) for a, b in itertools.combinations(starts, 2))
    assert apart > 2.0 * max(reach.values())
