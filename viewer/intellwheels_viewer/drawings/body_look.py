"""The look of a body: three solids in the body frame, and the box around its parts. Pure.

In the body frame x is forward and y is left; the origin is the centre of movement. `paint` has the agent's colour,
`dark` and `light` are the same for all bodies of a kind.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

from intellwheels_schemas.messages import Part
from intellwheels_viewer import palette
from intellwheels_viewer.drawings.solids import Solid, join

CROWD: Final = 40
"""Above this many bodies each is drawn with few triangles."""


@dataclass(frozen=True)
class Extent:
    """The box around all parts of a body, in its frame, in metres."""

    rear: float
    front: float
    right: float
    left: float
    bottom: float
    top: float

    @property
    def length(self) -> float:
        """Its size along x."""
        return self.front - self.rear

    @property
    def width(self) -> float:
        """Its size along y."""
        return self.left - self.right

    @property
    def middle(self) -> tuple[float, float]:
        """The middle of its footprint."""
        return (self.rear + self.front) / 2, (self.right + self.left) / 2


@dataclass(frozen=True, eq=False)
class Leg:
    """A leg that swings about the hip.

    Attributes:
        solid: The leg, hanging from the hip at the origin.
        hips: Where the left and the right one are, in the body frame, in metres.
        rgb: Its colour.
    """

    solid: Solid
    hips: tuple[tuple[float, float, float], tuple[float, float, float]]
    rgb: palette.RGB


@dataclass(frozen=True, eq=False)
class BodyLook:
    """A body's look.

    Attributes:
        paint, dark, light: Its solids.
        dark_rgb, light_rgb: The colours of the latter two.
        more: Further solids by their own colours.
        leg: A leg that moves with the gait; None for a body without one.
        stripe: Where the stripes are that tell agents of one colour apart: x and z of the first, and its width. The
            others follow towards the back.
    """

    paint: Solid
    dark: Solid = field(default_factory=Solid)
    light: Solid = field(default_factory=Solid)
    dark_rgb: palette.RGB = palette.DARK
    light_rgb: palette.RGB = palette.METAL
    more: Mapping[palette.RGB, Solid] = field(default_factory=dict)
    leg: Leg | None = None
    stripe: tuple[float, float, float] = (0.0, 1.0, 0.3)

    @property
    def trim(self) -> dict[palette.RGB, Solid]:
        """All that does not have the agent's colour, by colour, without legs that move."""
        made = {**self.more}
        for rgb, solid in ((self.dark_rgb, self.dark), (self.light_rgb, self.light)):
            made[rgb] = made[rgb] + solid if rgb in made else solid
        return {rgb: solid for rgb, solid in made.items() if len(solid.faces)}

    @property
    def whole(self) -> Solid:
        """The body in one solid, standing."""
        legs = [] if self.leg is None else [self.leg.solid.moved(*hip) for hip in self.leg.hips]
        return join([self.paint, *self.trim.values(), *legs])

    @property
    def triangles(self) -> int:
        """The total number of triangles."""
        return len(self.whole.faces)


def extent(parts: Sequence[Part]) -> Extent:
    """Return the box around parts; without parts, a point at the centre of movement."""
    if not parts:
        return Extent(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    return Extent(
        rear=min(part.x - part.length / 2 for part in parts),
        front=max(part.x + part.length / 2 for part in parts),
        right=min(part.y - part.width / 2 for part in parts),
        left=max(part.y + part.width / 2 for part in parts),
        bottom=min(part.bottom for part in parts),
        top=max(part.top for part in parts),
    )
