"""How well two colours can be told apart, in the common colour vision and in three others."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final, Literal, TypeAlias

import numpy as np

from intellwheels_viewer.palette import RGB, Floats, linear

Sight: TypeAlias = Literal["common", "protan", "deutan", "tritan"]

# Machado, Oliveira and Fernandes, "A Physiologically-based Model for Simulation of Color Vision Deficiency",
# IEEE TVCG 15 (6), 2009: the matrices of severity 1.0, for linear RGB.
_SIGHTS: Final[Mapping[Sight, Floats]] = {
    "common": np.eye(3),
    "protan": np.array(
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]
    ),
    "deutan": np.array(
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
    ),
    "tritan": np.array(
        [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]]
    ),
}
# IEC 61966-2-1: linear sRGB to XYZ, and its white, D65.
_TO_XYZ: Final[Floats] = np.array(
    [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]]
)
_WHITE: Final[Floats] = np.array([0.95047, 1.0, 1.08883])


def difference(one: RGB, other: RGB, sight: Sight = "common") -> float:
    """Return the CIE76 difference of two colours, their distance in CIELAB; about 2.3 is just noticeable."""
    return float(np.linalg.norm(_lab(one, sight) - _lab(other, sight)))


def _lab(colour: RGB, sight: Sight) -> Floats:
    ratio = _TO_XYZ @ np.clip(_SIGHTS[sight] @ linear(colour), 0.0, 1.0) / _WHITE
    cube = np.where(ratio > 216 / 24389, np.cbrt(ratio), (24389 / 27 * ratio + 16) / 116)
    return np.array([116 * cube[1] - 16, 500 * (cube[0] - cube[1]), 200 * (cube[1] - cube[2])])
