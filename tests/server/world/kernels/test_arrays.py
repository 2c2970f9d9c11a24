"""Bodies as arrays: radii of the presets, keys, and what is no body."""

import numpy as np
import pytest

from intellwheels_server.world.kernels.arrays import (
    ANCHORED,
    EXTERNALLY_POSED,
    HIGHEST,
    KEY,
    LOWEST,
    RADIUS,
    THICKNESS,
    Box,
    Shape,
    bodies_from,
    key_of,
    part_rows,
    radius_of,
    reordered,
)


@pytest.mark.parametrize(
    ("length", "width", "centre", "radius"),
    [(1.10, 0.62, 0.227, 0.905), (1.15, 0.655, 0.5, 0.662), (1.10, 0.655, 0.72, 0.857), (1.20, 0.66, 0.42, 0.770)],
)
def test_turning_radius_is_the_farthest_corner(length: float, width: float, centre: float, radius: float) -> None:
    # MODEL.md, Bodies: rear-wheel, mid-wheel and front-wheel chair, the present IntellWheels chair.
    box = Box(length * (0.5 - centre), 0.0, length, width, 0.0, 1.3)
    assert radius_of([box]) == pytest.approx(radius, abs=6e-4)


def test_bodies_follow_one_another_in_the_arrays() -> None:
    leg = Box(0.5, -0.3, 0.05, 0.06, 0.0, 0.69)
    bodies = bodies_from(
        [
            Shape("table", [Box(0.0, 0.0, 1.2, 0.8, 0.69, 0.72), leg]),
            Shape("chair1", [Box(0.25, 0.0, 1.2, 0.66, 0.1, 1.3)], externally_posed=True, anchored=True),
        ]
    )
    assert bodies.parts.tolist() == [
        [0.0, 0.0, 0.6, 0.4, 0.69, 0.72],
        [0.5, -0.3, 0.025, 0.03, 0.0, 0.69],
        [0.25, 0.0, 0.6, 0.33, 0.1, 1.3],
    ]
    assert bodies.part_start.tolist() == [0, 2, 3]
    assert bodies.shape[LOWEST].tolist() == [0.0, 0.1]
    assert bodies.shape[HIGHEST].tolist() == [0.72, 1.3]
    assert bodies.shape[THICKNESS].tolist() == [0.05, 0.66]
    assert bodies.shape[RADIUS, 1] == radius_of([Box(0.25, 0.0, 1.2, 0.66, 0.1, 1.3)])
    assert bodies.marks[[EXTERNALLY_POSED, ANCHORED]].tolist() == [[0, 1], [0, 1]]
    assert bodies.marks[KEY].tolist() == [key_of("table"), key_of("chair1")]


def test_key_is_53_bits_of_the_name() -> None:
    assert key_of("chair1") == key_of("chair1")
    assert len({key_of(f"chair{k}") for k in range(1000)}) == 1000
    assert all(0 <= key_of(f"chair{k}") < 1 << 53 for k in range(1000))


def test_no_bodies_are_empty_blocks() -> None:
    bodies = bodies_from([])
    assert (bodies.parts.shape, bodies.part_start.tolist()) == ((0, 6), [0])
    assert (bodies.shape.shape, bodies.marks.shape) == ((4, 0), (3, 0))
    assert part_rows([]).shape == (0, 6)


def test_body_without_extent_is_refused_in_words() -> None:
    with pytest.raises(ValueError, match=r"^body 'ghost': expected at least 1 part, got 0$"):
        bodies_from([Shape("ghost", [])])
    with pytest.raises(ValueError, match=r"^body 'flat': expected parts with length, width and height, got "):
        bodies_from([Shape("flat", [Box(0.0, 0.0, 1.0, 0.0, 0.0, 1.0)])])


def test_bodies_of_two_blocks_in_another_order_are_as_compiled_in_that_order() -> None:
    leg = Box(0.5, -0.3, 0.05, 0.06, 0.0, 0.69)
    a = Shape("a", [Box(0.25, 0.0, 1.2, 0.66, 0.1, 1.3)], externally_posed=True)
    b = Shape("b", [leg, Box(0.0, 0.0, 1.2, 0.8, 0.69, 0.72), leg], anchored=True)
    c = Shape("c", [leg, leg])
    empty = bodies_from([])
    for first, second, order in (([c, a], [b], [a, b, c]), ([a, b, c], [], [c, a]), ([], [b], [b]), ([a], [], [])):
        both = [*first, *second]
        columns = np.array([both.index(shape) for shape in order], dtype=np.int64)
        found = reordered(bodies_from(first), bodies_from(second), columns)
        for block, expected in zip(found, bodies_from(order), strict=True):
            assert (block.dtype, block.shape) == (expected.dtype, expected.shape)
            assert np.array_equal(block, expected)
            assert block.flags.c_contiguous
    assert reordered(empty, empty, np.empty(0, dtype=np.int64)).part_start.tolist() == [0]
