import math

import pytest

from intellwheels_schemas.errors import RequestRefusedError
from intellwheels_schemas.messages import Map, Place, Position, Robot
from intellwheels_server.world.body_set import body_model_of
from intellwheels_server.world.map_geometry import walls_of
from intellwheels_server.world.placement import OccupiedSpace, place, places_for, position_of
from intellwheels_server.world.state import Setup
from tests.server.worlds import box_wall, cart, floor_of

PLACES = (
    Place(name="bed", x=0.0, y=0.0, kinds=("bed",)),
    Place(name="first", x=5.0, y=0.0, kinds=("wheelchair", "person")),
    Place(name="second", x=8.0, y=0.0, heading_deg=90.0),
)


def put(robot: Robot, floor: Map, space: OccupiedSpace | None = None, reserved: tuple[str, ...] = ()) -> Position:
    model = body_model_of("a", robot, Setup(floor=floor))
    return place(model, floor, space or OccupiedSpace(walls_of(floor), floor), reserved)


def space_with(floor: Map, *positions: tuple[float, float]) -> OccupiedSpace:
    space = OccupiedSpace(walls_of(floor), floor)
    for k, (x, y) in enumerate(positions):
        space.add(f"b{k}", body_model_of(f"b{k}", cart(), Setup(floor=floor)), x, y, 0.0)
    return space


def test_place_comes_before_position_and_position_before_the_first_free() -> None:
    floor = floor_of((), PLACES)
    assert put(cart(1.0, 1.0, place="second"), floor) == Position(x=8.0, y=0.0, heading=math.pi / 2)
    assert put(cart(1.0, 1.0), floor) == Position(x=1.0, y=1.0, heading=0.0)
    assert put(cart(position=None), floor) == Position(x=5.0, y=0.0, heading=0.0)


def test_first_free_place_is_one_for_the_kind_where_nobody_stands() -> None:
    floor = floor_of((), PLACES)
    space = space_with(floor, (5.5, 0.2))
    assert put(cart(position=None), floor, space).x == 8.0
    space = space_with(floor, (5.5, 0.2), (8.0, 0.0))
    with pytest.raises(RequestRefusedError) as refusal:
        put(cart(position=None), floor, space)
    assert refusal.value.code == "no-place"
    assert "no free place for a wheelchair on map 'test'" in refusal.value.text


def test_place_in_the_sweep_of_a_door_is_the_last_to_be_given_away() -> None:
    floor = floor_of((), PLACES)
    space = OccupiedSpace(walls_of(floor), floor)
    # A leaf of 1 m whose hinge is 1.2 m beside the place `first`: it stands along x, and may turn towards the place.
    leaf = cart(kind="door", anchored=True, length=1.0, width=0.1, center=1.0)
    model = body_model_of("door", leaf, Setup(floor=floor))
    space.add("door", model, 5.0, 1.2, math.pi)
    assert put(cart(place="first"), floor, space).x == 5.0
    assert put(cart(position=None), floor, space).x == 8.0
    space.add("b", body_model_of("b", cart(), Setup(floor=floor)), 8.0, 0.0, 0.0)
    assert put(cart(position=None), floor, space).x == 5.0
    space.remove("b")
    space.remove("door")
    assert put(cart(position=None), floor, space).x == 5.0


def test_place_that_is_kept_for_another_body_is_not_given_away() -> None:
    near = Place(name="near", x=5.3, y=0.0, kinds=("wheelchair",))
    floor = floor_of((), (PLACES[1], near, PLACES[2]))
    assert put(cart(position=None), floor, reserved=("first",)).x == 8.0  # at `near` it would be in the way
    with pytest.raises(RequestRefusedError) as refusal:
        put(cart(position=None), floor, reserved=("first", "second", "gone"))
    assert refusal.value.code == "no-place"
    assert refusal.value.text == (
        "no free place for a wheelchair on map 'test' besides those kept for other agents (first, second): "
        "give a place or a position (Robot.Place or Robot.Position; --place or --position of iw-agent)"
    )


def test_body_that_asks_for_a_kept_place_or_the_space_of_one_is_refused() -> None:
    floor = floor_of((), PLACES)
    for robot in (cart(place="first"), cart(5.2, 0.1)):
        with pytest.raises(RequestRefusedError) as refusal:
            put(robot, floor, reserved=("first",))
        words = "agent 'a' would be in the way at place 'first', which is kept for another agent"
        assert (refusal.value.code, refusal.value.text) == ("overlaps", words)
    assert put(cart(5.2, 0.1, type="real"), floor, reserved=("first",)).x == 5.2
    assert put(cart(place="second"), floor, reserved=("first",)).x == 8.0


def test_unknown_place_is_refused_with_the_places_there_are() -> None:
    with pytest.raises(RequestRefusedError) as refusal:
        put(cart(place="third"), floor_of((), PLACES))
    assert refusal.value.text == "no place 'third' on map 'test': expected one of bed, first, second"


def test_occupied_place_is_refused_with_the_name_of_the_occupant() -> None:
    floor = floor_of([box_wall(0.2, -1.0, 1.0, 1.0)], PLACES)
    for robot, words in [
        (cart(place="first"), "agent 'a' would overlap agent 'b0' at place 'first'"),
        (cart(), "agent 'a' would overlap wall 1 at its position"),
    ]:
        with pytest.raises(RequestRefusedError) as refusal:
            put(robot, floor, space_with(floor, (5.5, 0.2)))
        assert (refusal.value.code, refusal.value.text) == ("overlaps", words)


def test_touching_is_not_overlapping() -> None:
    floor = floor_of([box_wall(0.5, -1.0, 1.0, 1.0)])
    assert put(cart(), floor, space_with(floor, (-1.0, 0.0))).x == 0.0


def test_real_chair_is_where_it_is() -> None:
    floor = floor_of([box_wall(0.2, -1.0, 1.0, 1.0)])
    assert put(cart(type="real"), floor).x == 0.0


def test_heading_asked_for_is_brought_into_its_range() -> None:
    assert put(cart(heading=6.0), floor_of()).heading == pytest.approx(6.0 - 2 * math.pi, abs=1e-15)
    assert put(cart(heading=-math.pi), floor_of()).heading == math.pi


def test_places_without_kinds_are_for_any() -> None:
    assert [spot.name for spot in places_for(floor_of((), PLACES), "table")] == ["second"]


@pytest.mark.parametrize(
    ("degrees", "heading"), [(-180.0, math.pi), (270.0, -math.pi / 2), (360.0, 0.0), (45.0, math.pi / 4)]
)
def test_heading_of_a_place_is_in_its_range(degrees: float, heading: float) -> None:
    assert position_of(Place(name="p", x=0.0, y=0.0, heading_deg=degrees)).heading == pytest.approx(heading, abs=1e-15)


def test_depth_is_that_of_the_deepest_thing() -> None:
    floor = floor_of([box_wall(0.4, -1.0, 1.4, 1.0)])
    space = space_with(floor, (0.0, 0.0), (-0.7, 0.0))
    assert space.depth_at("b0") == pytest.approx(0.3, abs=1e-12)
    assert space.overlap_of("b0") == "agent 'b1'"
    space.remove("b1")
    assert space.depth_at("b0") == pytest.approx(0.1, abs=1e-12)
    assert space.overlap_of("b0") == "wall 1"
