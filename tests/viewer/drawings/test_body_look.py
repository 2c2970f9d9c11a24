from __future__ import annotations

from intellwheels_schemas.messages import Part
from intellwheels_viewer.drawings.body_look import BodyLook, Extent, extent
from intellwheels_viewer.drawings.solids import box


def test_the_box_around_parts_has_its_middle_and_its_size() -> None:
    hull = extent(
        (
            Part(x=0.0, y=0.0, length=1.0, width=0.5, bottom=0.0, top=0.5),
            Part(x=1.0, y=0.5, length=1.0, width=0.5, bottom=0.5, top=1.5),
        )
    )
    assert hull == Extent(-0.5, 1.5, -0.25, 0.75, 0.0, 1.5)
    assert (hull.length, hull.width, hull.middle) == (2.0, 1.0, (0.5, 0.25))


def test_of_no_parts_it_is_a_point() -> None:
    assert extent(()).length == 0.0


def test_a_model_counts_the_triangles_of_all_its_solids() -> None:
    cube = box(0.0, 1.0, 0.0, 1.0, 0.0, 1.0)
    assert BodyLook(paint=cube, light=cube).triangles == 24
