"""Generates a map of a hospital that is large enough to benchmark the simulator.

It has 140 x 60 m, three corridors along x and two across, 120 rooms with doors 1.4 m wide, about 500 walls, and nine
places in each room. Equal seeds give equal maps. Rooms differ in the position of the door, and some have a screen.
"""

from __future__ import annotations

import random
from typing import Final

from intellwheels_schemas.codec import VERSION
from intellwheels_schemas.messages import Corner, Doorway, Grid, Map, Place, Wall, Zone

LENGTH: Final = 140.0
"""Length along x between the centre lines of the outer walls, m."""
WIDTH: Final = 60.0
"""Width along y between the centre lines of the outer walls, m."""
DOOR_WIDTH: Final = 1.4
"""Clear width of every door, m."""
ROOM_LENGTH: Final = 6.7
"""Length of a room along x between the centre lines of its walls, m."""
ROOM_DEPTH: Final = 8.5
"""Depth of a room along y between the centre lines of its walls, m."""
CORRIDOR: Final = 3.0
"""Width of a corridor between the centre lines of its walls, m; the clear width is 0.1 m less."""

_THICKNESS = 0.1
# Rooms of a row, divided by the two cross corridors: 7 + 6 + 7 rooms and twice 3 m make 140 m.
_GROUPS = (7, 6, 7)
# Two of three rooms have a screen, so there are about 500 walls in total.
_SCREEN_SHARE = 2 / 3
# Three by three places in a room, 1 m from the walls and 2.2 m apart: a chair of 1.2 x 0.7 m can turn at each.
_PLACE_X = (1.15, 3.35, 5.55)
_PLACE_Y = (1.5, 4.2, 6.9)


def hospital(seed: int = 1) -> Map:
    """Return the map of a hospital for a seed.

    Args:
        seed: Any integer; equal seeds give equal maps.
    """
    generator = random.Random(seed)  # noqa: S311 - not used for secrets
    walls = [_wall((0.0, 0.0), (LENGTH, 0.0), (LENGTH, WIDTH), (0.0, WIDTH), (0.0, 0.0))]
    doorways: list[Doorway] = []
    zones: list[Zone] = []
    places: list[Place] = []
    number = 0
    for row in range(6):
        # Each pair of rows shares a corridor. It is north of the even row and south of the odd row.
        south = (row // 2) * (2 * ROOM_DEPTH + CORRIDOR) + (row % 2) * (ROOM_DEPTH + CORRIDOR)
        north = south + ROOM_DEPTH
        door_side, back_side = (north, south) if row % 2 == 0 else (south, north)
        west = 0.0
        for group in _GROUPS:
            if west > 0.0:
                walls.append(_wall((west, south), (west, north)))
            for _ in range(group):
                number += 1
                name, east = f"room{number:03}", west + ROOM_LENGTH
                door = west + 1.2 + round(generator.random() * (ROOM_LENGTH - 2.4), 1)
                walls.append(_wall((west, door_side), (door - DOOR_WIDTH / 2, door_side)))
                walls.append(_wall((door + DOOR_WIDTH / 2, door_side), (east, door_side)))
                if _rounded(east) < LENGTH:
                    walls.append(_wall((east, south), (east, north)))
                if row in (1, 3):
                    # Back wall, shared with the row behind it; the first and the last row end at the outer walls.
                    walls.append(_wall((west, back_side), (east, back_side)))
                if generator.random() < _SCREEN_SHARE:
                    # The screen is between two rows of places, so that both stay free.
                    depth = south + (_PLACE_Y[0] + _PLACE_Y[1]) / 2
                    walls.append(_wall((west, depth), (west + 1.2, depth)))
                doorways.append(_doorway(name, door, door_side, -90.0 if row % 2 == 0 else 90.0))
                zones.append(_zone(name, f"Room {number}", west, south, east, north))
                places += [
                    _place(f"{name}-{index}", west + x, south + y, 30.0 * int(generator.random() * 12) - 180.0)
                    for index, (x, y) in enumerate(((x, y) for y in _PLACE_Y for x in _PLACE_X), 1)
                ]
                west = east
            west += CORRIDOR
    return Map(
        format=VERSION,
        name="hospital",
        title=f"Hospital of 120 rooms, seed {seed}",
        source="made by intellwheels_maps.hospital",
        wall=tuple(walls),
        doorway=tuple(doorways),
        zone=tuple(zones),
        grid=Grid(position=tuple(places)),
    )


def _rounded(value: float) -> float:
    # The coordinates are sums of tenths; rounding removes the floating-point error.
    return round(value, 4)


def _corners(*points: tuple[float, float]) -> tuple[Corner, ...]:
    return tuple(Corner(x=_rounded(x), y=_rounded(y)) for x, y in points)


def _wall(*points: tuple[float, float]) -> Wall:
    return Wall(thickness=_THICKNESS, corner=_corners(*points))


def _doorway(name: str, x: float, y: float, heading_deg: float) -> Doorway:
    return Doorway(name=name, x=_rounded(x), y=_rounded(y), heading_deg=heading_deg, width=DOOR_WIDTH)


def _zone(name: str, title: str, west: float, south: float, east: float, north: float) -> Zone:
    corners = _corners((west, south), (east, south), (east, north), (west, north))
    return Zone(name=name, title=title, corner=corners)


def _place(name: str, x: float, y: float, heading_deg: float) -> Place:
    return Place(name=name, x=_rounded(x), y=_rounded(y), heading_deg=heading_deg, kinds=("wheelchair", "person"))
