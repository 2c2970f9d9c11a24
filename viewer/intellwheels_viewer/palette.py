"""All colours of the page, and how well they can be told apart. Pure.

Yellow means "selected" and bright red means "contact", and nothing else uses them. The colour of an agent follows from
its name, see `agent_colours`. A colour is three bytes of sRGB, as browsers and viser take it; `linear` converts it to
linear light.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Final, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from intellwheels_schemas import agent_colours
from intellwheels_schemas.agent_colours import FIXTURES, THING, Look, css, look_of, looks
from intellwheels_schemas.messages import Body
from intellwheels_schemas.rules import is_mobile

RGB: TypeAlias = agent_colours.RGB
Floats: TypeAlias = npt.NDArray[np.float64]
Sight: TypeAlias = Literal["common", "protan", "deutan", "tritan"]

CONTACT: Final[RGB] = (220, 20, 20)
SELECTED: Final[RGB] = (240, 228, 66)

NEAR: Final[RGB] = (160, 20, 60)
MIDDLE: Final[RGB] = (225, 110, 30)
FAR: Final[RGB] = (120, 160, 190)
NOTHING: Final[RGB] = (188, 196, 204)
FAILED: Final[RGB] = (20, 20, 24)

FLOOR: Final[RGB] = (250, 251, 253)
GRID: Final[RGB] = (228, 231, 236)
ZONES: Final[tuple[RGB, ...]] = ((246, 250, 255), (255, 251, 243), (245, 254, 248), (253, 247, 255))
LETTERS: Final[RGB] = (150, 160, 172)
DOORWAY: Final[RGB] = (150, 198, 190)
WALL: Final[RGB] = (246, 247, 250)
CAP: Final[RGB] = (84, 97, 116)
DARK: Final[RGB] = (68, 72, 80)
METAL: Final[RGB] = (168, 175, 184)

ON_WHITE: Final[RGB] = (255, 255, 255)
ON_DARK: Final[RGB] = (26, 27, 30)
"""Backgrounds of viser's panels in the light and the dark theme."""

READABLE: Final = 4.5
"""Minimum contrast of text: WCAG 2.2, success criterion 1.4.3."""

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


class Colours:
    """The looks of the bodies of a run: those of `agent_colours`, by name.

    Bodies that do not drive by themselves, such as doors and tables, have the colour of their kind.
    """

    def __init__(self) -> None:
        self._looks: Mapping[str, Look] = {}
        self._fixtures: dict[str, RGB] = {}
        self._known: Mapping[str, Body] = {}

    def see(self, bodies: Mapping[str, Body]) -> None:
        """Take the bodies that are in the run now."""
        if bodies == self._known:
            return
        self._known = dict(bodies)
        mobile = {name for name, body in bodies.items() if is_mobile(body.robot)}
        self._looks = looks(mobile)
        self._fixtures = {
            name: FIXTURES.get(body.robot.kind, THING) for name, body in bodies.items() if name not in mobile
        }

    def look(self, name: str) -> Look:
        """Return the look of a body; that of its name if it is not in the run."""
        fixture = self._fixtures.get(name)
        return self._looks.get(name) or look_of(name) if fixture is None else Look(fixture, 0)

    def rgb(self, name: str) -> RGB:
        """Return the colour of a body."""
        return self.look(name).colour

    def mark(self, name: str) -> int:
        """Return the number of stripes of a body."""
        return self.look(name).stripes

    def text(self, name: str, *, dark: bool = False) -> str:
        """Return the colour of a body for text, as `#rrggbb`, readable on the light or the dark panel."""
        return css(text_safe(self.rgb(name), dark=dark))


def light_bytes(colours: npt.ArrayLike) -> npt.NDArray[np.uint8]:
    """Return sRGB bytes (..., 3) as bytes of linear light, which viser expects for instances and lines."""
    return _LIGHT[np.asarray(colours).astype(np.uint8)]


def linear(colour: Iterable[float]) -> Floats:
    """Return sRGB bytes as linear light, three shares of 1 (IEC 61966-2-1)."""
    share = np.asarray(tuple(colour), dtype=np.float64) / 255.0
    return np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)


def encoded(light: Floats) -> RGB:
    """Return linear light as sRGB bytes; the inverse of `linear`."""
    share = np.clip(light, 0.0, 1.0)
    value = np.where(share <= 0.0031308, share * 12.92, 1.055 * share ** (1 / 2.4) - 0.055)
    red, green, blue = (round(float(channel) * 255.0) for channel in value)
    return red, green, blue


def contrast(one: RGB, other: RGB) -> float:
    """Return the contrast ratio of two colours, 1 to 21 (WCAG 2.2)."""
    low, high = sorted(float(_TO_XYZ[1] @ linear(colour)) for colour in (one, other))
    return (high + 0.05) / (low + 0.05)


def text_safe(colour: RGB, *, dark: bool = False) -> RGB:
    """Return a colour moved towards black, or white on a dark background, until text in it has enough contrast."""
    ground, end = (ON_DARK, 1.0) if dark else (ON_WHITE, 0.0)
    light = linear(colour)
    for step in range(101):
        candidate = encoded(light + (end - light) * step / 100)
        if contrast(candidate, ground) >= READABLE:
            break
    return candidate


def seen_by(colour: RGB, sight: Sight) -> Floats:
    """Return the linear light, three shares of 1, in which the given colour vision perceives a colour."""
    return np.clip(_SIGHTS[sight] @ linear(colour), 0.0, 1.0)


def difference(one: RGB, other: RGB, sight: Sight = "common") -> float:
    """Return the CIE76 difference of two colours, their distance in CIELAB; about 2.3 is just noticeable."""
    return float(np.linalg.norm(_lab(seen_by(one, sight)) - _lab(seen_by(other, sight))))


def _lab(light: Floats) -> Floats:
    ratio = _TO_XYZ @ light / _WHITE
    cube = np.where(ratio > 216 / 24389, np.cbrt(ratio), (24389 / 27 * ratio + 16) / 116)
    return np.array([116 * cube[1] - 16, 500 * (cube[0] - cube[1]), 200 * (cube[1] - cube[2])])


_LIGHT: Final[npt.NDArray[np.uint8]] = np.round(linear(range(256)) * 255).astype(np.uint8)
