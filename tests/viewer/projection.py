"""What of a scene is in a picture."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from intellwheels_viewer.cameras import View


def in_picture(view: View, points: npt.ArrayLike, aspect: float) -> npt.NDArray[np.bool_]:
    """Return which points, (n, 3) in metres, are in a picture of so many times its height in width, (n,)."""
    ahead = (view.look_at - view.position) / np.linalg.norm(view.look_at - view.position)
    right = np.cross(ahead, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    away, tall = np.asarray(points, np.float64) - view.position, math.tan(view.fov / 2)
    depth = away @ ahead
    reach = np.maximum(depth, 0.0) * tall
    seen: npt.NDArray[np.bool_] = (np.abs(away @ right) < reach * aspect) & (
        np.abs(away @ np.cross(right, ahead)) < reach
    )
    return seen
