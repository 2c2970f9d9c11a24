"""All colours of the page. Pure.

Yellow means "selected" and bright red means "contact", and nothing else uses them. The colour of an agent follows from
its name, see `agent_colours`. A colour is three bytes of sRGB, as browsers and viser take it; `linear` converts it to
linear light.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Final, TypeAlias

import numpy as np
import numpy.typing as npt

from intellwheels_schemas import agent_colours
from intellwheels_schemas.agent_colours import FIXTURES, THING, Look, look_of, looks
from intellwheels_schemas.messages import Body
from intellwheels_schemas.rules import is_mobile

RGB: TypeAlias = agent_colours.RGB
Floats: TypeAlias = npt.NDArray[np.float64]

CONTACT: Final[RGB] = (220, 20, 20)
SELECTED: Final[RGB] = (240, 228, 66)

NEAR: Final[RGB] = (160, 20, 60)
MIDDLE: Final[RGB] = (225, 110, 30)
FAR: Final[RGB] = (120, 160, 190)
NOTHING: Final[RGB] = (188, 196, 204)
FAILED: Final[RGB] = (20, 20, 24)

FLOOR: Final[RGB] = (214, 208, 198)
DARK: Final[RGB] = (68, 72, 80)
METAL: Final[RGB] = (168, 175, 184)


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


def light_bytes(colours: npt.ArrayLike) -> npt.NDArray[np.uint8]:
    """Return sRGB bytes (..., 3) as bytes of linear light, which viser expects for instances and lines."""
    return _LIGHT[np.asarray(colours).astype(np.uint8)]


def linear(colour: Iterable[float]) -> Floats:
    """Return sRGB bytes as linear light, three shares of 1 (IEC 61966-2-1)."""
    share = np.asarray(tuple(colour), dtype=np.float64) / 255.0
    return np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)


_LIGHT: Final[npt.NDArray[np.uint8]] = np.round(linear(range(256)) * 255).astype(np.uint8)
