"""Text as pictures for the floor, with a transparent background. Pure."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw, ImageFont

from intellwheels_viewer.palette import RGB

Picture: TypeAlias = npt.NDArray[np.uint8]

_PIXELS = 96
"""Height of a line in pixels: sharp if a name of half a metre fills a twentieth of the screen."""


def written(text: str, colour: RGB) -> Picture:
    """Return one line of text as (height, width, 4) bytes, as wide as the text.

    The font comes with Pillow, so a page looks the same on every machine.
    """
    font = ImageFont.load_default(_PIXELS * 0.72)
    line = " ".join(text.split()) or " "
    left, _, right, _ = font.getbbox(line)
    image = Image.new("RGBA", (max(1, round(right - left)) + 8, _PIXELS), (*colour, 0))
    ImageDraw.Draw(image).text((4 - left, _PIXELS / 2), line, font=font, fill=(*colour, 255), anchor="lm")
    return np.asarray(image)
