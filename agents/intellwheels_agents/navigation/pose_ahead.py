"""Where a body will be when its next command acts, from the last known pose and the commands that act before."""

from __future__ import annotations

from intellwheels_agents.differential_drive import wrapped
from intellwheels_agents.navigation.scan_points import Pose
from intellwheels_agents.portable_math import sincos
from intellwheels_agents.wheel_motors import CommandLateness, Wheels
from intellwheels_schemas.messages import Actions, Measures, Robot


class PoseAhead:
    """The pose of one body when the next command acts.

    Attributes:
        pose: That pose.
        speed: The speed there, m/s.
        rate: The turn rate there, rad/s.
        time: The time from the last known pose to there, s.
    """

    def __init__(self, robot: Robot, period: float, pose: Pose) -> None:
        """Take the robot, the period of the simulation (s) and the pose at the start."""
        self._late = CommandLateness(robot, period)
        self._track, self._top, self._period = robot.track, robot.top_speed, period
        self._measured = bool(robot.encoders)
        if not self._measured:
            self._late.ticks = 0
        self.pose, self.speed, self.rate, self.time = pose, 0.0, 0.0, 0.0

    @property
    def blind(self) -> float:
        """Time for which the body drives on before a command acts on what was seen at the last known pose, s."""
        return self.time + self._period

    def update(self, measures: Measures, pose: Pose, tick: int) -> dict[int, Pose]:
        """Return the poses from a known one on, by tick.

        Args:
            measures: The measures of this tick.
            pose: The last known pose.
            tick: The tick of that pose.
        """
        readings = measures.sensors.encoders if measures.sensors else ()
        late = self._late
        # Without encoders the wheels roll as the motors say.
        if self._measured:
            late.update(measures, readings[0] if readings else None)
        else:
            late.roll_on(measures)
        now, known = late.speeds, {tick: pose}
        at = measures.tick if late.tick is None else late.tick
        x, y, heading = pose
        for command in late.pending(measures.tick):
            now, rolled = late.motors.cycle(now, command)
            at += 1
            if at > tick:
                x, y, heading = _driven((x, y, heading), rolled, self._track)
                if at <= measures.tick:
                    known[at] = x, y, heading
        self.pose = x, y, heading
        self.speed, self.rate = (now.left + now.right) / 2.0, (now.right - now.left) / self._track
        self.time = (measures.tick + late.ticks - tick) * self._period
        return known

    def send(self, tick: int, actions: Actions) -> None:
        """Take the answer to a tick."""
        self._late.send(tick, Wheels((actions.left_motor or 0.0) * self._top, (actions.right_motor or 0.0) * self._top))


def _driven(pose: Pose, rolled: Wheels, track: float) -> Pose:
    travel, turn = (rolled.left + rolled.right) / 2.0, (rolled.right - rolled.left) / track
    s, c = sincos(pose[2] + turn / 2.0)
    return pose[0] + travel * c, pose[1] + travel * s, wrapped(pose[2] + turn)
