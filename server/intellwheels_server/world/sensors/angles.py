"""Angles of sensors: unit vectors, exact for quarter turns, and headings as they are written."""

from __future__ import annotations

import math

from intellwheels_server.world.kernels.elementary import sincos

_QUARTERS = {0.0: (1.0, 0.0), 90.0: (0.0, 1.0), 180.0: (-1.0, 0.0), 270.0: (0.0, -1.0)}


def unit_vector(degrees: float) -> tuple[float, float]:
    """Return cosine and sine of an angle in degrees, exact for quarter turns."""
    quarter = _QUARTERS.get(degrees % 360.0)
    if quarter is not None:
        return quarter
    sine, cosine = sincos(math.radians(degrees))
    return cosine, sine


def written_heading(rounded: float) -> float:
    """Return a heading that was rounded to 1e-6, moved back to (-pi, pi] if rounding took it out."""
    return rounded if -math.pi < rounded <= math.pi else math.pi
