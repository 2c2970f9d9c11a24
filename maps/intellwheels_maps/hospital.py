"""A hospital floor made from a seed: big enough to measure the simulator on.

140 x 60 m: three corridors along x and two across, 120 rooms with doors of 1.4 m, about 500 walls, nine places
a room. The same seed makes the same floor; rooms differ in where the door is and whether a screen stands inside.
"""

from __future__ import annotations

import random
from typing import Final

from intellwheels_schemas.messages import Corner, Doorway, Grid, Map, Place, Wall, Zone

LENGTH: Final = 140.0
"""Along x, in m, between the centre lines of the outer walls."""
WIDTH: Final = 60.0
"""Along y, in m, likewise."""
DOOR_WIDTH: Final = 1.4
"""Clear width of every room's door, in m."""
ROOM_LENGTH: Final = 6.7
ROOM_DEPTH: Final = 8.5
CORRIDOR: Final = 3.0
"""From centre line to centre line of the walls, in m; 0.1 m less is clear."""

_THICKNESS = 0.1
# Rooms of a row between the ends and the two cross corridors: 7 + 6 + 7 rooms and twice 3 m are 140 m.
_GROUPS = (7, 6, 7)
# Two of three rooms have a screen, which brings the walls to about 500.
_SCREEN_SHARE = 2 / 3
# Three by three places a room leave 1 m to the walls and 2.2 m to each other: a chair of 1.2 x 0.7 m turns on each.
_PLACE_X = (1.15, 3.35, 5.55)
_PLACE_Y = (1.5, 4.2, 6.9)


def hospital(seed: int = 1) -> Map:
    """Return the floor of a seed.

    Args:
        seed: Any integer; equal seeds give equal floors.
    """
    # Not for secrets: a floor to measure on.
    chance = random.Random(seed)  # noqa: S311
    walls = [_wall((0.0, 0.0), (LENGTH, 0.0), (LENGTH, WIDTH), (0.0, WIDTH), (0.0, 0.0))]
    doorways: list[Doorway] = []
    zones: list[Zone] = []
    places: list[Place] = []
    number = 0
    for row in range(6):
        # Rows lie in pairs about a corridor; even rows have it to their north, odd rows to their south.
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
                door = west + 1.2 + round(chance.random() * (ROOM_LENGTH - 2.4), 1)
                walls.append(_wall((west, door_side), (door - DOOR_WIDTH / 2, door_side)))
                walls.append(_wall((door + DOOR_WIDTH / 2, door_side), (east, door_side)))
                if _near(east) < LENGTH:
                    walls.append(_wall((east, south), (east, north)))
                if row in (1, 3):
                    # A back wall is shared with the row behind; those of the first and last row are outer walls.
                    walls.append(_wall((west, back_side), (east, back_side)))
                if chance.random() < _SCREEN_SHARE:
                    # Between two rows of places, so that those stay free.
                    depth = south + (_PLACE_Y[0] + _PLACE_Y[1]) / 2
                    walls.append(_wall((west, depth), (west + 1.2, depth)))
                doorways.append(_doorway(name, door, door_side, -90.0 if row % 2 == 0 else 90.0))
                zones.append(_zone(name, f"Room {number}", west, south, east, north))
                places += [
                    _place(f"{name}-{index}", west + x, south + y, 30.0 * int(chance.random() * 12) - 180.0)
                    for index, (x, y) in enumerate(((x, y) for y in _PLACE_Y for x in _PLACE_X), 1)
                ]
                west = east
            west += CORRIDOR
    return Map(
        format="iw.v1",
        name="hospital",
        title=f"Hospital of 120 rooms, seed {seed}",
        source="made by intellwheels_maps.hospital",
        wall=tuple(walls),
        doorway=tuple(doorways),
        zone=tuple(zones),
        grid=Grid(position=tuple(places)),
    )


def _near(value: float) -> float:
    # Sums of tenths, written with few digits.
    return round(value, 4)


def _corners(*points: tuple[float, float]) -> tuple[Corner, ...]:
    return tuple(Corner(x=_near(x), y=_near(y)) for x, y in points)


def _wall(*points: tuple[float, float]) -> Wall:
    return Wall(thickness=_THICKNESS, corner=_corners(*points))


def _doorway(name: str, x: float, y: float, heading_deg: float) -> Doorway:
    return Doorway(name=name, x=_near(x), y=_near(y), heading_deg=heading_deg, width=DOOR_WIDTH)


def _zone(name: str, title: str, west: float, south: float, east: float, north: float) -> Zone:
    corners = _corners((west, south), (east, south), (east, north), (west, north))
    return Zone(name=name, title=title, corner=corners)


def _place(name: str, x: float, y: float, heading_deg: float) -> Place:
    return Place(name=name, x=_near(x), y=_near(y), heading_deg=heading_deg, kinds=("wheelchair", "person"))
