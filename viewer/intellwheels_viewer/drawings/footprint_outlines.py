"""The footprint of a body on the floor: its outline with a heading mark, its centre of movement, and a tint.

The footprint turns red in a contact. Pure; `bodies` makes the nodes.
"""

from __future__ import annotations

from typing import Final

from intellwheels_viewer.drawings import floor_heights
from intellwheels_viewer.drawings.body_look import Extent
from intellwheels_viewer.drawings.solids import Solid, band, join, sheet

LINE: Final = 0.035
"""Width of the outline, in metres."""

_MARK: Final = 0.20
_DASH: Final = 0.09


def outline(hull: Extent, *, dashed: bool = False) -> Solid:
    """Return the outline of a footprint, inside its edge, with the marks of heading and centre.

    Args:
        hull: The box around the body.
        dashed: Whether it is interrupted, as that of a virtual body.
    """
    x0, x1, y0, y1, line = hull.rear, hull.front, hull.right, hull.left, LINE
    middle = (y0 + y1) / 2
    strips = [
        [(x0, y0), (x1, y0), (x1, y0 + line), (x0, y0 + line)],
        [(x0, y1 - line), (x1, y1 - line), (x1, y1), (x0, y1)],
        [(x0, y0), (x0 + line, y0), (x0 + line, y1), (x0, y1)],
        [(x1 - line, y0), (x1, y0), (x1, y1), (x1 - line, y1)],
    ]
    if dashed:
        strips = [dash for strip in strips for dash in _dashes(strip)]
    wide = min(_MARK, 0.8 * hull.width)
    heading = [(x1 + 0.03, middle - wide / 2), (x1 + 0.03 + 0.7 * wide, middle), (x1 + 0.03, middle + wide / 2)]
    flat = [sheet(polygon, floor_heights.OUTLINE) for polygon in (*strips, heading)]
    return join([*flat, centre()])


def _dashes(strip: list[tuple[float, float]]) -> list[list[tuple[float, float]]]:
    """Return the dashes of a strip along x or y; there is one at each end."""
    (x0, y0), _, (x1, y1), _ = strip
    along = x1 - x0 > y1 - y0
    length = (x1 - x0) if along else (y1 - y0)
    count = max(1, round((length / _DASH + 1) / 2))
    each = length / (2 * count - 1)
    spans = [(2 * index * each, (2 * index + 1) * each) for index in range(count)]
    ends = [(x0 + a, x0 + b, y0, y1) if along else (x0, x1, y0 + a, y0 + b) for a, b in spans]
    return [[(a, c), (b, c), (b, d), (a, d)] for a, b, c, d in ends]


def centre() -> Solid:
    """Return the mark of the centre of movement: a ring with a point."""
    return band(0.065, 0.085, floor_heights.OUTLINE, sides=24) + band(0.0, 0.025, floor_heights.OUTLINE, sides=16)


def tint() -> Solid:
    """Return a square of one metre, which is scaled to a footprint."""
    return sheet([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)], floor_heights.FOOTPRINT)
