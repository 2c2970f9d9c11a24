from __future__ import annotations

import pytest
import shapely
from shapely.geometry import LineString, Point, box

from intellwheels_maps.check import check_map
from intellwheels_maps.hospital import hospital


def test_hospital_has_the_size_that_the_bench_names() -> None:
    document = hospital()
    xs = [corner.x for wall in document.wall for corner in wall.corner]
    ys = [corner.y for wall in document.wall for corner in wall.corner]
    assert (min(xs), min(ys), max(xs), max(ys)) == (0.0, 0.0, 140.0, 60.0)
    assert len(document.zone) == 120
    assert len(document.doorway) == 120
    assert {doorway.width for doorway in document.doorway} == {1.4}
    assert 450 <= len(document.wall) <= 550


def test_hospital_passes_the_checks_of_a_floor() -> None:
    assert check_map(hospital()) == []


def test_hospital_depends_on_the_seed_alone() -> None:
    assert hospital(7) == hospital(7)
    assert hospital(7).wall != hospital(8).wall


def test_thousand_bodies_find_a_place_at_any_heading() -> None:
    document = hospital()
    assert document.grid
    walls = shapely.STRtree(
        [
            LineString([(corner.x, corner.y) for corner in wall.corner]).buffer(0.05, cap_style="flat")
            for wall in document.wall
            if wall.thickness is not None
        ]
    )
    places = [Point(place.x, place.y) for place in document.grid.position]
    assert len(places) >= 1000
    # A body of 1.2 x 0.7 m reaches 0.695 m from its middle.
    assert len(walls.query(places, predicate="dwithin", distance=0.7)[0]) == 0
    one, other = shapely.STRtree(places).query(places, predicate="dwithin", distance=1.4)
    assert all(one == other)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_every_room_can_be_reached_from_the_first_corridor(seed: int) -> None:
    document = hospital(seed)
    assert document.grid
    walls = shapely.union_all(
        [
            LineString([(corner.x, corner.y) for corner in wall.corner]).buffer(0.05 + 0.36, cap_style="flat")
            for wall in document.wall
        ]
    )
    ground = shapely.get_parts(box(0, 0, 140, 60).difference(walls))
    [home] = [island for island in ground if island.contains(Point(70, 10))]
    shapely.prepare(home)
    assert all(home.contains(Point(place.x, place.y)) for place in document.grid.position)
