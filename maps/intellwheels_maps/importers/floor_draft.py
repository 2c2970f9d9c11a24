"""Collects the walls, doors and places that an importer finds, and makes a map of them. Pure.

Coordinates are those of the site, in metres. The map gets an `Offset` if they are far from the origin.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from itertools import pairwise
from pathlib import PurePath
from typing import Final, NamedTuple

import msgspec

from intellwheels_maps.check import opening, ring_of, wall_pieces
from intellwheels_maps.crossing import Point
from intellwheels_maps.importers.floor_source import FloorSource, Imported
from intellwheels_maps.keyholes import find_fault
from intellwheels_maps.plane_geometry import contains
from intellwheels_schemas.codec import VERSION
from intellwheels_schemas.messages import (
    Corner,
    Door,
    Doorway,
    Grid,
    Map,
    Obstacle,
    Place,
    Route,
    SiteOffset,
    Wall,
    Zone,
)

NEAR: Final = 1000.0
"""Largest coordinate, m, of a map whose frame is that of the site."""

WIDEST: Final = 9000.0
"""Largest distance of a point from the west or south edge of a map, m: the contract ends at 10 km."""

SMALLEST: Final = 0.5
"""Size of the smallest map, m."""

LEAF_TOLERANCE: Final = 0.3
"""Largest difference between a drawn door and its opening, as a share of the opening."""

_FITS: Final = 5
# How often a doorway is moved to the middle of its opening. Once is enough where walls end squarely.

MAX_CORNERS: Final = 60_000
"""Most corners of walls and obstacles; the message with the map holds some 30,000."""

MAX_TESTS: Final = 5_000_000
"""Most pairs of a wall and a doorway or place: each is tested against each."""

MAX_LISTED: Final = 8
"""Places that are listed for one reason; the rest is counted."""


class Leaf(NamedTuple):
    """A door as it may be meant.

    Attributes:
        left: The jamb on the left, seen along the heading of the doorway.
        right: The other jamb.
        door: What is known of the door, or None.
    """

    left: Point
    right: Point
    door: Door | None


class _DraftDoor(NamedTuple):
    name: str
    leaves: tuple[Leaf, ...]
    where: str


class FloorDraft:
    """The floor that an importer builds up.

    Args:
        source: The file.
        digits: Decimal places of a metre to which coordinates are rounded.
    """

    def __init__(self, source: FloorSource, digits: int = 4) -> None:
        self._source = source
        self._digits = digits
        self._walls: list[tuple[list[Point], float | None, float, float, str]] = []
        self._solids: list[tuple[str, list[Point], float, str]] = []
        self._zones: list[tuple[str, str, list[Point], str]] = []
        self._doors: list[_DraftDoor] = []
        self._places: list[tuple[str, Point, float, tuple[str, ...], str]] = []
        self._routes: list[tuple[list[str], bool]] = []
        self._left_out: dict[str, list[tuple[str, int]]] = {}
        self._names: dict[str, dict[str, int]] = {}

    def wall(
        self,
        points: Sequence[Point],
        where: str,
        *,
        thickness: float | None = None,
        height: float = 2.5,
        bottom: float = 0.0,
    ) -> None:
        """Add a wall: a line with a thickness, or an outline without holes."""
        self._check(points, where)
        self._walls.append((list(points), thickness, height, bottom, where))

    def obstacle(self, name: str, ring: Sequence[Point], top: float, where: str) -> None:
        """Add an obstacle that stands on the floor."""
        self._check(ring, where)
        self._solids.append((self.unique("obstacle", name), list(ring), top, where))

    def zone(self, name: str, ring: Sequence[Point], where: str, title: str = "") -> None:
        """Add a zone."""
        self._check(ring, where)
        self._zones.append((self.unique("zone", name), title[:200], list(ring), where))

    def door(self, name: str, where: str, *leaves: Leaf) -> None:
        """Add a doorway. Of several ways to read the drawing, the first one counts that fills an opening."""
        for leaf in leaves:
            self._check((leaf.left, leaf.right), where)
        self._doors.append(_DraftDoor(self.unique("doorway", name), leaves, where))

    def place(self, name: str, at: Point, where: str, heading_deg: float = 0.0, kinds: tuple[str, ...] = ()) -> str:
        """Add a place, and return its name in the map."""
        self._check((at,), where)
        heading_deg = math.remainder(heading_deg, 360.0)
        found = self.unique("place", name)
        self._places.append((found, at, heading_deg, kinds, where))
        return found

    def route(self, places: Iterable[str], *, one_way: bool) -> None:
        """Add a route between places of the map."""
        self._routes.append((list(places), one_way))

    def leave_out(self, where: str, reason: str, things: int = 1) -> None:
        """List something that the map does not have, or several things at one place for one reason."""
        self._left_out.setdefault(reason, []).append((where, things))

    def unique(self, kind: str, name: str) -> str:
        """Return a word like a name that nothing else of its kind has."""
        taken = self._names.setdefault(kind, {})
        base = word(name) or kind
        found = base
        while found in taken:
            # Numbers go on where they ended, so that many equal names take no longer than others.
            taken[base] += 1
            found = f"{base[:56]}-{taken[base]}"
        taken[found] = 1
        return found

    def finish(self, title: str = "", epsg: str | None = None, offset: Point | None = None) -> Imported:
        """Return the map.

        Args:
            title: Its name for people; default: the name of the file.
            epsg: The coordinate reference system of the site.
            offset: The origin of coordinates that are in the map frame already; None moves what is far away.

        Raises:
            WireError: It has no walls, or is larger than a map can be.
        """
        points = [point for line, *_ in self._walls for point in line]
        if not points and not self._solids:
            raise self._source.error("", "expected at least one wall, got none")
        points += [point for _, line, *_ in self._solids for point in line]
        points += [at for _, at, *_ in self._places]
        west, south = min(x for x, _ in points), min(y for _, y in points)
        east, north = max(x for x, _ in points), max(y for _, y in points)
        if max(east - west, north - south) > WIDEST:
            size = f"{east - west:,.0f} x {north - south:,.0f} m"
            raise self._source.error("", f"expected at most {WIDEST:,.0f} m across, got {size}; are the units right?")
        shift = (0.0, 0.0)
        if offset is None and max(abs(west), abs(south), abs(east), abs(north)) > NEAR:
            shift = offset = float(math.floor(west)), float(math.floor(south))
        if max(east - west, north - south) < SMALLEST:
            size = f"{east - west:g} x {north - south:g} m"
            raise self._source.error("", f"expected at least {SMALLEST:g} m across, got {size}; are the units right?")
        sides = sum(len(line) for line, *_ in self._walls) + sum(len(ring) for _, ring, *_ in self._solids)
        if sides > MAX_CORNERS:
            text = f"expected walls and obstacles of at most {MAX_CORNERS:,} corners, got {sides:,}"
            raise self._source.error("", text, "too-many")
        things = len(self._places) + 5 * sum(len(door.leaves) for door in self._doors)
        if sides * things > MAX_TESTS:
            text = f"{len(self._doors):,} doors and {len(self._places):,} places among walls of {sides:,} corners"
            raise self._source.error("", f"expected fewer doors and places, got {text}", "too-many")
        walls = self._made_walls(shift)
        file = PurePath(self._source.name).name
        stem = file.partition(".")[0]
        site = SiteOffset(x=offset[0], y=offset[1], epsg=epsg) if offset is not None else None
        document = Map(
            format=VERSION,
            name=word(stem) or "floor",
            title=(title or stem)[:200],
            source=file[:200],
            wall=tuple(walls),
            obstacle=tuple(self._made_solids(shift)),
            zone=tuple(self._made_zones(shift)),
            offset=site if site is not None else SiteOffset(x=0.0, y=0.0, epsg=epsg) if epsg else None,
        )
        document = self._with_doorways(document, shift)
        document = self._with_places(document, shift)
        things = sum(count for places in self._left_out.values() for _, count in places)
        return Imported(document, tuple(self._lines()), things)

    # ------------------------------------------------------------ parts of the map

    def _check(self, points: Iterable[Point], where: str) -> None:
        for x, y in points:
            if not (abs(x) < 1e8 and abs(y) < 1e8):
                raise self._source.error(where, f"expected coordinates within 100,000 km, got {x:g} {y:g}")

    def _corners(self, points: Sequence[Point], shift: Point, *, closed: bool) -> tuple[Corner, ...]:
        """Return rounded corners without repetitions."""
        found: list[Point] = []
        for x, y in points:
            point = round(x - shift[0], self._digits) + 0.0, round(y - shift[1], self._digits) + 0.0
            if not found or found[-1] != point:
                found.append(point)
        while closed and len(found) > 1 and found[0] == found[-1]:
            found.pop()
        return tuple(Corner(x=x, y=y) for x, y in found)

    def _ring(self, points: Sequence[Point], shift: Point, where: str) -> tuple[Corner, ...] | None:
        """Return the corners of an outline, or None for one that is left out."""
        corners = self._corners(points, shift, closed=True)
        ring = ring_of(corners)
        area = math.fsum(a[0] * b[1] - b[0] * a[1] for a, b in pairwise([*ring, *ring[:1]]))
        if len(ring) < 3 or area == 0.0:
            self.leave_out(where, "outline without an area")
        elif find_fault(ring) is not None:
            self.leave_out(where, "outline that crosses or touches itself")
        else:
            return corners
        return None

    def _made_walls(self, shift: Point) -> Iterable[Wall]:
        for points, thickness, height, bottom, where in self._walls:
            if thickness is None:
                ring = self._ring(points, shift, where)
                if ring is not None:
                    yield Wall(corner=ring, height=height, bottom=bottom)
                continue
            corners = self._corners(points, shift, closed=False)
            if len(corners) < 2:
                self.leave_out(where, "wall without a length")
                continue
            yield Wall(corner=corners, thickness=thickness, height=height, bottom=bottom)

    def _made_solids(self, shift: Point) -> Iterable[Obstacle]:
        for name, points, top, where in self._solids:
            ring = self._ring(points, shift, where)
            if ring is not None:
                yield Obstacle(name=name, top=top, corner=ring)

    def _made_zones(self, shift: Point) -> Iterable[Zone]:
        for name, title, points, where in self._zones:
            ring = self._ring(points, shift, where)
            if ring is not None:
                yield Zone(name=name, title=title or None, corner=ring)

    def _with_doorways(self, document: Map, shift: Point) -> Map:
        """Return the map with its doorways, each as wide as the gap between the walls where a door was drawn."""
        found = []
        for name, leaves, where in self._doors:
            fits = [(self._fitted(document, name, leaf, shift), leaf) for leaf in leaves]
            openings = [(fit, leaf) for fit, leaf in fits if isinstance(fit, Doorway)]
            if not openings:
                self.leave_out(where, f"doorway {fits[0][0]}")
                continue
            for fit, leaf in openings:
                if abs(fit.width - math.dist(leaf.left, leaf.right)) <= LEAF_TOLERANCE * fit.width:
                    found.append(msgspec.structs.replace(fit, door=leaf.door))
                    break
            else:
                drawn = math.dist(leaves[0].left, leaves[0].right)
                sizes = f"{drawn:.2f} m in {openings[0][0].width:.2f} m"
                self.leave_out(f"{where}, {sizes}", "door that does not fit its opening")
        return msgspec.structs.replace(document, doorway=tuple(found))

    def _fitted(self, document: Map, name: str, leaf: Leaf, shift: Point) -> Doorway | str:
        """Return the doorway in the gap between the walls at two jambs, or why there is none."""
        left, right = leaf.left, leaf.right
        x, y = (left[0] + right[0]) / 2 - shift[0], (left[1] + right[1]) / 2 - shift[1]
        heading = math.atan2(left[1] - right[1], left[0] - right[0]) - math.pi / 2
        width = 1.0
        for _ in range(_FITS):
            doorway = Doorway(
                name=name,
                x=round(x, 4) + 0.0,
                y=round(y, 4) + 0.0,
                heading_deg=_degrees(heading),
                width=round(width, 4),
            )
            to_left, to_right = opening(document, doorway)
            if to_left == 0.0 and to_right == 0.0:
                return "whose middle is inside a wall"
            if math.isinf(to_left + to_right):
                return "without a wall on each side"
            if abs(to_left - to_right) < 1e-3 and abs(to_left + to_right - width) < 1e-3:
                return doorway
            width = max(to_left + to_right, 1e-3)
            x -= math.sin(heading) * (to_left - to_right) / 2
            y += math.cos(heading) * (to_left - to_right) / 2
        return "whose walls are not clear"

    def _with_places(self, document: Map, shift: Point) -> Map:
        pieces = [piece for wall in document.wall for piece in wall_pieces(wall)]
        pieces += [ring_of(obstacle.corner) for obstacle in document.obstacle]
        found = []
        for name, (x, y), heading, kinds, where in self._places:
            at = round(x - shift[0], self._digits) + 0.0, round(y - shift[1], self._digits) + 0.0
            if any(contains(piece, at) for piece in pieces):
                self.leave_out(where, "place inside a wall")
                continue
            found.append(Place(name=name, x=at[0], y=at[1], heading_deg=round(heading, 4) + 0.0, kinds=kinds))
        kept = {place.name for place in found}
        routes: list[Route] = []
        for places, one_way in self._routes:
            if kept.issuperset(places):
                routes.append(Route(name=f"route{len(routes) + 1}", places=tuple(places), one_way=one_way))
            else:
                self.leave_out(" - ".join(places), "route to a place that is left out")
        grid = Grid(position=tuple(found)) if found else None
        return msgspec.structs.replace(document, grid=grid, route=tuple(routes))

    def _lines(self) -> Iterable[str]:
        """Yield a line for each reason."""
        for reason, places in self._left_out.items():
            if places[1:]:
                shown = [f"{where}: {count:,}" if count > 1 else where for where, count in places[:MAX_LISTED]]
                more = [f"{len(places) - MAX_LISTED:,} more"] if len(places) > MAX_LISTED else []
                yield f"{reason}: {sum(count for _, count in places):,} ({'; '.join(shown + more)})"
            else:
                ((where, count),) = places
                yield f"{where}: {reason}: {count:,}" if count > 1 else f"{where}: {reason}"


def word(text: str) -> str:
    """Return a text as a word of the contract: other characters become `-`; empty if nothing is left."""
    return re.sub(r"[^A-Za-z0-9_.-]+", "-", text).strip("-_.")[:64].rstrip("-_.")


def _degrees(radians: float) -> float:
    return round(math.degrees(math.remainder(radians, math.tau)), 4) + 0.0
