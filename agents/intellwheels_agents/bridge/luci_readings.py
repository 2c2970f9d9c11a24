"""What a LUCI chair measures, in the units and the frame of the contract. Pure.

LUCI's frame has its origin between the drive wheels, like ours, but y points forward and x to the right:

    x = Y,  y = -X

Wheel angles are degrees in [0, 360). They are followed the shorter way round, so a wheel may turn by less than half a
turn between two messages. The encoder board reports exactly 0 for a wheel whose magnet it has lost.

Source:
    `luci_transforms`, `luci-sdk-encoders` and `encoder-to-odom-library` of the maker's SDK. It states no unit for the
    inertial unit: rad/s and m/s2 are assumed, and values that no chair can have in these units are refused.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any, Final

from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Proximity, ProximityReading

Point = tuple[float, float]
"""Metres, x forward and y to the left of the centre of movement."""

WHEELS: Final = ("left", "right")
GRAVITY: Final = 9.81
"""Acceleration of gravity, m/s2."""
GRAVITY_TOLERANCE: Final = 1.0
"""Largest error of a measured gravity that is in m/s2 at all. One in g would be off by 8.81."""
MAX_TURN_RATE: Final = 6.5
"""Turn rate that no chair has, rad/s: a turn a second. A slow turn in degrees a second exceeds it."""
MAX_ACCELERATION: Final = 30.0
"""Acceleration that no chair has, m/s2: a fall on a hard floor."""
MAX_POINT: Final = 100.0
"""Coordinate that no ultrasonic or radar sensor of a chair reports, m. One in mm exceeds it from 0.1 m on."""
MAX_POINTS: Final = 4096
"""Points of one message that are used; a message of the largest size may have more."""
WITHOUT_MAGNET: Final = 10.0
"""Degrees by which one wheel turns while the other one reads 0 throughout: the other one has lost its magnet."""
WRAP: Final = 5.0
"""Jump of an angle in radians that wraps. One in degrees may jump as far in a fast chair, but then leaves [0, 2 pi]."""
AFTER_WRAP: Final = 0.3
"""Turn after such a jump, still within [0, 2 pi], at which the angles are taken for radians."""
STICK: Final = 100
"""Full deflection of a joystick on the wire."""


def points_of(message: Any, place: str) -> list[Point]:
    """Return the points of a message from the ultrasonic or radar sensors in our frame.

    Args:
        message: An `UltrasonicDistances` or a `RadarPoints`.
        place: What errors name.

    Raises:
        WireError: `value`, when a point is not in metres.
    """
    found: Iterable[Any] = message.points if place == "RadarPoints" else _arc_points(message)
    points = []
    for point, _ in zip(found, range(MAX_POINTS), strict=False):
        if not (abs(point.x) <= MAX_POINT and abs(point.y) <= MAX_POINT):
            raise _value_error(f"{place}.points", f"metres in [-{MAX_POINT:g}, {MAX_POINT:g}]", (point.x, point.y))
        points.append((float(point.y), -float(point.x)))
    return points


def _arc_points(message: Any) -> Iterable[Any]:
    return (point for distance in message.distances for point in distance.arc_points)


def nearest(sonars: Sequence[Proximity], points: Sequence[Point] | None) -> tuple[ProximityReading, ...]:
    """Return a reading for each sonar: the distance to the nearest point inside its cone.

    Args:
        sonars: As the robot document declares them, mounted on the body.
        points: The points of the chair's ultrasonic and radar sensors; None when it sends none, which is a fault.
    """
    if points is None:
        return tuple(ProximityReading(id=sonar.id, status="fault") for sonar in sonars)
    return tuple(_reading(sonar, points) for sonar in sonars)


def _reading(sonar: Proximity, points: Sequence[Point]) -> ProximityReading:
    axis, half = math.radians(sonar.direction_deg), math.radians(sonar.cone_deg) / 2.0
    distances = []
    for x, y in points:
        dx, dy = x - sonar.x, y - sonar.y
        off_axis = math.remainder(math.atan2(dy, dx) - axis, 2.0 * math.pi)
        if abs(off_axis) <= half:
            distances.append(math.hypot(dx, dy))
    distance = min(distances, default=math.inf)
    if distance > sonar.max_range:
        return ProximityReading(id=sonar.id, status="none")
    if distance < sonar.min_range:
        return ProximityReading(id=sonar.id, status="near")
    return ProximityReading(id=sonar.id, value=distance)


def motion_of(message: Any) -> tuple[float, float, float]:
    """Return acceleration forward and to the left, m/s2, and turn rate, rad/s, of an `ImuData`.

    Raises:
        WireError: `value`, when they cannot be in these units.
    """
    gravity = math.hypot(message.gravity_x, message.gravity_y, message.gravity_z)
    if not abs(gravity - GRAVITY) <= GRAVITY_TOLERANCE:
        raise _value_error("ImuData.gravity", f"{GRAVITY} m/s2, at most {GRAVITY_TOLERANCE:g} off", gravity)
    forward, left, turn_rate = message.acceleration_y, -message.acceleration_x, message.gyro_z
    if not (abs(forward) <= MAX_ACCELERATION and abs(left) <= MAX_ACCELERATION):
        expected = f"m/s2 in [-{MAX_ACCELERATION:g}, {MAX_ACCELERATION:g}]"
        raise _value_error("ImuData.acceleration", expected, (forward, left))
    if not abs(turn_rate) <= MAX_TURN_RATE:
        raise _value_error("ImuData.gyro_z", f"rad/s in [-{MAX_TURN_RATE:g}, {MAX_TURN_RATE:g}]", turn_rate)
    return forward, left, turn_rate


def stick_of(message: Any, place: str) -> tuple[float, float]:
    """Return forward and turn of a `JoystickData`, in [-1, 1], turn positive to the left.

    Raises:
        WireError: `value`, when it is out of range.
    """
    forward, right = message.forward_back, message.left_right
    if not (abs(forward) <= STICK and abs(right) <= STICK):
        raise _value_error(place, f"whole numbers in [-{STICK}, {STICK}]", (forward, right))
    return forward / STICK, -right / STICK


class WheelTurns:
    """The turns of both wheels, from angles that wrap at 360 degrees."""

    def __init__(self, counts: int, reversed_wheels: frozenset[str] = frozenset()) -> None:
        """Create it without a reading.

        Args:
            counts: Encoder counts of one turn.
            reversed_wheels: Those of `left` and `right` whose angle decreases forward.
        """
        self._per_degree = counts / 360.0
        self._signs = [-1.0 if wheel in reversed_wheels else 1.0 for wheel in WHEELS]
        self._last: list[float | None] = [None, None]
        self._turned = [0.0, 0.0]
        self._way = [0.0, 0.0]
        # The other wheel's way when this one began to read 0.
        self._zero_since: list[float | None] = [None, None]
        self._are_degrees = False
        # The way of each wheel when its angle jumped as radians do.
        self._wrapped_at = [math.inf, math.inf]

    def update(self, left: float, right: float) -> tuple[int, int]:
        """Return the counts of the left and right wheel since the start, after another pair of angles.

        Raises:
            WireError: `value`, when an angle is not in degrees, or the magnet of a wheel is lost.
        """
        angles = (left, right)
        for wheel, angle in zip(WHEELS, angles, strict=True):
            if not 0.0 <= angle <= 360.0:
                raise _value_error(f"EncoderData.{wheel}_angle", "degrees in [0, 360]", angle)
        for side, angle in enumerate(angles):
            if angle == 0.0:  # no magnet, or the one of 4096 steps that is 0: the next angle makes up for it
                if self._zero_since[side] is None:
                    self._zero_since[side] = self._way[1 - side]
                continue
            self._zero_since[side] = None
            last = self._last[side]
            turned = 0.0 if last is None else math.remainder(angle - last, 360.0)
            self._last[side] = angle
            self._turned[side] += self._signs[side] * turned
            self._way[side] += abs(turned)
            if abs(turned) > WRAP:
                self._wrapped_at[side] = self._way[side]
        self._check_magnets(angles)
        self._are_degrees = self._are_degrees or max(angles) > 2.0 * math.pi + 0.01
        since_wrap = max(way - at for way, at in zip(self._way, self._wrapped_at, strict=True))
        if not self._are_degrees and since_wrap > AFTER_WRAP:
            raise _value_error("EncoderData", "degrees", f"angles up to 2 pi only: {left:g} and {right:g}")
        return round(self._turned[0] * self._per_degree), round(self._turned[1] * self._per_degree)

    @property
    def is_lost(self) -> bool:
        """Whether the last angle of a wheel is not known."""
        return None in self._last

    def forget_angles(self) -> None:
        """Take the next angles as they are: after a long silence the turns between are unknown."""
        self._last = [None, None]

    def _check_magnets(self, angles: tuple[float, float]) -> None:
        for side, wheel in enumerate(WHEELS):
            since = self._zero_since[side]
            if since is not None and (angles[1 - side] == 0.0 or self._way[1 - side] - since > WITHOUT_MAGNET):
                self._last[side] = None
                raise _value_error(f"EncoderData.{wheel}_angle", "the angle of a magnet", "0, as without one")


def _value_error(place: str, expected: str, got: object) -> WireError:
    return WireError("value", f"{place}: expected {expected}, got {got}", place)
