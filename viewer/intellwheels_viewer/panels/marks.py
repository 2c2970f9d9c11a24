"""How an agent is told apart: its colour, and a second mark where a colour comes again.

The same mark is in every panel. Colours are few so that everybody tells them apart; the second agent of a colour has a
stripe, the third two, the fourth and later their number.
"""

from __future__ import annotations

import html
from collections.abc import Mapping
from typing import Final, NamedTuple

from intellwheels_viewer.panels.choices import RGB

GREY: Final[RGB] = (150, 158, 167)
"""Of bodies without a colour: tables, doors, obstacles."""


class Mark(NamedTuple):
    """A colour, and how many had it before."""

    colour: RGB = GREY
    repeat: int = 0

    @property
    def css(self) -> str:
        """The colour in CSS."""
        return "#{:02x}{:02x}{:02x}".format(*self.colour)

    @property
    def ink(self) -> str:
        """Black or white, whichever is seen better on the colour (relative luminance of WCAG 2)."""
        red, green, blue = (_linear(channel / 255) for channel in self.colour)
        # Above 0.179 black has the higher contrast: (L + 0.05) / 0.05 > 1.05 / (L + 0.05).
        return "#000" if 0.2126 * red + 0.7152 * green + 0.0722 * blue > 0.179 else "#fff"


def marks(colours: Mapping[str, RGB]) -> dict[str, Mark]:
    """Return the mark of each agent that has a colour."""
    used: dict[RGB, int] = {}
    found = {}
    for name, colour in colours.items():
        found[name] = Mark(colour, used.get(colour, 0))
        used[colour] = used.get(colour, 0) + 1
    return found


def swatch(mark: Mark, title: str = "") -> str:
    """Return a small square of the mark as inline SVG, 13 px across."""
    return (
        '<svg width="13" height="13" viewBox="0 0 13 13" style="flex:none" role="img" '
        f'aria-label="{html.escape(title)}"><rect x=".5" y=".5" width="12" height="12" rx="3" fill="{mark.css}" '
        f'stroke="currentColor" stroke-opacity=".35"/>{_second(mark)}</svg>'
    )


def _second(mark: Mark) -> str:
    if mark.repeat == 0:
        return ""
    if mark.repeat <= 2:
        heights = (6.5,) if mark.repeat == 1 else (4.5, 8.5)
        return "".join(f'<path d="M1 {y}h11" stroke="{mark.ink}" stroke-width="2"/>' for y in heights)
    number = str(mark.repeat + 1)
    return (
        f'<text x="6.5" y="10.5" font-size="11" font-weight="700" text-anchor="middle" fill="{mark.ink}" '
        f'textLength="{min(11, 7 * len(number))}" lengthAdjust="spacingAndGlyphs">{number}</text>'
    )


def _linear(channel: float) -> float:
    """Return the linear value of an sRGB channel in [0, 1] (IEC 61966-2-1)."""
    return channel / 12.92 if channel <= 0.04045 else float(((channel + 0.055) / 1.055) ** 2.4)
