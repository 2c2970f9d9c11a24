"""Building models: the cut above a storey, and what is refused."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Any

import numpy as np
import pytest
import shapely

from intellwheels_maps.importers.ifc_storey import section
from intellwheels_schemas.errors import WireError
from tests.maps.importers.drawn_floors import drawn, read, write_ifc

needs_ifc = pytest.mark.skipif(find_spec("ifcopenshell") is None, reason="needs the extra ifc")


def box(west: float, south: float, east: float, north: float, low: float, high: float) -> tuple[Any, Any]:
    """Return the corners and the triangles of a box."""
    corners = np.array(
        [(x, y, z) for z in (low, high) for x, y in ((west, south), (east, south), (east, north), (west, north))]
    )
    quads = [(0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
    return corners, np.array([triangle for a, b, c, d in quads for triangle in ((a, b, c), (a, c, d))])


def test_a_cut_through_a_box_and_through_a_box_with_a_hole() -> None:
    corners, faces = box(0, 0, 4, 3, 0, 2)
    assert section(corners, faces, 0.6).equals(shapely.box(0, 0, 4, 3))
    assert section(corners, faces, 2.5).is_empty
    inner, more = box(1, 1, 2, 2, 0, 2)
    both = section(np.vstack([corners, inner]), np.vstack([faces, more + 8]), 0.6)
    assert both.area == pytest.approx(11.0)
    # A cut through corners is one just below them.
    assert section(corners, faces, 2.0).area == pytest.approx(12.0)


@needs_ifc
def test_models_that_are_none_are_refused() -> None:
    data = write_ifc(drawn(1))["floor.ifc"]
    for wrong, text in (
        (b"ISO-10303-22;", r"m\.ifc: line 1: expected ISO-10303-21"),
        (data[:-60], r"m\.ifc: expected END-ISO-10303-21 at the end, got a truncated file"),
        (data.replace(b"IFC4", b"IFC9"), r"m\.ifc: expected a model in IFC"),
    ):
        with pytest.raises(WireError, match=text):
            read({"m.ifc": wrong})
    with pytest.raises(WireError, match=r"expected one of the levels \(ground\) after '#', got 'roof'"):
        read({"m.ifc": data}, "roof")


@needs_ifc
def test_a_map_conversion_moves_the_map() -> None:
    import ifcopenshell

    model: Any = ifcopenshell.file.from_string(write_ifc(drawn(0))["floor.ifc"].decode())
    context = model.by_type("IfcGeometricRepresentationContext")[0]
    system = model.create_entity("IfcProjectedCRS", Name="EPSG:3763")
    model.create_entity("IfcMapConversion", context, system, 41000.0, 165000.0, 0.0, 1.0, 0.0)
    offset = read({"m.ifc": model.to_string().encode()}).map.offset
    assert offset is not None
    assert offset.epsg == "EPSG:3763"
    assert (offset.x, offset.y) == pytest.approx((41000.0, 165000.0), abs=60.0)
