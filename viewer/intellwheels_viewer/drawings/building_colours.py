"""The colours of a building by day and by night. Pure.

Floors, walls and the ground outside differ in lightness in both. By night the building is dark, and the tops of its
walls are light, so that the plan stands out. Bodies have the same colours in both.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Literal

from intellwheels_viewer.palette import RGB

Material = Literal["tiles", "small-tiles", "wood", "carpet", "asphalt", "paving"]


@dataclass(frozen=True)
class BuildingColours:
    """The colours of a building, sRGB.

    Attributes:
        floors: The mean colour of each material.
        outside: The ground around the building.
        wall, dado, rail, skirting: A wall above, below, the rail between the two, and the board at its foot.
        masonry: A wall outdoors.
        cap: The top of a wall.
        frame: The frames of doors and windows, and thresholds.
        glass: Windows.
        letters: The names of rooms on the floor.
        plate, sign_letters: The signs beside doors.
        ceiling, lamp: What is overhead.
        kerb, road_line: The edge of a street, and what is painted on it.
        shade: Opacity of the shade at the foot of a wall, in [0, 255].
        furniture: Share of the daylight that furniture has, in (0, 1].
    """

    floors: Mapping[Material, RGB]
    outside: RGB
    wall: RGB
    dado: RGB
    rail: RGB
    skirting: RGB
    masonry: RGB
    cap: RGB
    frame: RGB
    glass: RGB
    letters: RGB
    plate: RGB
    sign_letters: RGB
    ceiling: RGB
    lamp: RGB
    kerb: RGB
    road_line: RGB
    shade: int
    furniture: float


DAY: Final = BuildingColours(
    floors={
        "tiles": (224, 228, 232), "small-tiles": (196, 222, 226), "wood": (226, 196, 158), "carpet": (198, 202, 186),
        "asphalt": (124, 127, 133), "paving": (212, 208, 200),
    },
    outside=(176, 186, 178), wall=(248, 247, 243), dado=(206, 218, 216), rail=(164, 132, 98), skirting=(112, 104, 98),
    masonry=(196, 168, 146), cap=(70, 82, 100), frame=(146, 106, 72), glass=(150, 196, 226), letters=(74, 82, 94),
    plate=(30, 62, 96), sign_letters=(255, 255, 255), ceiling=(240, 241, 242), lamp=(255, 253, 244),
    kerb=(232, 230, 224), road_line=(246, 246, 242), shade=84, furniture=1.0,
)  # fmt: skip
NIGHT: Final = BuildingColours(
    floors={
        "tiles": (104, 111, 121), "small-tiles": (88, 113, 120), "wood": (124, 103, 82), "carpet": (100, 104, 93),
        "asphalt": (62, 64, 69), "paving": (96, 95, 91),
    },
    outside=(21, 23, 26), wall=(120, 126, 136), dado=(92, 104, 108), rail=(92, 74, 56), skirting=(48, 46, 46),
    masonry=(100, 86, 76), cap=(164, 174, 190), frame=(108, 80, 56), glass=(58, 92, 124), letters=(170, 178, 190),
    plate=(24, 50, 80), sign_letters=(226, 232, 240), ceiling=(108, 112, 118), lamp=(255, 246, 220),
    kerb=(140, 140, 136), road_line=(176, 176, 170), shade=110, furniture=0.62,
)  # fmt: skip


def colours_of(*, dark: bool) -> BuildingColours:
    """Return the colours of a theme."""
    return NIGHT if dark else DAY


def dimmed(rgb: RGB, share: float) -> RGB:
    """Return a colour with a share of its brightness."""
    red, green, blue = (round(value * share) for value in rgb)
    return red, green, blue
