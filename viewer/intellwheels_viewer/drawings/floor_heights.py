"""Heights of flat drawings on the floor, in metres: far enough apart not to flicker in the plan's narrow view."""

from __future__ import annotations

from typing import Final

FLOOR: Final = 0.0
ZONE: Final = 0.004
PAINT: Final = 0.006
DOORWAY: Final = 0.008
SHADE: Final = 0.010
LETTERS: Final = 0.012
TRAIL: Final = 0.014
GOAL: Final = 0.016
RING: Final = 0.018
FOOTPRINT: Final = 0.022
OUTLINE: Final = 0.026
WEDGE: Final = 0.034
ARC: Final = 0.052

HALF_HEIGHT: Final = 1.1
"""Height at which walls and doors are cut, in metres, so that what is behind them stays visible."""
