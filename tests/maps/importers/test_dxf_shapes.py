"""Blocks cannot cost more than their bounds: loops, copies and bombs are refused with their place."""

from __future__ import annotations

import pytest

from intellwheels_maps.importers import dxf_shapes
from intellwheels_schemas.errors import WireError
from tests.maps.importers.test_dxf_plan import drawing, imported


def test_a_block_in_itself_is_refused() -> None:
    document = drawing()
    one, two = document.blocks.new("one"), document.blocks.new("two")
    one.add_blockref("two", (1, 0))
    two.add_blockref("one", (1, 0))
    document.modelspace().add_blockref("one", (0, 0), dxfattribs={"layer": "wall"})
    with pytest.raises(WireError, match=r"plan\.dxf: INSERT .*: expected blocks that do not contain themselves"):
        imported(document)


def test_blocks_that_double_at_each_level_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(dxf_shapes, "MAX_SHAPES", 2000)  # the real bound takes seconds
    document = drawing()
    document.blocks.new("b0").add_line((0, 0), (1, 0))
    for level in range(1, 15):
        block = document.blocks.new(f"b{level}")
        for _ in range(8):
            block.add_blockref(f"b{level - 1}", (1, 0))
    document.modelspace().add_blockref("b14", (0, 0), dxfattribs={"layer": "wall"})
    with pytest.raises(WireError, match="expected at most 2,000 entities, blocks expanded"):
        imported(document)


def test_a_deep_chain_of_blocks_is_refused() -> None:
    document = drawing()
    document.blocks.new("b0").add_line((0, 0), (1, 0))
    for level in range(1, 40):
        document.blocks.new(f"b{level}").add_blockref(f"b{level - 1}", (1, 0))
    document.modelspace().add_blockref("b39", (0, 0), dxfattribs={"layer": "wall"})
    with pytest.raises(WireError, match="expected at most 16 blocks in one another, got more"):
        imported(document)


def test_a_million_copies_of_a_block_are_refused() -> None:
    document = drawing()
    document.blocks.new("b").add_line((0, 0), (1, 0))
    given = {"layer": "wall", "row_count": 30_000, "column_count": 30_000, "row_spacing": 1, "column_spacing": 1}
    document.modelspace().add_blockref("b", (0, 0), dxfattribs=given)
    with pytest.raises(WireError, match="got 900,000,000 copies of a block"):
        imported(document)


def test_curves_of_all_kinds_are_lines() -> None:
    document = drawing()
    space = document.modelspace()
    wall = {"layer": "wall"}
    space.add_circle((5, 5), 1.0, dxfattribs=wall)
    space.add_ellipse((9, 5), (1, 0), 0.5, dxfattribs=wall)
    space.add_spline([(0, 0), (1, 1), (2, 0)], dxfattribs=wall)
    space.add_polyline2d([(0, 3), (3, 3), (3, 4)], dxfattribs=wall)
    space.add_solid([(0, 8), (1, 8), (0, 8.5), (1, 8.5)], dxfattribs=wall)
    found = imported(document)
    assert found.left_out == ()
    assert len(found.map.wall) >= 5
