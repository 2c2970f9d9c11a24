"""Unit vectors of angles in degrees, exact for quarter turns: a sensor at 90 degrees looks exactly to the side."""

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
