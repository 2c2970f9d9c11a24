"""The sun. Seen from far it casts no shadows.

Viser draws shadows in the first 20 m before a camera only, in three maps that each surface looks up. From farther away
some bodies of a picture would have a shadow and others none, at half of the cost of the whole picture.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    import viser

    from intellwheels_viewer.drawings.label_layout import Picture

NAME: Final = "/lights/sun"
FAR: Final = 20.0
"""Metres from a camera to what it looks at, above which there are no shadows: viser's reach."""
NEAR: Final = 18.0
"""Metres below which there are shadows again, so that a camera at the limit does not switch them to and fro."""


def add_sun(scene: viser.SceneApi, *, shadows: bool) -> viser.DirectionalLightHandle:
    """Add the sun to a scene, with or without shadows; its light is the same."""
    return scene.add_light_directional(NAME, intensity=1.2, position=(-6.0, -9.0, 16.0), cast_shadow=shadows)


def has_shadows(picture: Picture, *, had: bool) -> bool:
    """Return whether a camera sees shadows.

    Args:
        picture: The camera.
        had: Whether it saw them before.
    """
    return math.dist(picture.position, picture.look_at) <= (FAR if had else NEAR)


class OwnSun:
    """The sun of one browser, which hides the shared one from when it first looks from far.

    Args:
        scene: The browser's scene.
    """

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self._node: viser.DirectionalLightHandle | None = None
        self._shadows = True

    def show(self, picture: Picture | None) -> None:
        """Show it for a camera; it stays as it is while the camera is not known."""
        shadows = self._shadows if picture is None else has_shadows(picture, had=self._shadows)
        if shadows == self._shadows:
            return
        self._shadows = shadows
        if self._node is None:
            self._node = add_sun(self._scene, shadows=shadows)
        else:
            self._node.cast_shadow = shadows
