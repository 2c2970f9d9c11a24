"""A chair's pose and its covariance, from wheel travel and position fixes: an extended Kalman filter. Pure.

The state is (x, y, h) with covariance P. The error of a wheel that rolls s metres is normal with variance k |s|. With
l and r the travel of the wheels, b the track, d = (l + r) / 2, t = (r - l) / b and m = h + t / 2, the chair moves by
the chord c = d sin(t / 2) / (t / 2):

    x' = x + c cos m,  y' = y + c sin m,  h' = h + t,        P' = F P F' + G diag(k |l|, k |r|) G'

F is the derivative by the pose, G the one by l and r. A fix z of the body's point (p, q) has variance s2 on each axis:

    z = (x + p cos h - q sin h, y + p sin h + q cos h) + noise,   S = H P H' + s2 I,   K = P H' S^-1

Source:
    Thrun, Burgard and Fox, Probabilistic Robotics (2005), chapters 3 and 7. The arc is exact, as in
    `differential_drive.Odometry`; the wheel errors are those of the simulator's `Encoders.Drift`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

from intellwheels_agents.bridge.hardware_driver import Fix
from intellwheels_agents.differential_drive import wrapped
from intellwheels_agents.portable_math import sin, sincos
from intellwheels_schemas.messages import Position, Robot

MIN_SD: Final = 1e-3
"""Smallest standard deviation of a fix, in metres. A fix without error would make the matrix S singular."""

Covariance = tuple[float, float, float, float, float, float]
"""xx xy xh yy yh hh, in the order of `Pose.Covariance`."""
ZERO: Final[Covariance] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class WheelGeometry:
    """The dimensions that turn encoder counts into metres.

    Attributes:
        left, right: Metres a count.
        track: Metres between the wheels.
    """

    left: float
    right: float
    track: float


def wheel_geometry(robot: Robot, ratio: float = 1.0, scale: float = 1.0, track_ratio: float = 1.0) -> WheelGeometry:
    """Return the wheel geometry of a robot, corrected by a calibration.

    Args:
        robot: Gives the nominal track, wheel diameter and counts a turn.
        ratio: E_d of UMBmark, right wheel over left wheel; their mean stays.
        scale: Mean wheel over the nominal one.
        track_ratio: E_b of UMBmark, track over the nominal one.

    Source:
        Borenstein and Feng (1996), Measurement and correction of systematic odometry errors in mobile robots, IEEE
        Transactions on Robotics and Automation 12(6).
    """
    count = scale * math.pi * robot.wheel_diameter / robot.encoder_ticks
    left = 2.0 / (1.0 + ratio)
    return WheelGeometry(count * left, count * left * ratio, robot.track * track_ratio)


class PoseEstimate:
    """A pose and its covariance.

    Attributes:
        x, y: Metres, in the map's frame.
        heading: Radians, in (-pi, pi].
        covariance: Of x, y and heading, in metres and radians.
    """

    def __init__(self, start: Position, drift: float, covariance: Covariance = ZERO) -> None:
        """Start at a pose.

        Args:
            start: The pose.
            drift: k, the variance of a wheel's travel in m2 a metre.
            covariance: The covariance of the start.
        """
        self.x = start.x
        self.y = start.y
        self.heading = wrapped(start.heading)
        self.covariance = covariance
        self._drift = drift

    def predict(self, left: float, right: float, track: float) -> None:
        """Move along the arc of both wheels' travel; all three in metres."""
        travel, turn = (left + right) / 2.0, (right - left) / track
        half = turn / 2.0
        share = sin(half) / half if abs(half) > 1e-6 else 1.0 - half * half / 6.0
        sine, cosine = sincos(self.heading + half)
        dx, dy = travel * share * cosine, travel * share * sine
        # A metre of one wheel moves the centre by half a metre and turns it by 1 / b, half of that before the chord.
        bent = travel / (2.0 * track)
        by_left = (cosine / 2.0 + bent * sine, sine / 2.0 - bent * cosine, -1.0 / track)
        by_right = (cosine / 2.0 - bent * sine, sine / 2.0 + bent * cosine, 1.0 / track)
        covariance = _propagated(self.covariance, dx, dy)
        covariance = _with_noise(covariance, by_left, self._drift * abs(left))
        self.covariance = _with_noise(covariance, by_right, self._drift * abs(right))
        self.x += dx
        self.y += dy
        self.heading = wrapped(self.heading + turn)

    def update(self, fix: Fix) -> None:
        """Correct the pose by a position from outside."""
        s, c = sincos(self.heading)
        arm_x, arm_y = fix.offset_x * c - fix.offset_y * s, fix.offset_x * s + fix.offset_y * c
        xx, xy, xh, yy, yh, hh = self.covariance
        # Columns of P H': the derivative of the point by the heading is (-arm_y, arm_x).
        first = (xx - arm_y * xh, xy - arm_y * yh, xh - arm_y * hh)
        second = (xy + arm_x * xh, yy + arm_x * yh, yh + arm_x * hh)
        sd = max(fix.sd, MIN_SD)
        noise = sd * sd
        s11 = first[0] - arm_y * first[2] + noise
        s12 = second[0] - arm_y * second[2]
        s22 = second[1] + arm_x * second[2] + noise
        determinant = s11 * s22 - s12 * s12
        error_x, error_y = fix.x - self.x - arm_x, fix.y - self.y - arm_y
        gain = [
            ((a * s22 - b * s12) / determinant, (b * s11 - a * s12) / determinant)
            for a, b in zip(first, second, strict=True)
        ]
        self.x += gain[0][0] * error_x + gain[0][1] * error_y
        self.y += gain[1][0] * error_x + gain[1][1] * error_y
        self.heading = wrapped(self.heading + gain[2][0] * error_x + gain[2][1] * error_y)

        def reduced(i: int, j: int, old: float) -> float:
            return old - gain[i][0] * first[j] - gain[i][1] * second[j]

        self.covariance = (
            max(reduced(0, 0, xx), 0.0), reduced(0, 1, xy), reduced(0, 2, xh),
            max(reduced(1, 1, yy), 0.0), reduced(1, 2, yh), max(reduced(2, 2, hh), 0.0),
        )  # fmt: skip


def _propagated(covariance: Covariance, dx: float, dy: float) -> Covariance:
    """Return F P F' for a move by (dx, dy): the uncertainty of the heading spreads to the position."""
    xx, xy, xh, yy, yh, hh = covariance
    return (
        xx - 2.0 * dy * xh + dy * dy * hh,
        xy - dy * yh + dx * xh - dx * dy * hh,
        xh - dy * hh,
        yy + 2.0 * dx * yh + dx * dx * hh,
        yh + dx * hh,
        hh,
    )


def _with_noise(covariance: Covariance, by: tuple[float, float, float], variance: float) -> Covariance:
    """Return a covariance plus that of one noise source. `by` is the derivative of the pose by that noise."""
    (x, y, h), (xx, xy, xh, yy, yh, hh) = by, covariance
    v = variance
    return (xx + v * x * x, xy + v * x * y, xh + v * x * h, yy + v * y * y, yh + v * y * h, hh + v * h * h)
