"""Triangle meshes. Pure: sizes in metres in, vertices (V, 3) float32 and faces (F, 3) uint32 out.

Faces are anticlockwise seen from outside. Sharp edges have separate vertices for each face and round ones share them,
because a browser averages the normals of all faces at a vertex.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from intellwheels_viewer.drawings.polygons import anticlockwise, triangles

Array: TypeAlias = npt.NDArray[np.float32]
Faces: TypeAlias = npt.NDArray[np.uint32]
Point: TypeAlias = tuple[float, float, float]


def _no_vertices() -> Array:
    return np.zeros((0, 3), np.float32)


def _no_faces() -> Faces:
    return np.zeros((0, 3), np.uint32)


@dataclass(frozen=True, eq=False)
class Solid:
    """Triangles.

    Attributes:
        vertices: (V, 3), metres.
        faces: (F, 3), indices of vertices.
    """

    vertices: Array = field(default_factory=_no_vertices)
    faces: Faces = field(default_factory=_no_faces)

    def __add__(self, other: Solid) -> Solid:
        return join((self, other))

    def moved(self, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Solid:
        """Return it translated."""
        return Solid(self.vertices + np.array([x, y, z], np.float32), self.faces)

    def turned(self, heading: float) -> Solid:
        """Return it rotated about the vertical axis through the origin, anticlockwise seen from above."""
        return self._times((math.cos(heading), -math.sin(heading), 0), (math.sin(heading), math.cos(heading), 0))

    def leaning(self, angle: float, x: float, z: float) -> Solid:
        """Return it tilted back, towards -x, about the y axis through (x, z)."""
        cos, sin = math.cos(angle), math.sin(angle)
        about = self.moved(-x, 0.0, -z)
        return about._times((cos, 0, -sin), (0, 1, 0), (sin, 0, cos)).moved(x, 0.0, z)

    def mirrored(self) -> Solid:
        """Return it mirrored: y changes its sign."""
        return Solid(self.vertices * np.array([1, -1, 1], np.float32), self.faces[:, ::-1].copy())

    def _times(self, *rows: Sequence[float]) -> Solid:
        matrix = np.eye(3)
        matrix[: len(rows)] = rows
        return Solid((self.vertices @ matrix.T).astype(np.float32), self.faces)


def solid(vertices: npt.ArrayLike, faces: npt.ArrayLike) -> Solid:
    """Return a solid from anything that numpy converts to (V, 3) and (F, 3)."""
    return Solid(
        np.asarray(vertices, np.float32).reshape(-1, 3).copy(), np.asarray(faces, np.uint32).reshape(-1, 3).copy()
    )


def join(solids: Iterable[Solid]) -> Solid:
    """Return several solids as one."""
    vertices, faces, count = [_no_vertices()], [_no_faces()], 0
    for each in solids:
        vertices.append(each.vertices)
        faces.append(each.faces + np.uint32(count))
        count += len(each.vertices)
    return Solid(np.concatenate(vertices), np.concatenate(faces))


def both(one: Solid) -> Solid:
    """Return a solid and its mirror image, y negated."""
    return one + one.mirrored()


def prism(polygon: Sequence[tuple[float, float]], bottom: float, top: float) -> Solid:
    """Return a polygon, convex or not, extruded upwards. Without a lower face if it stands on the floor."""
    points = anticlockwise(polygon)
    count = len(points)
    cap = np.array(triangles(points), np.uint32).reshape(-1, 3)
    lids = [_lid(points, top, cap)]
    if bottom > 0.0:
        lids.append(_lid(points, bottom, cap[:, ::-1]))
    corners, faces = [], []
    for index, (ax, ay) in enumerate(points):
        bx, by = points[(index + 1) % count]
        first = 4 * index
        corners += [(ax, ay, bottom), (bx, by, bottom), (bx, by, top), (ax, ay, top)]
        faces += [(first, first + 1, first + 2), (first, first + 2, first + 3)]
    return join([*lids, solid(corners, faces)])


def sheet(polygon: Sequence[tuple[float, float]], z: float) -> Solid:
    """Return a flat polygon, visible from above."""
    points = anticlockwise(polygon)
    return _lid(points, z, np.array(triangles(points), np.uint32).reshape(-1, 3))


def _lid(points: Sequence[tuple[float, float]], z: float, faces: Faces) -> Solid:
    return solid([(x, y, z) for x, y in points], faces)


def box(x0: float, x1: float, y0: float, y1: float, z0: float, z1: float) -> Solid:
    """Return an axis-aligned box with all six faces."""
    corners = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
    body = prism(corners, z0, z1)
    return body if z0 > 0.0 else body + _lid(corners, z0, np.array([[0, 2, 1], [0, 3, 2]], np.uint32))


def loft(sections: Sequence[Sequence[Point]], *, closed: bool = True) -> Solid:
    """Return the surface through rings with the same number of points, each anticlockwise seen from the last ring.

    Args:
        sections: The rings, from the first to the last.
        closed: Whether the two ends have lids.
    """
    count = len(sections[0])
    faces: list[tuple[int, int, int]] = []
    for level in range(len(sections) - 1):
        for index in range(count):
            a, b = level * count + index, level * count + (index + 1) % count
            faces += [(a, b, b + count), (a, b + count, a + count)]
    skin = solid([point for section in sections for point in section], faces)
    if not closed:
        return skin
    fan = [(0, index, index + 1) for index in range(1, count - 1)]
    return join([skin, solid(sections[-1], fan), solid(sections[0], [face[::-1] for face in fan])])


def slab(
    x: float, y: float, length: float, width: float, z0: float, z1: float, *, radius: float, bevel: float
) -> Solid:
    """Return a box with round upright edges and bevelled level ones: upholstery.

    Args:
        x: Its middle.
        y: Its middle.
        length: Its size along x.
        width: Its size along y.
        z0: Its lower face.
        z1: Its upper face.
        radius: Of the round edges.
        bevel: How much the level edges are cut.
    """
    bevel = min(bevel, (z1 - z0) / 2)

    def ring(z: float, inset: float) -> list[Point]:
        return [(px, py, z) for px, py in rounded(x, y, length - 2 * inset, width - 2 * inset, radius)]

    return loft([ring(z0, bevel), ring(z0 + bevel, 0.0), ring(z1 - bevel, 0.0), ring(z1, bevel)])


def rounded(
    x: float, y: float, length: float, width: float, radius: float, steps: int = 2
) -> list[tuple[float, float]]:
    """Return a rectangle with round corners, anticlockwise, `steps` + 1 points a corner."""
    radius = min(radius, length / 2, width / 2)
    points = []
    for quarter, (sx, sy) in enumerate(((1, 1), (-1, 1), (-1, -1), (1, -1))):
        cx, cy = x + sx * (length / 2 - radius), y + sy * (width / 2 - radius)
        for step in range(steps + 1):
            angle = (quarter + step / steps) * math.pi / 2
            points.append((cx + radius * math.cos(angle), cy + radius * math.sin(angle)))
    return points


def ellipses(sections: Sequence[tuple[float, float, float, float, float]], sides: int = 14) -> Solid:
    """Return a round solid of horizontal ellipses (z, x, y, half length, half width), from bottom to top."""
    turns = [2 * math.pi * index / sides for index in range(sides)]
    return loft([[(x + a * math.cos(t), y + b * math.sin(t), z) for t in turns] for z, x, y, a, b in sections])


def ball(x: float, y: float, z: float, radius: float, sides: int = 12) -> Solid:
    """Return a sphere."""
    rows = sides // 2
    tilts = [math.pi * (row / rows - 0.5) for row in range(rows + 1)]
    return ellipses(
        [(z + radius * math.sin(t), x, y, radius * math.cos(t), radius * math.cos(t)) for t in tilts], sides
    )


def rod(start: Point, end: Point, radius: float, sides: int = 6) -> Solid:
    """Return a round rod between two points, with flat ends."""
    return taper(start, end, radius, radius, sides)


def taper(start: Point, end: Point, first: float, last: float, sides: int = 6) -> Solid:
    """Return a round rod between two points whose radius goes from the first to the last, with flat ends."""
    a, b = np.array(start), np.array(end)
    axis = (b - a) / np.linalg.norm(b - a)
    aside = np.cross(axis, (0.0, 0.0, 1.0) if abs(axis[2]) < 0.9 else (0.0, 1.0, 0.0))
    aside /= np.linalg.norm(aside)
    up = np.cross(axis, aside)
    turns = [2 * math.pi * index / sides for index in range(sides)]
    circle = [math.cos(t) * aside + math.sin(t) * up for t in turns]
    return loft([[_point(at + radius * offset) for offset in circle] for at, radius in ((a, first), (b, last))])


def _point(vector: npt.NDArray[np.float64]) -> Point:
    return float(vector[0]), float(vector[1]), float(vector[2])


def pipe(points: Sequence[Point], radius: float, sides: int = 6) -> Solid:
    """Return a bent tube: a rod for each segment."""
    return join(rod(a, b, radius, sides) for a, b in itertools.pairwise(points))


def tube(points: Sequence[Point], sizes: Sequence[tuple[float, float]], sides: int = 6) -> Solid:
    """Return a smooth bent tube of elliptic sections, with flat ends. No part of it may be vertical.

    Args:
        points: Its axis.
        sizes: Half the width, across and level, and half the height of the section at each point.
        sides: Corners of a section.
    """
    axis = np.array(points)
    along = np.gradient(axis, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    aside = np.cross(along, (0.0, 0.0, 1.0))
    aside /= np.linalg.norm(aside, axis=1, keepdims=True)
    up = np.cross(along, aside)
    turns = [2 * math.pi * index / sides for index in range(sides)]
    rings = zip(axis, aside, up, sizes, strict=True)
    return loft([[_point(p + math.cos(t) * w * a + math.sin(t) * h * u) for t in turns] for p, a, u, (w, h) in rings])


def hoop(x: float, y: float, z: float, radius: float, thickness: float, sides: int = 24, around: int = 6) -> Solid:
    """Return a tyre that stands along x: a torus about the level axis across.

    Args:
        x: Its middle.
        y: Its middle.
        z: Its middle.
        radius: Outer radius, so the radius of the wheel.
        thickness: Of the tyre.
        sides: Corners of the large circle.
        around: Corners of the small one.
    """
    large, small = radius - thickness / 2, thickness / 2
    u = np.arange(sides) * 2 * math.pi / sides
    v = np.arange(around) * 2 * math.pi / around
    reach = large + small * np.cos(v)[None, :]
    vertices = np.stack(
        [
            x + reach * np.cos(u)[:, None],
            np.broadcast_to(y + small * np.sin(v)[None, :], (sides, around)),
            z + reach * np.sin(u)[:, None],
        ],
        axis=-1,
    )
    faces = []
    for i in range(sides):
        for j in range(around):
            a, b = i * around + j, i * around + (j + 1) % around
            c, d = (i + 1) % sides * around + j, (i + 1) % sides * around + (j + 1) % around
            faces += [(a, b, d), (a, d, c)]
    return solid(vertices, faces)


def band(inner: float, outer: float, z: float, start: float = 0.0, end: float = 2 * math.pi, sides: int = 48) -> Solid:
    """Return a flat ring, or its part between two angles, visible from above; with `inner` 0 a disc or fan."""
    turns = np.linspace(start, end, sides + 1)
    circle = np.stack([np.cos(turns), np.sin(turns)], axis=1)
    flat = np.concatenate([circle * inner, circle * outer])
    vertices = np.column_stack([flat, np.full(len(flat), z)])
    faces = []
    for index in range(sides):
        a, b = index, index + sides + 1
        faces.append((a, b, b + 1))
        if inner > 0.0:
            faces.append((a, b + 1, a + 1))
    return solid(vertices, faces)
