"""What is painted on the floor lies in one order, none of it high enough to be seen as a step."""

from __future__ import annotations

from itertools import pairwise

from intellwheels_viewer.drawings import floor_heights

FROM_BELOW = tuple(
    getattr(floor_heights, name)
    for name in (
        [
            "FLOOR",
            "ZONE",
            "PAINT",
            "DOORWAY",
            "SHADE",
            "LETTERS",
            "TRAIL",
            "GOAL",
            "RING",
            "FOOTPRINT",
            "OUTLINE",
            "WEDGE",
            "ARC",
        ]
    )
)


def test_layers_are_two_millimetres_apart_or_more() -> None:
    assert all(above - below > 0.0019 for below, above in pairwise(FROM_BELOW))


def test_the_highest_is_lower_than_the_lowest_thing_that_stands_there() -> None:
    assert FROM_BELOW[-1] < 0.1 < floor_heights.HALF_HEIGHT
