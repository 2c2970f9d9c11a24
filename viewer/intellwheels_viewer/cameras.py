"""One browser's camera: free, plan, follow or first person.

The functions compute where a camera must be; the class moves the camera of one browser. A page reports the user's
camera moves and, later, echoes of ours. Once the user has moved the view, it is not framed again.
"""

from __future__ import annotations

import math
import threading
import time
from collections import deque
from collections.abc import Iterable
from typing import Final, Literal, NamedTuple

import numpy as np
import numpy.typing as npt
import viser

from intellwheels_schemas.messages import Entity, Map
from intellwheels_viewer.drawings.label_layout import Picture
from intellwheels_viewer.head_turn import REACH, Eye, HeadTurn, line_of_sight, position_of

Mode = Literal["free", "plan", "follow", "first"]
Vector = npt.NDArray[np.float64]

FOV: Final = math.radians(42.0)
PLAN_FOV: Final = math.radians(8.0)
"""Nearly parallel lines of sight: viser has no orthographic camera."""
SEATED: Final = Eye()
STEEP: Final = math.radians(58.0)
"""Angle of the first view below the horizontal."""
TALLEST: Final = 1.6
"""Height of the tallest body with its label, in metres."""
MARGIN: Final = 0.03
"""Share of the picture that stays empty at each edge."""
UPRIGHT: Final = 0.75
"""Width over height of the free part of a picture, below which a long map may be seen from the west (chosen)."""
ASIDE: Final = tuple(math.radians(degrees) for degrees in (15.0, 30.0, 40.0, 50.0, 60.0))
"""Angles between south and west from which a wide map may be seen; north stays in the upper half of the picture."""
WORTH: Final = 1.2
"""How many times larger a floor must be from another side than from the south (chosen)."""
SMALLEST: Final = 2.0
"""Metres that a view shows at least, even of an empty map."""
FAR: Final = 3000.0
"""Minimum distance of the far plane, in metres; the plan of a large map needs more."""
_ECHO: Final = 1e-3  # metres; a page reports in float32


class View(NamedTuple):
    """The position of a camera and the point that it looks at."""

    position: Vector
    look_at: Vector
    fov: float


def corners_of(floor: Map) -> Vector:
    """Return the eight corners of the box that a first view must show, in metres, shape (8, 3)."""
    points = [(c.x, c.y) for wall in floor.wall for c in wall.corner]
    points += [(c.x, c.y) for zone in floor.zone for c in zone.corner]
    points += [(c.x, c.y) for thing in floor.obstacle for c in thing.corner]
    points += [(place.x, place.y) for place in (() if floor.grid is None else floor.grid.position)]
    if not points:
        points = [(-5.0, -5.0), (5.0, 5.0)]
    low, high = np.min(points, axis=0), np.max(points, axis=0)
    short = np.maximum(SMALLEST - (high - low), 0.0) / 2
    low, high = low - short, high + short
    return np.array([(x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (0.0, TALLEST)])


def fit(points: Vector, steep: float, fov: float, aspect: float, covered: float = 0.0) -> View:
    """Return a view that shows all points at a given angle, and from its side no nearer one does.

    It is from the south, unless the floor is much larger from another side: a wide one from the south-west, and in an
    upright picture a long one from the west.

    Args:
        points: In metres, shape (n, 3).
        steep: Angle below the horizontal, in radians, in (0, pi/2).
        fov: Vertical field of view, in radians.
        aspect: Width of the picture over its height.
        covered: Share of the picture's height that panels cover at its bottom, in [0, 1).
    """
    south = _fitted(points, steep, fov, aspect, covered, 0.0)
    if aspect < UPRIGHT * (1.0 - covered):
        west = _fitted(points, steep, fov, aspect, covered, math.pi / 2)
        return min(west, south, key=lambda view: float(view.position[2]))
    views = [_fitted(points, steep, fov, aspect, covered, angle) for angle in ASIDE]
    largest = max(views, key=lambda view: shown_floor(points, view, aspect))
    return largest if shown_floor(points, largest, aspect) >= WORTH * shown_floor(points, south, aspect) else south


def shown_floor(points: Vector, view: View, aspect: float) -> float:
    """Return the share of a picture that the floor below points fills, in [0, 1] if all of it is in the picture.

    Args:
        points: In metres, shape (n, 3); the floor is the rectangle around them.
        view: The camera.
        aspect: Width of the picture over its height.
    """
    (west, south, _), (east, north, _) = points.min(axis=0), points.max(axis=0)
    away = np.array([(west, south, 0.0), (east, south, 0.0), (east, north, 0.0), (west, north, 0.0)]) - view.position
    ahead = (view.look_at - view.position) / np.linalg.norm(view.look_at - view.position)
    right = np.cross(ahead, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    x, y = away @ right / (away @ ahead), away @ np.cross(right, ahead) / (away @ ahead)
    whole = (2.0 * math.tan(view.fov / 2)) ** 2 * aspect
    return abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1))) / 2.0 / whole


def _fitted(points: Vector, steep: float, fov: float, aspect: float, covered: float, aside: float) -> View:
    """Return the nearest view from a side, in radians from the south towards the west, see `fit`."""
    course = np.array([math.sin(aside), math.cos(aside), 0.0])
    vertical = np.array([0.0, 0.0, 1.0])
    ahead = math.cos(steep) * course - math.sin(steep) * vertical
    up = math.sin(steep) * course + math.cos(steep) * vertical
    right = np.cross(ahead, up)
    free = 1.0 - covered
    top = math.tan(fov / 2) * (1.0 - 2.0 * MARGIN * free)
    bottom = math.tan(fov / 2) * (1.0 - 2.0 * covered - 2.0 * MARGIN * free)
    wide = math.tan(fov / 2) * (1.0 - 2.0 * MARGIN) * aspect
    # A point at depth d is in the picture when |across| <= d wide and -d bottom <= above <= d top: four planes. With
    # the camera at -s on each axis, the tightest pair of planes of each axis gives the distance that both need.
    across, above, depth = points @ right, points @ up, points @ ahead
    left, far_right = np.max(-across - depth * wide), np.max(across - depth * wide)
    low, high = np.max(-above - depth * bottom), np.max(above - depth * top)
    back = max((left + far_right) / (2 * wide), (low + high) / (top + bottom))
    shift_x, shift_y = (far_right - left) / 2, (high - low - back * (top - bottom)) / 2
    position = right * shift_x + up * shift_y - ahead * back
    to_floor = position[2] / math.sin(steep)
    return View(position, position + ahead * to_floor, fov)


def plan_of(points: Vector, aspect: float, covered: float = 0.0) -> View:
    """Return the view from above, 1 mrad off the vertical: exactly vertical would turn the picture."""
    flat, steep = points * np.array([1.0, 1.0, 0.0]), math.pi / 2 - 1e-3
    upright = aspect < UPRIGHT * (1.0 - covered)
    views = [_fitted(flat, steep, PLAN_FOV, aspect, covered, side) for side in (0.0, math.pi / 2)[: 1 + upright]]
    return min(views, key=lambda view: float(view.position[2]))


def first_person(entity: Entity, eye: Eye = SEATED, yaw: float = 0.0, pitch: float = 0.0) -> View:
    """Return the view of a person in the chair.

    Args:
        entity: The body.
        eye: Where in the body the eye is, and its field of view.
        yaw: Turn of the head to the left, in radians.
        pitch: Turn of the head upwards, in radians.
    """
    at = position_of(entity, eye)
    return View(at, at + REACH * line_of_sight(entity.heading, yaw, pitch), eye.fov)


def behind(entity: Entity) -> View:
    """Return the first view when following a body: from behind and above."""
    at = np.array([entity.x, entity.y, 0.6])
    cos, sin = math.cos(entity.heading), math.sin(entity.heading)
    return View(at + np.array([-4.2 * cos, -4.2 * sin, 3.4]), at, FOV)


def on_floor(origin: Iterable[float], direction: Iterable[float]) -> tuple[float, float] | None:
    """Return where a ray meets the floor, in metres; None if it does not, or beyond the range of coordinates."""
    (ox, oy, oz), (dx, dy, dz) = origin, direction
    if dz >= -1e-9 or oz <= 0.0:
        return None
    along = -oz / dz
    # Plain floats: the codec does not take numpy numbers.
    x, y = float(ox + along * dx), float(oy + along * dy)
    return (x, y) if abs(x) < 1e4 and abs(y) < 1e4 else None  # the range of coordinates; also refuses NaN


def ray(camera: viser.CameraHandle, right: float, up: float) -> tuple[Vector, Vector]:
    """Return the line of sight through a point of the picture: its origin and direction.

    Args:
        camera: The camera of the picture.
        right: From the middle, in half widths, in [-1, 1].
        up: From the middle, in half heights, in [-1, 1].
    """
    eye = np.array(camera.position)
    ahead = np.array(camera.look_at) - eye
    ahead /= max(float(np.linalg.norm(ahead)), 1e-9)
    side = np.cross(ahead, np.array(camera.up_direction))
    side /= max(float(np.linalg.norm(side)), 1e-9)
    tall = math.tan(camera.fov / 2)
    return eye, ahead + side * (right * tall * camera.aspect) + np.cross(side, ahead) * (up * tall)


class Camera:
    """A browser's camera. The page's messages arrive in one thread, the body that it follows moves in another.

    Args:
        client: The browser.
    """

    def __init__(self, client: viser.ClientHandle) -> None:
        self._client = client
        self._lock = threading.RLock()
        self.mode: Mode = "free"
        self._corners: Vector | None = None
        self._aspect = 0.0
        self._covered = 0.0
        self._aspect_is_told = False
        self._by_hand = False
        # Whether the page has reported one of our writes. Until then it reports its own default camera.
        self._settled = False
        self._written: deque[Vector] = deque(maxlen=256)
        self._offset: Vector | None = None
        self._target: Vector | None = None
        self.eye = SEATED
        self._head, self._heading = HeadTurn(), 0.0

        @client.camera.on_update
        async def _(_: viser.CameraHandle) -> None:
            with self._lock:
                self._reported()

    def frame(self, floor: Map) -> None:
        """Fit another map into the picture, in the free view and in the plan."""
        with self._lock:
            self._corners = corners_of(floor)
            self._by_hand = False
            self._fit()

    def leave_free(self, covered: float, aspect: float = 0.0) -> None:
        """Fit the map into what panels leave free.

        Args:
            covered: The share of the picture's height that they cover, at its bottom, in [0, 0.8].
            aspect: Width of the picture over its height, 0 if it is not known. Once it is, the aspect that viser's page
                reports with its camera no longer counts: of several quick changes, as while panels dock, the last may
                be missing there.
        """
        with self._lock:
            other = aspect > 0.0 and abs(aspect - self._aspect) > 2e-3  # the page rounds it
            self._aspect_is_told = self._aspect_is_told or aspect > 0.0
            if other or abs(covered - self._covered) > 0.005:
                self._covered = covered
                self._aspect = aspect if other else self._aspect
                if not self._by_hand:
                    self._fit()

    def choose(self, mode: Mode, entity: Entity | None) -> None:
        """Change the mode. Following and first person need a body."""
        with self._lock:
            self.mode = mode if entity is not None or mode in ("free", "plan") else "free"
            self._by_hand = False
            self._offset = self._target = None
            self._head.straighten()
            if self.mode in ("free", "plan"):
                self._fit()
            elif entity is not None:
                self.follow(entity)

    def look_from(self, eye: tuple[float, float, float], to: tuple[float, float, float]) -> None:
        """Look from a point at another one, in metres; in follow mode the camera then moves with the body."""
        with self._lock:
            view = View(np.array(eye), np.array(to), PLAN_FOV if self.mode == "plan" else FOV)
            if self.mode == "follow":
                self._offset = view.position - view.look_at
            elif self.mode != "first":
                self._by_hand = True
                self._write(view, near=0.9 if self.mode == "plan" else 0.1)

    def follow(self, entity: Entity) -> None:
        """Move the camera with the followed body, once per drawn tick."""
        with self._lock:
            if self.mode == "first":
                self._head.come_back(time.monotonic())
                self._heading = entity.heading
                self._write(first_person(entity, self.eye, self._head.yaw, self._head.pitch), near=0.06)
            elif self.mode == "follow":
                view = behind(entity)
                if self._offset is None:
                    self._offset = view.position - view.look_at
                if self._target is None or not np.allclose(self._target, view.look_at, atol=1e-6):
                    self._target = view.look_at
                    self._write(View(view.look_at + self._offset, view.look_at, FOV))

    @property
    def turning(self) -> float:
        """A number that changes while a head is turned, so that it comes back in a paused run too."""
        return time.monotonic() if self.mode == "first" and self._head.is_turned else 0.0

    @property
    def picture(self) -> Picture | None:
        """What the camera shows now, as far as this process knows; None before the page's first report."""
        with self._lock:
            camera = self._client.camera
            try:
                x, y, z = (float(value) for value in camera.position)
                to = (float(value) for value in camera.look_at)
                width = camera.image_height * self._aspect if self._aspect_is_told else camera.image_width
                shown = Picture((x, y, z), tuple(to), camera.fov, width, camera.image_height)  # type: ignore[arg-type]
            except AssertionError:
                return None
            sizes = (*shown.position, *shown.look_at, shown.fov, shown.width, shown.height)
            if not all(map(math.isfinite, sizes)) or not 0 < shown.fov < math.pi or min(shown.width, shown.height) <= 0:
                return None  # a minimised window, or not our page
            return shown

    def _reported(self) -> None:
        """Take the page's report of its camera."""
        camera = self._client.camera
        position, look_at = np.array(camera.position), np.array(camera.look_at)
        if camera.image_height <= 0 or not np.isfinite((position, look_at)).all():
            return  # a minimised window, or not our page
        # A smaller change is rounding.
        if not self._aspect_is_told and camera.aspect > 0 and abs(camera.aspect - self._aspect) > 1e-3:
            self._aspect = camera.aspect
            if not self._by_hand:
                self._fit()
                return
        if any(np.linalg.norm(position - written) < _ECHO for written in self._written):
            self._settled = True
            return
        if not self._settled:
            return
        if self.mode == "follow":
            # The camera moves with the body, so the rest of the report is the user's orbit.
            self._offset = position - look_at
        elif self.mode == "first":
            self._head.turn_to(look_at - position, self._heading, time.monotonic())
        else:
            self._by_hand = True
            down = (look_at - position)[2] / max(float(np.linalg.norm(look_at - position)), 1e-9)
            if self.mode == "plan" and down > -0.999:  # an orbit, no longer a plan
                self.mode = "free"
                camera.fov = FOV

    def _fit(self) -> None:
        if self._corners is None or self.mode not in ("free", "plan"):
            return
        aspect = self._aspect or 1.6
        plan = self.mode == "plan"
        view = (
            plan_of(self._corners, aspect, self._covered)
            if plan
            else fit(self._corners, STEEP, FOV, aspect, self._covered)
        )
        self._write(view, near=0.9 if plan else 0.1)

    def _write(self, view: View, near: float = 0.1) -> None:
        camera = self._client.camera
        self._written.append(view.position)
        try:
            with self._client.atomic():
                # In this order, because setting the position moves the point that the camera looks at.
                camera.position = view.position
                camera.look_at = view.look_at
                camera.fov = view.fov
                camera.near = near
                camera.far = max(FAR, 2.0 * float(np.linalg.norm(view.position - view.look_at)))
        except (AssertionError, ValueError):
            # The page has not reported yet, and `frame` is repeated when it has; or it reported an invalid camera.
            self._written.pop()
