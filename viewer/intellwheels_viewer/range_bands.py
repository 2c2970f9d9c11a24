"""The bands of a range: near, middle and far. Wedges, lidar points, panels and plots all use them. Pure."""

from __future__ import annotations

from typing import Final

NEAR: Final = 0.5
"""Below this range, in metres, an obstacle is near: a chair at 1 m/s reaches it in half a second."""
MIDDLE: Final = 1.5
"""Below this range, in metres, it is in the middle band; beyond, it is far."""
