"""Where a chair is, as far as its wheels and fixes tell, and how sure that is. Pure.

State (x, y, h) with covariance P. A wheel that rolls s metres is wrong by a normal number of variance k |s|. With
d = (l + r) / 2, t = (r - l) / b and m = h + t / 2 the chair goes along the chord c = d sin(t / 2) / (t / 2):

    x' = x + c cos m,  y' = y + c sin m,  h' = h + t,        P' = F P F' + G diag(k |l|, k |r|) G'

F is the derivative by the pose, G by l and r. A fix z of the point (p, q) of the body, variance s2 on both axes:

    z = (x + p cos h - q sin h, y + p sin h + q cos h) + noise,   S = H P H' + s2 I,   K = P H' S^-1

Source:
    The extended Kalman filter, as in Thrun, Burgard and Fox, Probabilistic Robotics (2005), chapters 3 and 7; the
    arc is the exact one of `chair.Odometry`, the errors of the wheels those of the simulator's `Encoders.Drift`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

from intellwheels_agents.bridge.hardware_driver import Fix
from intellwheels_agents.differential_drive import wrapped
from intellwheels_schemas.messages import Position, Robot

LEAST_SD: Final = 1e-3
"""Metres: a fix that claims to be exact would make the filter's matrix singular."""

Covariance = tuple[float, float, float, float, float, float]
"""xx xy xh yy yh hh, as `Pose.Covariance` has it."""
NOTHING: Final[Covariance] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Figures:
    """How counts become metres.

    Attributes:
        left, right: Metres a count.
        track: Metres between the wheels.
    """

    left: float
    right: float
    track: float


def figures_of(robot: Robot, ratio: float = 1.0, scale: float = 1.0, track_ratio: float = 1.0) -> Figures:
    """Return the figures of a robot, corrected by what a calibration found.

    Args:
        robot: Gives the nominal track, wheels and counts of a turn.
        ratio: E_d of UMBmark: the right wheel over the left one, at the same mean.
        scale: Mean wheel over the nominal one.
        track_ratio: E_b of UMBmark: track over the nominal one.

    Source:
        Borenstein and Feng (1996), Measurement and correction of systematic odometry errors in mobile robots, IEEE
        Transactions on Robotics and Automation 12(6).
    """
    count = scale * math.pi * robot.wheel_diameter / robot.encoder_ticks
    left = 2.0 / (1.0 + ratio)
    return Figures(count * left, count * left * ratio, robot.track * track_ratio)


class PoseEstimate:
    """A pose and its covariance.

    Attributes:
        x, y: Metres, in the map's frame.
        heading: Radians, in (-pi, pi].
        covariance: Of x, y and heading, in metres and radians.
    """

    def __init__(self, start: Position, drift: float, covariance: Covariance = NOTHING) -> None:
        """Start at a pose.

        Args:
            start: Where.
            drift: k, the variance of a wheel's way in m2 a metre rolled.
            covariance: How sure the start is.
        """
        self.x = start.x
        self.y = start.y
        self.heading = wrapped(start.heading)
        self.covariance = covariance
        self._drift = drift

    def roll(self, left: float, right: float, track: float) -> None:
        """Go on along the arc that both wheels rolled, in metres."""
        travel, turn = (left + right) / 2.0, (right - left) / track
        half = turn / 2.0
        share = math.sin(half) / half if abs(half) > 1e-6 else 1.0 - half * half / 6.0
        cos, sin = math.cos(self.heading + half), math.sin(self.heading + half)
        dx, dy = travel * share * cos, travel * share * sin
        # By one wheel: half the way goes on, and it turns by 1 / b, half of that before the chord's middle.
        bent = travel / (2.0 * track)
        by_left = (cos / 2.0 + bent * sin, sin / 2.0 - bent * cos, -1.0 / track)
        by_right = (cos / 2.0 - bent * sin, sin / 2.0 + bent * cos, 1.0 / track)
        grown = _carried(self.covariance, dx, dy)
        grown = _grown(grown, by_left, self._drift * abs(left))
        self.covariance = _grown(grown, by_right, self._drift * abs(right))
        self.x += dx
        self.y += dy
        self.heading = wrapped(self.heading + turn)

    def fix(self, fix: Fix) -> None:
        """Take a position from outside."""
        cos, sin = math.cos(self.heading), math.sin(self.heading)
        arm_x, arm_y = fix.offset_x * cos - fix.offset_y * sin, fix.offset_x * sin + fix.offset_y * cos
        xx, xy, xh, yy, yh, hh = self.covariance
        # Columns of P H': the derivative of the point by the heading is (-arm_y, arm_x).
        first = (xx - arm_y * xh, xy - arm_y * yh, xh - arm_y * hh)
        second = (xy + arm_x * xh, yy + arm_x * yh, yh + arm_x * hh)
        noise = max(fix.sd, LEAST_SD) ** 2
        s11 = first[0] - arm_y * first[2] + noise
        s12 = second[0] - arm_y * second[2]
        s22 = second[1] + arm_x * second[2] + noise
        determinant = s11 * s22 - s12 * s12
        off_x, off_y = fix.x - self.x - arm_x, fix.y - self.y - arm_y
        gain = [
            ((a * s22 - b * s12) / determinant, (b * s11 - a * s12) / determinant)
            for a, b in zip(first, second, strict=True)
        ]
        self.x += gain[0][0] * off_x + gain[0][1] * off_y
        self.y += gain[1][0] * off_x + gain[1][1] * off_y
        self.heading = wrapped(self.heading + gain[2][0] * off_x + gain[2][1] * off_y)

        def shrunk(i: int, j: int, old: float) -> float:
            return old - gain[i][0] * first[j] - gain[i][1] * second[j]

        self.covariance = (
            max(shrunk(0, 0, xx), 0.0), shrunk(0, 1, xy), shrunk(0, 2, xh),
            max(shrunk(1, 1, yy), 0.0), shrunk(1, 2, yh), max(shrunk(2, 2, hh), 0.0),
        )  # fmt: skip


def _carried(covariance: Covariance, dx: float, dy: float) -> Covariance:
    """Return F P F' of a way (dx, dy): what is unsure of the heading becomes unsure of the place."""
    xx, xy, xh, yy, yh, hh = covariance
    return (
        xx - 2.0 * dy * xh + dy * dy * hh,
        xy - dy * yh + dx * xh - dx * dy * hh,
        xh - dy * hh,
        yy + 2.0 * dx * yh + dx * dx * hh,
        yh + dx * hh,
        hh,
    )


def _grown(covariance: Covariance, by: tuple[float, float, float], variance: float) -> Covariance:
    """Return a covariance with that of one number added, whose effect on the pose is `by`."""
    (x, y, h), (xx, xy, xh, yy, yh, hh) = by, covariance
    v = variance
    return (xx + v * x * x, xy + v * x * y, xh + v * x * h, yy + v * y * y, yh + v * y * h, hh + v * h * h)
