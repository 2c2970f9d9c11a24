"""Procedural pictures of floors and ceilings, 256 by 256 pixels, that repeat without a seam. Pure.

A picture is near white in the mean, so that the colour of a material is that of its surface: a lighter or darker floor
of the same kind needs no other picture.
"""

from __future__ import annotations

import functools
import io
from collections.abc import Callable
from typing import Final, Literal, TypeAlias

import numpy as np
import numpy.typing as npt
from PIL import Image

Texture = Literal["tiles", "small-tiles", "wood", "carpet", "asphalt", "paving", "panels"]
Grey: TypeAlias = npt.NDArray[np.float64]

SIZE: Final = 256
METRES: Final[dict[Texture, float]] = {
    "tiles": 1.2, "small-tiles": 0.6, "wood": 1.6, "carpet": 1.0, "asphalt": 2.0, "paving": 1.6, "panels": 1.2,
}  # fmt: skip
"""The length of floor that one picture covers."""
_QUALITY: Final = 80


@functools.cache
def picture(texture: Texture) -> bytes:
    """Return a texture as a JPEG file of grey pixels. It is the same on every machine."""
    grey = np.clip(_MADE[texture](np.random.default_rng(7)), 0.0, 1.0)
    file = io.BytesIO()
    Image.fromarray(np.round(grey * 255).astype(np.uint8)).save(file, "JPEG", quality=_QUALITY)
    return file.getvalue()


def _smooth(random: np.random.Generator, waves: int) -> Grey:
    """Return noise in [-1, 1] with at most so many waves along each side; it repeats."""
    size = 2 * waves + 1
    spectrum = np.zeros((SIZE, SIZE), complex)
    drawn = random.normal(size=(size, size)) + 1j * random.normal(size=(size, size))
    where = np.arange(-waves, waves + 1)
    spectrum[np.ix_(where, where)] = drawn
    noise = np.fft.ifft2(spectrum).real
    scaled: Grey = noise / np.abs(noise).max()
    return scaled


def _joints(count: int, wide: int, depth: float, random: np.random.Generator, spread: float) -> Grey:
    """Return squares with dark joints, each square a little lighter or darker than the next."""
    each = SIZE // count
    at = np.arange(SIZE)
    grey = np.ones((SIZE, SIZE)) + np.kron(random.uniform(-spread, spread, (count, count)), np.ones((each, each)))
    joint = at % each < wide
    grey[joint, :] -= depth
    grey[:, joint] = np.minimum(grey[:, joint], 1.0 - depth)
    edge = (at % each == wide) | (at % each == each - 1)
    grey[edge, :] -= depth / 4
    grey[:, edge] -= depth / 4
    return grey


def _tiles(random: np.random.Generator) -> Grey:
    return 0.96 * _joints(2, 3, 0.20, random, 0.018) + 0.02 * _smooth(random, 24)


def _small_tiles(random: np.random.Generator) -> Grey:
    return 0.96 * _joints(4, 4, 0.24, random, 0.03)


def _wood(random: np.random.Generator) -> Grey:
    """Return eight rows of planks along x, their ends staggered."""
    rows = 8
    each = SIZE // rows
    grey = np.ones((SIZE, SIZE))
    grain = _smooth(random, 30)
    x = np.arange(SIZE)
    for row in range(rows):
        lines = slice(row * each, (row + 1) * each)
        start = int(random.integers(SIZE))
        first = ((x - start) % SIZE) < SIZE // 2
        one, other = random.uniform(-0.09, 0.05, 2)
        grey[lines] += np.where(first, one, other)
        # Grain is long in the direction of the plank.
        stripe = np.repeat(grain[lines, ::8], 8, axis=1)
        grey[lines] += 0.045 * np.roll(stripe, start, axis=1)
        grey[row * each] -= 0.20
        grey[lines, start] -= 0.18
        grey[lines, (start + SIZE // 2) % SIZE] -= 0.18
    return 0.94 * grey


def _carpet(random: np.random.Generator) -> Grey:
    y, x = np.mgrid[0:SIZE, 0:SIZE]
    weave = 0.03 * (((x // 4) + (y // 4)) % 2)
    noise: Grey = 0.035 * random.normal(size=(SIZE, SIZE)) + 0.035 * _smooth(random, 6)
    grey: Grey = 0.92 + weave + noise
    return grey


def _asphalt(random: np.random.Generator) -> Grey:
    return 0.90 + 0.06 * random.normal(size=(SIZE, SIZE)) + 0.05 * _smooth(random, 5)


def _paving(random: np.random.Generator) -> Grey:
    """Return slabs in courses, every second one offset by half."""
    grey = _joints(4, 3, 0.22, random, 0.03)
    for row in (1, 3):
        band = slice(row * 64, (row + 1) * 64)
        grey[band] = np.roll(grey[band], 32, axis=1)
    return 0.95 * grey + 0.02 * random.normal(size=(SIZE, SIZE))


def _panels(random: np.random.Generator) -> Grey:
    return 0.98 * _joints(2, 3, 0.16, random, 0.008)


_MADE: Final[dict[Texture, Callable[[np.random.Generator], Grey]]] = {
    "tiles": _tiles, "small-tiles": _small_tiles, "wood": _wood, "carpet": _carpet, "asphalt": _asphalt,
    "paving": _paving, "panels": _panels,
}  # fmt: skip
