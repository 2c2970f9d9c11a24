"""Signs beside doorways: each names the room that one enters there. Pure; they hang flat on the walls."""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np

from intellwheels_maps.plane_geometry import contains
from intellwheels_schemas.messages import Map
from intellwheels_viewer.drawings.building_colours import BuildingColours
from intellwheels_viewer.drawings.door_frames import CASING
from intellwheels_viewer.drawings.glb import Surface
from intellwheels_viewer.drawings.lettering import atlas
from intellwheels_viewer.drawings.rooms import depth_of, is_outdoors, pieces_near, rooms_of
from intellwheels_viewer.drawings.solids import Solid, box, join, solid

HEIGHT: Final = 1.5
"""Height of a sign's middle, in metres."""
_TALL: Final = 0.17
_WIDEST: Final = 0.72
_THICK: Final = 0.012


class Sign(NamedTuple):
    """A sign: its text, the middle of its back on the wall, and the heading it faces, in metres and radians."""

    text: str
    x: float
    y: float
    heading: float


def places(floor: Map) -> list[Sign]:
    """Return the signs of all doorways between two rooms, on both sides, where there is a wall to hang them on."""
    if is_outdoors(floor):
        return []
    rooms, made = rooms_of(floor), []
    for doorway in floor.doorway:
        heading = math.radians(doorway.heading_deg)
        back, front = depth_of(floor, doorway)
        pieces = pieces_near(floor, (doorway.x, doorway.y), doorway.width + 1.0)
        cos, sin = math.cos(heading), math.sin(heading)
        for face, way in ((front, 1.0), (back, -1.0)):
            entered = rooms.at(doorway.x - way * (0.7 + abs(face)) * cos, doorway.y - way * (0.7 + abs(face)) * sin)
            if entered is None:
                continue
            for side in (way, -way):  # at the right hand of who enters, else at the left
                across = side * (doorway.width / 2 + CASING + 0.08 + _WIDEST / 2)
                x, y = doorway.x + face * cos - across * sin, doorway.y + face * sin + across * cos
                inside = (x - 0.03 * way * cos, y - 0.03 * way * sin)
                if any(contains(piece, inside) for piece in pieces):
                    facing = heading if way > 0 else heading + math.pi
                    made.append(Sign(entered.title or entered.name, x, y, facing))
                    break
    return made


def signs(floor: Map, colours: BuildingColours) -> list[Surface]:
    """Return the plates of all signs and their letters."""
    found = places(floor)
    if not found:
        return []
    picture, lines = atlas(tuple(sign.text for sign in found), colours.sign_letters)
    plates: list[Solid] = []
    corners, uv = [], []
    for sign, line in zip(found, lines, strict=True):
        tall = min(_TALL, (_WIDEST - 0.04) / line.aspect)
        half = min(_WIDEST, tall * line.aspect + 0.06) / 2
        plate = box(0.0, _THICK, -half, half, HEIGHT - _TALL / 2, HEIGHT + _TALL / 2)
        plates.append(plate.turned(sign.heading).moved(sign.x, sign.y))
        ahead, left = (
            (math.cos(sign.heading), math.sin(sign.heading)),
            (-math.sin(sign.heading), math.cos(sign.heading)),
        )
        for right, above in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
            # Who looks at the sign has its left at his right.
            across, along = right * tall * line.aspect / 2, _THICK + 0.003
            corners.append(
                (
                    sign.x + along * ahead[0] + across * left[0],
                    sign.y + along * ahead[1] + across * left[1],
                    HEIGHT + above * tall / 2,
                )
            )
            uv.append((line.right if right > 0 else 0.0, line.top if above > 0 else line.bottom))
    first = np.arange(0, len(corners), 4)
    faces = np.concatenate([np.column_stack([first, first + k, first + k + 1]) for k in (1, 2)])
    letters = Surface(solid(corners, faces), uv=np.array(uv, np.float32), picture=picture, blend=True)
    return [Surface(join(plates), colours.plate), letters]
