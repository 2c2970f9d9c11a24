"""What an importer adds becomes a valid map, or is left out with its place."""

from __future__ import annotations

import pytest

from intellwheels_maps.check import check_map
from intellwheels_maps.importers.floor_draft import FloorDraft, Leaf, word
from intellwheels_maps.importers.floor_source import FloorSource
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Door

SOURCE = FloorSource("my floor.yaml", b"", lambda _: b"")


def draft() -> FloorDraft:
    found = FloorDraft(SOURCE)
    found.wall([(0.0, 0.0), (4.0, 0.0)], "w1", thickness=0.1)
    found.wall([(5.0, 0.0), (9.0, 0.0)], "w2", thickness=0.1)
    return found


def test_a_doorway_is_as_wide_as_the_gap_where_it_is_drawn() -> None:
    found = draft()
    found.door("d", "door 1", Leaf((4.1, 0.0), (4.9, 0.0), Door(side="right")))
    document = found.finish().map
    (doorway,) = document.doorway
    assert (doorway.x, doorway.y, doorway.width, doorway.heading_deg) == (4.5, 0.0, 1.0, 90.0)
    assert doorway.door == Door(side="right")
    assert check_map(document) == []


@pytest.mark.parametrize(
    ("left", "right", "reason"),
    [
        ((1.0, 0.0), (2.0, 0.0), "doorway whose middle is inside a wall"),
        ((4.0, 3.0), (5.0, 3.0), "doorway without a wall on each side"),
        ((4.4, 0.0), (4.6, 0.0), "door that does not fit its opening"),
    ],
)
def test_a_door_that_fits_no_opening_is_left_out(
    left: tuple[float, float], right: tuple[float, float], reason: str
) -> None:
    found = draft()
    found.door("d", "door 1", Leaf(left, right, None))
    done = found.finish()
    assert done.map.doorway == ()
    sizes = ", 0.20 m in 1.00 m" if "fit" in reason else ""
    assert done.left_out == (f"door 1{sizes}: {reason}",)


def test_what_is_no_shape_is_left_out() -> None:
    found = draft()
    found.wall([(0.0, 0.0), (2.0, 2.0), (2.0, 0.0), (0.0, 3.0)], "bow tie")
    found.wall([(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)], "flat")
    found.wall([(1.0, 5.0), (1.0, 5.00001)], "dot", thickness=0.1)
    found.place("p", (1.0, 0.0), "place 1")
    found.route(("p", "p"), one_way=True)
    done = found.finish()
    assert check_map(done.map) == []
    assert len(done.map.wall) == 2
    assert done.left_out == (
        "bow tie: outline that crosses or touches itself",
        "flat: outline without an area",
        "dot: wall without a length",
        "place 1: place inside a wall",
        "p - p: route to a place that is left out",
    )


def test_what_is_left_out_has_a_line_for_each_reason() -> None:
    found = draft()
    for number in range(1050):
        found.leave_out(f"models[{number}]", "models are not in the map")
    found.leave_out("lift 1", "lift without a place")
    found.leave_out("layer 'A'", "LINE, not known", 3)
    found.leave_out("layer 'B'", "LINE, not known")
    found.leave_out("IfcPump", "product that is no part of a floor", 2000)
    done = found.finish()
    models = "; ".join(f"models[{number}]" for number in range(8))
    assert done.left_out == (
        f"models are not in the map: 1,050 ({models}; 1,042 more)",
        "lift 1: lift without a place",
        "LINE, not known: 4 (layer 'A': 3; layer 'B')",
        "IfcPump: product that is no part of a floor: 2,000",
    )
    assert done.things == 1050 + 1 + 4 + 2000


def test_names_become_different_words() -> None:
    found = draft()
    names = [found.place(name, (1.0, 2.0), "p") for name in ("Büro 1", "Büro 1", "", "___", "x" * 90)]
    assert names == ["B-ro-1", "B-ro-1-2", "place", "place-2", "x" * 64]
    assert found.finish().map.name == "my-floor"
    assert word("A/B c") == "A-B-c"


def test_numbers_that_are_far_away_become_small() -> None:
    found = FloorDraft(SOURCE)
    found.wall([(600000.25, 4500000.0), (600004.0, 4500000.0)], "w", thickness=0.1)
    document = found.finish(epsg="EPSG:32629").map
    assert document.offset is not None
    assert (document.offset.x, document.offset.y, document.offset.epsg) == (600000.0, 4500000.0, "EPSG:32629")
    assert document.wall[0].corner[0].x == 0.25


def test_a_map_of_the_wrong_size_is_refused() -> None:
    for length, text in ((20_000.0, "at most 9,000 m across"), (0.2, "at least 0.5 m across")):
        found = FloorDraft(SOURCE)
        found.wall([(0.0, 0.0), (length, 0.0)], "w", thickness=0.1)
        with pytest.raises(WireError, match=text):
            found.finish()
    with pytest.raises(WireError, match="w: expected coordinates within 100,000 km, got inf 0"):
        FloorDraft(SOURCE).wall([(float("inf"), 0.0)], "w")


def test_more_corners_than_a_map_can_have_are_refused() -> None:
    found = draft()
    found.wall([(number / 100, 5.0 + number % 2) for number in range(60_000)], "w", thickness=0.1)
    with pytest.raises(WireError, match="expected walls and obstacles of at most 60,000 corners, got 60,004"):
        found.finish()


def test_doors_and_places_among_many_walls_are_refused_before_they_are_fitted() -> None:
    found = draft()
    for number in range(2000):
        found.wall([(float(number), 5.0), (number + 0.5, 5.0)], "w", thickness=0.1)
        found.door("d", f"door {number}", Leaf((number + 0.5, 5.0), (number + 1.0, 5.0), None))
    with pytest.raises(WireError, match="expected fewer doors and places, got 2,000 doors and 0 places among walls"):
        found.finish()
