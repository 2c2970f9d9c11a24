"""Where poses come from: `raw` counts, `calibrated` ones by what UMBmark found, those `corrected` by fixes. Pure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal, get_args

from intellwheels_agents.bridge.hardware_driver import Reading
from intellwheels_agents.bridge.pose_estimate import Figures, PoseEstimate, figures_of
from intellwheels_schemas.messages import Position, Robot

PoseSourceName = Literal["raw", "calibrated", "corrected"]
POSE_SOURCES: Final[Sequence[PoseSourceName]] = get_args(PoseSourceName)

DRIFT: Final = 1e-5
"""m2 a metre and wheel. With a track of 0.57 m the heading is unsure by 8 mrad after a metre, more than the 3.5 mrad
by which wheels that differ by 0.2 % turn a chair, so fixes a metre apart are believed where they contradict those."""


@dataclass(frozen=True, slots=True)
class Calibration:
    """What a calibration found: `WheelRatio` (E_d), `WheelScale`, `TrackRatio` (E_b)."""

    ratio: float = 1.0
    scale: float = 1.0
    track_ratio: float = 1.0


class PoseSource:
    """Readings in, an estimate out.

    Attributes:
        estimate: The pose, or None before the first reading.
        left, right: Counts since the first reading, over all eras.
        stale: Readings dropped because a newer one was here already.
        lost: Readings that never came, as far as seen.
    """

    def __init__(
        self,
        robot: Robot,
        name: PoseSourceName,
        calibration: Calibration | None = None,
        *,
        drift: float = DRIFT,
        returns: bool = False,
    ) -> None:
        """Make a source without a pose.

        Args:
            robot: The chair's data sheet.
            name: Which source; `raw` takes the data sheet whatever the calibration says.
            calibration: What the others take.
            drift: k of the covariance.
            returns: Whether the chair stands at its start again when an era begins.
        """
        found = calibration if calibration is not None and name != "raw" else Calibration()
        self._figures: Figures = figures_of(robot, found.ratio, found.scale, found.track_ratio)
        self._fixes = name == "corrected"
        self._drift = drift
        self._returns = returns
        self._start: Position | None = None
        self._last: Reading | None = None
        self.estimate: PoseEstimate | None = None
        self.left = self.right = 0
        self.stale = self.lost = 0

    def begin(self, start: Position) -> None:
        """Be told where the chair stands when it is first heard of, and stands again if it `returns`."""
        if self._start is None:
            self._start = start

    def renew(self) -> None:
        """Forget every reading: the chair is at its start again."""
        self.estimate = self._last = None
        self.left = self.right = 0

    @property
    def start(self) -> Position:
        """Where it began."""
        if self._start is None:
            raise RuntimeError("a pose source was asked before it was told where it begins")
        return self._start

    def take(self, reading: Reading) -> bool:
        """Take a reading; return whether it was news."""
        last = self._last
        if last is not None and reading.era == last.era and reading.seq <= last.seq:
            self.stale += 1
            return False
        if self.estimate is None or (last is not None and reading.era != last.era and self._returns):
            self.estimate = PoseEstimate(self.start, self._drift)
            self.left = self.right = 0
        elif last is not None and reading.era == last.era:
            self.lost += reading.seq - last.seq - 1
            self._roll(self.estimate, reading.left - last.left, reading.right - last.right)
        self._last = reading
        if self._fixes and reading.fix is not None:
            self.estimate.fix(reading.fix)
        return True

    def _roll(self, estimate: PoseEstimate, left: int, right: int) -> None:
        self.left += left
        self.right += right
        estimate.roll(left * self._figures.left, right * self._figures.right, self._figures.track)
