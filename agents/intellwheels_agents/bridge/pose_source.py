"""The source of poses: `raw` encoders, `calibrated` by UMBmark figures, or `corrected` by position fixes too. Pure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal, get_args

from intellwheels_agents.bridge.hardware_driver import Reading
from intellwheels_agents.bridge.pose_estimate import PoseEstimate, WheelGeometry, wheel_geometry
from intellwheels_schemas.messages import Position, Robot

PoseSourceName = Literal["raw", "calibrated", "corrected"]
POSE_SOURCES: Final[Sequence[PoseSourceName]] = get_args(PoseSourceName)

DRIFT: Final = 1e-5
"""Variance of a wheel's travel, m2 a metre. With a track of 0.57 m the heading has a standard deviation of 8 mrad after
a metre. That exceeds the 3.5 mrad by which wheels that differ by 0.2 % turn a chair, so fixes a metre apart win."""


@dataclass(frozen=True, slots=True)
class Calibration:
    """The result of a calibration.

    Attributes:
        wheel_ratio: E_d of UMBmark, right wheel over left wheel.
        wheel_scale: Mean wheel over the nominal one.
        track_ratio: E_b of UMBmark, track over the nominal one.
    """

    wheel_ratio: float = 1.0
    wheel_scale: float = 1.0
    track_ratio: float = 1.0


class PoseSource:
    """Turns readings into a pose estimate.

    Attributes:
        estimate: The pose, or None before the first reading.
        left, right: Counts since the first reading, over all epochs.
        overtaken: Number of readings dropped because a newer one had arrived before.
        missing: Number of readings that never came, counted by the gaps in `seq`.
    """

    def __init__(
        self,
        robot: Robot,
        name: PoseSourceName,
        calibration: Calibration | None = None,
        *,
        drift: float = DRIFT,
        restarts_at_start: bool = False,
    ) -> None:
        """Create a source that has no pose yet.

        Args:
            robot: The chair's nominal figures.
            name: Which source; `raw` ignores the calibration.
            calibration: Used by the other two.
            drift: Variance of a wheel's travel, m2 a metre.
            restarts_at_start: Whether the chair is back at its start when a new epoch begins.
        """
        used = calibration if calibration is not None and name != "raw" else Calibration()
        self._geometry: WheelGeometry = wheel_geometry(robot, used.wheel_ratio, used.wheel_scale, used.track_ratio)
        self._uses_fixes = name == "corrected"
        self._drift = drift
        self._restarts_at_start = restarts_at_start
        self._start: Position | None = None
        self._last: Reading | None = None
        self.estimate: PoseEstimate | None = None
        self.left = self.right = 0
        self.overtaken = self.missing = 0

    def set_start(self, start: Position) -> None:
        """Set the pose at the first reading; only the first call counts."""
        if self._start is None:
            self._start = start

    def reset(self) -> None:
        """Forget every reading, because the chair is back at its start."""
        self.estimate = self._last = None
        self.left = self.right = 0

    @property
    def start(self) -> Position:
        """The pose at the first reading."""
        if self._start is None:
            raise RuntimeError("PoseSource.start was read before set_start")
        return self._start

    def add(self, reading: Reading) -> bool:
        """Add a reading; return False when it was dropped because a newer one had arrived before."""
        last = self._last
        if last is not None and reading.epoch == last.epoch and reading.seq <= last.seq:
            self.overtaken += 1
            return False
        if self.estimate is None or (last is not None and reading.epoch != last.epoch and self._restarts_at_start):
            self.estimate = PoseEstimate(self.start, self._drift)
            self.left = self.right = 0
        elif last is not None and reading.epoch == last.epoch:
            self.missing += reading.seq - last.seq - 1
            self._predict(self.estimate, reading.left - last.left, reading.right - last.right)
        self._last = reading
        if self._uses_fixes and reading.fix is not None:
            self.estimate.update(reading.fix)
        return True

    def _predict(self, estimate: PoseEstimate, left: int, right: int) -> None:
        self.left += left
        self.right += right
        estimate.predict(left * self._geometry.left, right * self._geometry.right, self._geometry.track)
