"""The badge of a real chair: a plate that says REAL, on its back and flat on the floor behind it. Pure.

On the plate of a real chair's bridge with simulated hardware is STAND-IN. Both have a white band around the back as
well. A virtual chair has neither, and its footprint has dashes.
"""

from __future__ import annotations

from typing import Final, TypeAlias

import numpy as np

from intellwheels_viewer.drawings import floor_heights
from intellwheels_viewer.drawings.body_look import Extent
from intellwheels_viewer.drawings.furniture import Painted
from intellwheels_viewer.drawings.solids import Solid, join, sheet
from intellwheels_viewer.drivers import Reality
from intellwheels_viewer.palette import RGB

PLATE: Final[RGB] = (20, 24, 32)
LETTERS: Final[RGB] = (255, 255, 255)
WORDS: Final[dict[Reality, str]] = {"real": "REAL", "stand-in": "STAND-IN", "simulated": ""}
WIDTHS: Final[dict[str, float]] = {"REAL": 0.50, "STAND-IN": 0.72}
"""Width of the plate on the floor by its word, in metres."""
GAP: Final = 0.05
"""Metres between the footprint and the plate behind it."""

_Strokes: TypeAlias = tuple[tuple[float, float, float, float], ...]
# Each letter as bars (left, right, lower, upper) in a box 3 wide and 5 high.
_BARS: Final[dict[str, _Strokes]] = {
    "R": ((0, 1, 0, 5), (1, 3, 4, 5), (2, 3, 2.9, 4), (1, 3, 2, 2.9), (2, 3, 0, 2)),
    "E": ((0, 1, 0, 5), (1, 3, 4, 5), (1, 2.6, 2, 3), (1, 3, 0, 1)),
    "A": ((0, 1, 0, 5), (2, 3, 0, 5), (1, 2, 4, 5), (1, 2, 1.8, 2.7)),
    "L": ((0, 1, 0, 5), (1, 3, 0, 1)),
    "S": ((0, 3, 0, 1), (2, 3, 1, 2), (0, 3, 2, 3), (0, 1, 3, 4), (0, 3, 4, 5)),
    "T": ((0, 3, 4, 5), (1, 2, 0, 4)),
    "N": ((0, 1, 0, 5), (2, 3, 0, 5), (1, 1.5, 2.6, 4.2), (1.5, 2, 0.8, 2.4)),
    "D": ((0, 1, 0, 5), (1, 2.3, 0, 1), (1, 2.3, 4, 5), (2, 3, 0.8, 4.2)),
    "I": ((1, 2, 0, 5),),
    "-": ((0.5, 2.5, 2, 3),),
}
_PITCH: Final = 4.0


def _aspect(word: str) -> float:
    """Return the width over the height of a plate, with a margin of one unit around the letters."""
    return (len(word) * _PITCH - 1 + 2) / 7


def plate(word: str) -> Painted:
    """Return the plate in the plane z = 0, 1 m wide, its middle at the origin, to be read along x from below."""
    high = 1.0 / _aspect(word)
    unit = high / 7
    back = sheet([(-0.5, -high / 2), (0.5, -high / 2), (0.5, high / 2), (-0.5, high / 2)], 0.0)
    letters = []
    for place, letter in enumerate(word):
        x = -0.5 + unit * (1 + _PITCH * place)
        y = -high / 2 + unit
        for left, right, low, up in _BARS[letter]:
            corners = [(x + unit * a, y + unit * b) for a, b in ((left, low), (right, low), (right, up), (left, up))]
            letters.append(sheet(corners, 0.0))
    return {PLATE: back, LETTERS: join(letters)}


def on_floor(hull: Extent, word: str) -> Painted:
    """Return the plate on the floor behind a footprint, to be read from behind the chair."""
    y = hull.middle[1]
    lifts = {PLATE: floor_heights.FOOTPRINT, LETTERS: floor_heights.OUTLINE}
    made, width = {}, WIDTHS[word]
    for rgb, flat in plate(word).items():
        # What was along x runs to the right of the chair, and up is ahead.
        turned = flat.vertices[:, [1, 0, 2]] * np.array([width, -width, 1.0], np.float32)
        behind = hull.rear - GAP - width / _aspect(word) / 2
        made[rgb] = Solid(turned.astype(np.float32), flat.faces).moved(behind, y, lifts[rgb])
    return made


def upright(x: float, z: float, width: float, word: str) -> Painted:
    """Return the plate on the rear of a back, in the plane across at x, its middle at z, to be read from behind."""
    made = {}
    for depth, (rgb, flat) in enumerate(plate(word).items()):
        vertices = np.column_stack(
            [
                np.full(len(flat.vertices), x - 0.002 * depth),
                -flat.vertices[:, 0] * width,
                z + flat.vertices[:, 1] * width,
            ]
        )
        made[rgb] = Solid(vertices.astype(np.float32), flat.faces)
    return made


def legend() -> str:
    """Return HTML that says how real chairs, stand-ins, virtual and stale ones are told apart."""
    frame = '<rect x="2" y="3" width="40" height="16" fill="none" stroke="currentColor" stroke-width="2.5"'
    plate = (
        '<rect x="4" y="6" width="36" height="10" fill="#141820"/>'
        '<text x="22" y="14" font-size="{}" font-weight="700" text-anchor="middle" fill="#fff">{}</text>'
    )
    rows = (
        ("real", f"{frame}/>{plate.format(8, 'REAL')}", "real: solid frame, plate, white band"),
        ("stand-in", f"{frame}/>{plate.format(6.5, 'STAND-IN')}", "stand-in: the same, but its hardware is simulated"),
        ("virtual", f'{frame} stroke-dasharray="5 4"/>', "virtual: dashed frame"),
        ("stale", f'{frame} opacity="0.35"/>', "faded: no news of a real one"),
    )
    cells = "".join(
        f'<tr data-reality="{name}"><td style="width:46px;padding:1px 8px 1px 0;border:0;text-align:left">'
        f'<svg width="44" height="22" viewBox="0 0 44 22" style="display:block">{shape}</svg></td>'
        f'<td style="padding:1px 0;border:0;text-align:left">{words}</td></tr>'
        for name, shape, words in rows
    )
    return f'<table style="border-collapse:collapse;font-size:13px;line-height:1.4">{cells}</table>'
