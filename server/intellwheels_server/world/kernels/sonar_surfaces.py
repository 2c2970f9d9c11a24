"""How long the surface of a face is, where there are many: only faces of nearly its direction can continue it."""

from __future__ import annotations

import numpy as np
from numba import njit

from intellwheels_server.world.kernels import face_columns
from intellwheels_server.world.kernels.sonar_scene import MANY_FACES, MOST_ALIKE, Counts, Scene
from intellwheels_server.world.kernels.sonar_widths import surface_length

# Faces of one plane differ in their turns by less than this; see `sonar_scene.turn_of`. The directions of such faces
# differ by at most 1e-6 rad, and their turns by no more.
_ALIKE = 2e-6

# The turn of a whole turn.
_WHOLE = 4.0


@njit(cache=True, error_model="numpy")
def _alike(face: int, scene: Scene, counts: Counts) -> int:
    """Store the rows of the faces of a direction in `scene.alike`, ascending; return how many, or -1 if too many."""
    turns, order, found = scene.turns[: counts.faces], scene.by_turn, scene.alike
    own = scene.turn_of[face]
    count = 0
    for shift in (-_WHOLE, 0.0, _WHOLE):
        low, high = own + shift - _ALIKE, own + shift + _ALIKE
        if high < 0.0 or low > _WHOLE:
            continue
        at = np.searchsorted(turns, low)
        while at < counts.faces and turns[at] <= high:
            if count == MOST_ALIKE:
                return -1
            place = count
            while place > 0 and found[place - 1] > order[at]:
                found[place] = found[place - 1]
                place -= 1
            found[place] = order[at]
            count += 1
            at += 1
    return count


@njit(cache=True, error_model="numpy")
def length_in_scene(face: int, enough: float, z: float, scene: Scene, counts: Counts) -> float:
    """Return the length of a face with those that continue it: see `sonar_widths.surface_length`."""
    faces = scene.faces
    if counts.faces < MANY_FACES or faces[face, face_columns.LENGTH] >= enough:
        return surface_length(face, enough, z, faces, counts.faces)
    count = _alike(face, scene, counts)
    if count < 0:
        return surface_length(face, enough, z, faces, counts.faces)
    own = 0
    for at in range(count):
        other = scene.alike[at]
        own = at if other == face else own
        for column in range(face_columns.COUNT):
            scene.alike_faces[at, column] = faces[other, column]
    return surface_length(own, enough, z, scene.alike_faces, count)


@njit(cache=True, error_model="numpy")
def is_long_in_scene(face: int, least: float, z: float, scene: Scene, counts: Counts) -> bool:
    """Return whether a face with those that continue it has at least a length."""
    return bool(length_in_scene(face, least, z, scene, counts) >= least)
