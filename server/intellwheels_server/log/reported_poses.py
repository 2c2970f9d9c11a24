"""The poses that bridges reported for real chairs, to be shown beside the true ones.

An experiment with a laboratory has two logs. The log of the laboratory has the true poses. The log of the world that
its chairs joined has the reported ones, because in that world a real body is at the pose that its bridge reports. The
two worlds are paired as a bridge pairs them: run by run, tick by tick.
"""

from __future__ import annotations

from intellwheels_schemas.messages import Pose
from intellwheels_server.log.seekable_log import Place, SeekableLog
from intellwheels_server.world import State
from intellwheels_server.world.kernels import rows


class ReportedPoses:
    """The reported poses in one log, by the run and tick of another log.

    Args:
        runs: The runs of the log that is played, in their order.
        recording: The log of the world in which the chairs are real. The caller closes it.
    """

    def __init__(self, runs: tuple[str, ...], recording: SeekableLog) -> None:
        self._recording = recording
        self._pairs = dict(zip(runs, recording.runs, strict=False))
        self._place: Place | None = None

    def at(self, run: str, tick: int) -> dict[str, Pose]:
        """Return the last reported pose of each real chair at a tick; empty if the log has no such tick.

        Args:
            run: The run in the log that is played; the poses carry its name.
            tick: The tick, in both logs.
        """
        pair = self._pairs.get(run)
        place = None if pair is None else self._place_at(pair, tick)
        return {} if place is None else _poses(place.state, run)

    def _place_at(self, run: str, tick: int) -> Place | None:
        place = self._place
        if place is None or place.state.run != run or place.state.tick not in (tick, tick - 1):
            try:
                place = self._recording.go_to(run, tick)
            except LookupError:
                place = None
        # The next tick may be a few lines away, as changes may come before its step.
        while place is not None and place.state.tick < tick:
            place = self._recording.next_place(place) if place.position < self._recording.end else None
            if place is not None and place.state.run != run:
                place = None
        self._place = place
        return place


def _poses(state: State, run: str) -> dict[str, Pose]:
    found = {}
    for i, name in enumerate(state.names):
        if state.body_set.models[name].externally_posed:
            x, y, heading = state.numbers[[rows.X, rows.Y, rows.HEADING], i].tolist()
            found[name] = Pose(run=run, tick=state.tick, x=x, y=y, heading=heading)
    return found
