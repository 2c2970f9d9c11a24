"""Text as pictures for floors and signs, with a transparent background. Pure."""

from __future__ import annotations

import functools
import io
from collections.abc import Sequence
from typing import Final, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw, ImageFont

from intellwheels_viewer.palette import RGB

Picture: TypeAlias = npt.NDArray[np.uint8]

PIXELS: Final = 96
"""Height of a line in pixels: sharp if a name of half a metre fills a twentieth of the screen."""
_TALLEST: Final = 4096
"""Height of a picture of many lines in pixels that every browser takes."""


class Line(NamedTuple):
    """A line in a picture: its width over its height, and its edges as shares of the picture from the upper left."""

    aspect: float
    right: float
    top: float
    bottom: float


def written(text: str, colour: RGB, pixels: int = PIXELS) -> Picture:
    """Return one line of text as (height, width, 4) bytes, as wide as the text.

    The font comes with Pillow, so a page looks the same on every machine.
    """
    font = ImageFont.load_default(pixels * 0.72)
    line = " ".join(text.split()) or " "
    left, _, right, _ = font.getbbox(line)
    image = Image.new("RGBA", (max(1, round(right - left)) + 8, pixels), (*colour, 0))
    ImageDraw.Draw(image).text((4 - left, pixels / 2), line, font=font, fill=(*colour, 255), anchor="lm")
    return np.asarray(image)


@functools.lru_cache(16)
def atlas(texts: Sequence[str], colour: RGB) -> tuple[bytes, tuple[Line, ...]]:
    """Return all texts in one PNG file, one below the other, and where each is.

    Args:
        texts: A tuple of lines; with many of them the letters have fewer pixels.
        colour: Of the letters.
    """
    pixels = max(12, min(PIXELS, _TALLEST // max(1, len(texts))))
    lines = [written(text, colour, pixels) for text in texts]
    width, height = max(line.shape[1] for line in lines), pixels * len(lines)
    sheet = np.zeros((height, width, 4), np.uint8)
    sheet[:, :, :3] = colour
    for row, line in enumerate(lines):
        sheet[row * pixels : (row + 1) * pixels, : line.shape[1]] = line
    file = io.BytesIO()
    Image.fromarray(sheet).save(file, "PNG", optimize=True)
    places = tuple(
        Line(line.shape[1] / pixels, line.shape[1] / width, row / len(lines), (row + 1) / len(lines))
        for row, line in enumerate(lines)
    )
    return file.getvalue(), places
