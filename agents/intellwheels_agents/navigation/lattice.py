"""The lattice of poses on which ways are planned: square cells, and headings that lead exactly to other cells.

A heading is the direction of a vector of whole cells, so a straight move ends on a cell without any rounding. The 32
headings are those of (1, 0), (4, 1), (2, 1), (4, 3) and (1, 1) and their images; neighbours differ by 8 to 15 degrees.

Source: M. Pivtoraiko, R. Knepper, A. Kelly, Differentially constrained mobile robot motion planning in state lattices,
Journal of Field Robotics 26 (2009) 308: motions that connect lattice points exactly.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from intellwheels_agents.navigation.array_angles import Floats
from intellwheels_agents.portable_math import atan2

_OCTANT: Final = ((1, 0), (4, 1), (2, 1), (4, 3))
_QUADRANT: Final = (*_OCTANT, (1, 1), *((j, i) for i, j in reversed(_OCTANT[1:])))
STEPS: Final = tuple(
    vector
    for quarter in range(4)
    for vector in (
        (i, j) if quarter == 0 else (-j, i) if quarter == 1 else (-i, -j) if quarter == 2 else (j, -i)
        for i, j in _QUADRANT
    )
)
"""The move of each heading in cells, anticlockwise from the x axis."""
COUNT: Final = len(STEPS)
ANGLES: Final[Floats] = np.array([atan2(j, i) % math.tau for i, j in STEPS])
"""The headings in [0, 2 pi), ascending."""
LENGTHS: Final[Floats] = np.array([math.sqrt(i * i + j * j) for i, j in STEPS])
"""The length of each heading's move, in cells."""
COSINES: Final[Floats] = np.array([i for i, _ in STEPS]) / LENGTHS
SINES: Final[Floats] = np.array([j for _, j in STEPS]) / LENGTHS
GAPS: Final[Floats] = np.append(ANGLES[1:], math.tau) - ANGLES
"""The angle from each heading to the next, rad."""
