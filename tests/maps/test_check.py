from __future__ import annotations

import msgspec
import pytest

from intellwheels_maps.check import Finding, check_map, check_robot, check_scene, opening, wall_pieces
from intellwheels_schemas.messages import (
    Cast,
    Corner,
    Doorway,
    End,
    Grid,
    Hold,
    Map,
    Obstacle,
    Place,
    Position,
    Reach,
    Robot,
    Route,
    Scene,
    Wall,
    Zone,
)


def corners(*points: tuple[float, float]) -> tuple[Corner, ...]:
    return tuple(Corner(x=x, y=y) for x, y in points)


def line(*points: tuple[float, float]) -> Wall:
    return Wall(thickness=0.1, corner=corners(*points))


def floor(**fields: object) -> Map:
    return Map(format="iw.v1", name="floor", **fields)  # type: ignore[arg-type]


def texts(findings: list[Finding]) -> list[str]:
    return [finding.text for finding in findings]


SQUARE = corners((0, 0), (1, 0), (1, 1), (0, 1))
GAP = (line((0, -3), (0, -0.5)), line((0, 0.5), (0, 3)))


def test_valid_floor_has_no_findings() -> None:
    doorway = Doorway(name="d", x=0.0, y=0.0, heading_deg=0.0, width=1.0)
    document = floor(
        wall=(*GAP, Wall(corner=corners((5, 0), (6, 0), (6, 1)))),
        doorway=(doorway,),
        zone=(Zone(name="z", corner=SQUARE),),
        grid=Grid(position=(Place(name="p", x=1.0, y=2.0),)),
    )
    assert check_map(document) == []


@pytest.mark.parametrize(
    ("points", "text"),
    [
        ([(0, 0), (1, 1), (1, 0), (0, 1)], "zone 'z' crosses itself: edges 0 and 2, counted from 0"),
        ([(0, 0), (2, 0), (1, 0), (1, 1)], "zone 'z' crosses itself: edges 0 and 1, counted from 0"),
        ([(0, 0), (2, 0), (2, 2), (1, 0), (0, 2)], "zone 'z' crosses itself: edges 0 and 3, counted from 0"),
        ([(0, 0), (1, 0), (2, 0)], "zone 'z' has no area: its corners are on one line"),
        ([(0, 0), (1, 0), (1, 0), (0, 1)], "zone 'z' has the same corner twice in a row, X 1.0 Y 0.0"),
        ([(0, 0), (0, 0), (0, 1), (1, 1)], "zone 'z' has the same corner twice in a row, X 0.0 Y 0.0"),
        ([(0, 0), (1, 0), (1, 1e-10), (1, 1)], "zone 'z' has corners less than 1e-09 m apart, X 1.0 Y 0.0"),
    ],
)
def test_invalid_polygon_is_found(points: list[tuple[float, float]], text: str) -> None:
    assert texts(check_map(floor(zone=(Zone(name="z", corner=corners(*points)),)))) == [text]


@pytest.mark.parametrize(
    "points",
    [
        [(0, 0), (1, 0), (1, 1)],
        [(0, 0), (4, 0), (4, 3), (2, 1), (0, 3)],
        [(0, 0), (1, 0), (2, 0), (2, 2)],
        [(0, 0), (1, 0), (0, 1), (0, 0)],
    ],
)
def test_concave_and_straight_cornered_polygons_are_valid(points: list[tuple[float, float]]) -> None:
    ring = corners(*points)
    assert check_map(floor(zone=(Zone(name="z", corner=ring),))) == []
    assert check_map(floor(zone=(Zone(name="z", corner=ring[::-1]),))) == []


def test_closed_ring_is_the_polygon_without_its_last_corner() -> None:
    assert wall_pieces(Wall(corner=corners((0, 0), (1, 0), (0, 1), (0, 0)))) == [[(0, 0), (1, 0), (0, 1)]]


def test_line_of_no_thickness_is_found() -> None:
    wall = msgspec.structs.replace(line((0, 0), (1, 0)), thickness=1e-10)
    assert texts(check_map(floor(wall=(wall,)))) == ["wall: expected a Thickness of at least 1e-09 m, got 1e-10"]


def test_line_wall_may_return_to_its_first_corner() -> None:
    assert check_map(floor(wall=(line((0, 0), (4, 0), (4, 4), (0, 4), (0, 0)),))) == []


def test_duplicate_names_are_found() -> None:
    place = Place(name="p", x=3.0, y=3.0)
    findings = check_map(floor(grid=Grid(position=(place, place))))
    assert findings == [Finding("Map.Grid.Position[1]", "place 'p' exists twice, expected different names")]


@pytest.mark.parametrize(
    ("x", "y", "inside"),
    [(0.04, 1.0, True), (0.06, 1.0, False), (-0.04, 2.9, True), (0.0, 0.0, False)],
)
def test_place_inside_a_line_wall_is_found(x: float, y: float, inside: bool) -> None:
    findings = check_map(floor(wall=GAP, grid=Grid(position=(Place(name="p", x=x, y=y),))))
    assert findings == ([Finding("Map.Grid.Position[0]", "place 'p' is inside Wall[1]")] if inside else [])


def test_place_inside_a_bed_is_found() -> None:
    document = floor(
        obstacle=(Obstacle(name="bed", top=0.6, corner=SQUARE),),
        grid=Grid(position=(Place(name="p", x=0.5, y=0.5),)),
    )
    assert texts(check_map(document)) == ["place 'p' is inside obstacle 'bed'"]


@pytest.mark.parametrize(
    ("y", "heading_deg", "width", "text"),
    [
        (0.0, 0.0, 1.2, "doorway 'd': expected Width 1.0, the gap between its walls, got 1.2"),
        (0.0, 180.0, 0.9, "doorway 'd': expected Width 1.0, the gap between its walls, got 0.9"),
        (0.1, 0.0, 1.0, "doorway 'd': expected the middle of the opening, got 0.4 m left and 0.6 m right"),
        (2.0, 0.0, 1.0, "doorway 'd': expected an opening, got the inside of a wall"),
        (0.0, 90.0, 1.0, "doorway 'd': expected a wall within 5.0 m on each side"),
    ],
)
def test_doorway_that_does_not_fit_its_walls_is_found(y: float, heading_deg: float, width: float, text: str) -> None:
    doorway = Doorway(name="d", x=0.0, y=y, heading_deg=heading_deg, width=width)
    assert check_map(floor(wall=GAP, doorway=(doorway,))) == [Finding("Map.Doorway[0]", text)]


def test_opening_between_slanted_walls_is_measured_across_the_passage() -> None:
    document = floor(wall=(line((1, -1), (3, -3)), line((-2, 2), (-3, 3))))
    doorway = Doorway(name="d", x=0.0, y=0.0, heading_deg=45.0, width=1.0)
    assert opening(document, doorway) == pytest.approx((2 * 2**0.5, 2**0.5))


# ---------------------------------------------------------------- robots


def test_robot_file_needs_a_format_and_no_position() -> None:
    assert check_robot(Robot(format="iw.v1", length=1.0, width=0.5, center=0.5)) == []
    document = Robot(length=1.0, width=0.5, center=0.5, position=Position(x=0.0, y=0.0, heading=0.0))
    assert check_robot(document) == [
        Finding("Robot", "expected Format 'iw.v1' in a robot file, got none"),
        Finding("Robot.Position", "expected no Position in a robot file: it is set when an agent joins"),
    ]


# ---------------------------------------------------------------- scenes


PLACES = floor(grid=Grid(position=(Place(name="bed1", x=0.0, y=0.0), Place(name="goal1", x=1.0, y=1.0))))


def scene(*cast: Cast, **fields: object) -> Scene:
    return Scene(format="iw.v1", name="s", map="floor", cast=cast, **fields)  # type: ignore[arg-type]


def test_unknown_place_of_a_scene_is_found_with_the_known_ones() -> None:
    document = scene(Cast(name="a", robot="r", mind="m", place="bed9"))
    assert check_scene(document, PLACES) == [
        Finding(
            "Scene.Cast[0]", "expected one of the places of 'floor' (bed1, goal1), got 'bed9'; did you mean 'bed1'?"
        )
    ]


def test_two_agents_at_one_place_are_found() -> None:
    casts = [Cast(name=name, robot="r", mind="m", place="bed1") for name in ("a", "b")]
    assert check_scene(scene(*casts), PLACES) == [
        Finding("Scene.Cast[1]", "place 'bed1' is already taken by agent 'a'")
    ]


def test_reach_of_an_unknown_place_is_found() -> None:
    end = End(reach=(Reach(agent="a", place="goal9", within=0.3),))
    assert check_scene(scene(Cast(name="a", robot="r", mind="m"), end=end), PLACES) == [
        Finding(
            "Scene.End.Reach[0]",
            "expected one of the places of 'floor' (bed1, goal1), got 'goal9'; did you mean 'goal1'?",
        )
    ]


def test_hold_reached_without_a_reach_is_found() -> None:
    document = scene(hold=Hold(reached="all"))
    assert texts(check_scene(document, PLACES)) == ["Reached: expected a Reach in End, got none"]


def test_wall_with_a_hole_in_its_ring_is_valid() -> None:
    outside, hole = [(0, 0), (10, 0), (10, 10), (0, 10)], [(2, 2), (2, 8), (8, 8), (8, 2)]
    ring = [*outside, outside[0], *hole, hole[0]]
    assert check_map(floor(wall=(Wall(corner=corners(*ring)),))) == []
    assert check_map(floor(wall=(Wall(corner=corners(*ring, ring[0])),))) == []


def test_map_that_no_message_holds_is_found() -> None:
    long = line(*((k / 7.0, (k % 2) / 7.0) for k in range(30_000)))
    (finding,) = check_map(floor(wall=(long,)))
    assert finding.element == "Map"
    assert finding.text.startswith("expected a map of at most 1,044,480 bytes as one message in JSON, got ")


@pytest.mark.parametrize(
    ("places", "text"),
    [
        (("a",), "route 'r': expected at least 2 places, got 1"),
        (("a", "x"), "route 'r': expected places of the map, got 'x'"),
        (("a", "bed"), "route 'r': expected places of the map, got 'bed'; did you mean 'bed1'?"),
        (("a", "bed1"), None),
    ],
)
def test_a_route_goes_between_places_of_the_map(places: tuple[str, ...], text: str | None) -> None:
    grid = Grid(position=(Place(name="a", x=0.0, y=0.0), Place(name="bed1", x=1.0, y=0.0)))
    document = Map(format="iw.v1", name="m", grid=grid, route=(Route(name="r", places=places),))
    assert [(finding.element, finding.text) for finding in check_map(document)] == (
        [] if text is None else [("Map.Route[0]", text)]
    )
