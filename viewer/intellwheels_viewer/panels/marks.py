"""The swatch of an agent in panels: its colour and its stripes, the same as in the scene."""

from __future__ import annotations

import html
from typing import Final, NamedTuple

from intellwheels_schemas.agent_colours import RGB, css

GREY: Final[RGB] = (150, 158, 167)
"""The colour of a body that has no look yet."""


class Mark(NamedTuple):
    """A colour, and the number of stripes that tells agents of this colour apart."""

    colour: RGB = GREY
    stripes: int = 0

    @property
    def css(self) -> str:
        """The colour in CSS."""
        return css(self.colour)

    @property
    def ink(self) -> str:
        """Black or white, whichever has more contrast with the colour (relative luminance of WCAG 2)."""
        red, green, blue = (_linear(channel / 255) for channel in self.colour)
        # Above 0.179 black has the higher contrast: (L + 0.05) / 0.05 > 1.05 / (L + 0.05).
        return "#000" if 0.2126 * red + 0.7152 * green + 0.0722 * blue > 0.179 else "#fff"


def swatch(mark: Mark, title: str = "") -> str:
    """Return the mark as a small square, inline SVG of 13 px."""
    return (
        '<svg width="13" height="13" viewBox="0 0 13 13" style="flex:none" role="img" '
        f'aria-label="{html.escape(title)}"><rect x=".5" y=".5" width="12" height="12" rx="3" fill="{mark.css}" '
        f'stroke="currentColor" stroke-opacity=".35"/>{_stripes(mark)}</svg>'
    )


def _stripes(mark: Mark) -> str:
    heights = {0: (), 1: (6.5,), 2: (4.5, 8.5)}.get(mark.stripes, (3.5, 6.5, 9.5))
    width = 2 if mark.stripes < 3 else 1.4
    return "".join(f'<path d="M1 {y}h11" stroke="{mark.ink}" stroke-width="{width}"/>' for y in heights)


def _linear(channel: float) -> float:
    """Return the linear value of an sRGB channel in [0, 1] (IEC 61966-2-1)."""
    return channel / 12.92 if channel <= 0.04045 else float(((channel + 0.055) / 1.055) ** 2.4)
