"""A body as circles in a row: how far it is from points, at one pose or at every pose of a piece of the lattice."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from intellwheels_agents.navigation.array_angles import Floats
from intellwheels_agents.navigation.footprint_clearance import Box, Frame
from intellwheels_agents.navigation.lattice import COSINES, SINES
from intellwheels_agents.portable_math import sincos

Pose = tuple[float, float, float]


class BodyCircles:
    """Circles that cover the middle line of a body.

    Attributes:
        side: Half the width of the body, m: the radius of the circles.
    """

    def __init__(self, boxes: list[Box]) -> None:
        """Take the parts of the body."""
        front, back = max(box.front for box in boxes), min(box.back for box in boxes)
        self.side = max(max(box.left, -box.right) for box in boxes)
        first, last = min(back + self.side, front), max(front - self.side, back)
        count = max(2, 1 + int((last - first) / (0.7 * self.side) + 0.999)) if last > first else 1
        self._ahead = [first + (last - first) * n / max(count - 1, 1) for n in range(count)]

    def middles(self, pose: Pose) -> Floats:
        """Return the middles of the circles at a pose, rows x, y, m."""
        s, c = sincos(pose[2])
        ahead = np.array(self._ahead)
        return np.stack([pose[0] + c * ahead, pose[1] + s * ahead], axis=1)

    def gap(self, pose: Pose, points: Floats) -> float:
        """Return the distance between the body at a pose and the nearest of some points, m; infinite without any."""
        if not points.shape[0]:
            return float("inf")
        middles = self.middles(pose)
        dx, dy = points[:, 0][None, :] - middles[:, :1], points[:, 1][None, :] - middles[:, 1:]
        return float(np.sqrt((dx * dx + dy * dy).min())) - self.side

    def gaps(self, off: Floats, frame: Frame, heading: int) -> Floats:
        """Return the distance between the body and the nearest point for each cell at a heading of the lattice, m.

        Args:
            off: The distance of each cell's middle to the nearest point, m.
            frame: The size of a cell.
            heading: The number of the heading.
        """
        edge = int(max(abs(ahead) for ahead in self._ahead) / frame.cell) + 1
        rows, columns = off.shape
        padded = np.pad(off, edge, mode="edge")
        nearest: npt.NDArray[np.float64] | None = None
        for ahead in self._ahead:
            i, j = round(COSINES[heading] * ahead / frame.cell), round(SINES[heading] * ahead / frame.cell)
            part = padded[edge + j : edge + j + rows, edge + i : edge + i + columns]
            nearest = part if nearest is None else np.minimum(nearest, part)
        assert nearest is not None  # noqa: S101 - a body has a circle
        return nearest - self.side
