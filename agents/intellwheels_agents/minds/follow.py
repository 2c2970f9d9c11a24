"""Follows a leader along the positions that the leader announces.

    leader   whom to follow: an agent whose mind is `waypoints` or `person` with lead=true, or any that says "at X Y" in
             metres (required)
    gap      distance kept to the leader's last position, along its path, m (default 2.0)
    speed    speed on straight stretches, m/s (default 0.8)
    stop     distance kept from obstacles in the way, m (default 0.4)
    silence  seconds without a message from the leader after which it stops (default 3.0)

It relies on messages and on its own odometry, and does not look for the leader. From its start it drives straight to
the first position that it hears.
"""

from __future__ import annotations

from intellwheels_agents.differential_drive import Odometry, powers
from intellwheels_agents.mind import Context
from intellwheels_agents.options import OptionError
from intellwheels_agents.path_follower import MIN_SPEED, PathFollower, braking
from intellwheels_agents.position_message import position_in
from intellwheels_agents.pure_pursuit import Path
from intellwheels_agents.range_scan import RangeScan
from intellwheels_schemas.messages import Actions, Goal, Measures


class Mind:
    """Follows its leader."""

    def __init__(self, context: Context) -> None:
        options, robot = context.options, context.robot
        if not robot.encoders:
            raise OptionError("mind follow: expected a robot with encoders, got one without")
        self._robot = robot
        self._gap = options.number("gap", 2.0, 0.1, 100.0)
        self._stop = options.number("stop", 0.4, 0.05, 10.0)
        self._silence = options.number("silence", 3.0, 0.1, 60.0)
        self._pilot = PathFollower(options.number("speed", 0.8, MIN_SPEED, 20.0))
        leaders = options.words("leader", "the name of an agent; required")
        if len(leaders) != 1:
            got = repr(" ".join(leaders)) if leaders else "none"
            raise OptionError(f"option leader: expected the name of the agent to follow, got {got}")
        (self._leader,) = leaders
        self._pose = Odometry(robot, context.position)
        self._scan = RangeScan(robot)
        self._path: Path | None = None
        self._heard_at: float | None = None

    def decide(self, measures: Measures) -> Actions:
        """Return the powers that follow the leader's path at a distance."""
        self._pose.update(measures.sensors)
        self._scan.update(measures.sensors)
        self._listen(measures)
        if self._path is None or self._heard_at is None:
            return Actions(left_motor=0.0, right_motor=0.0, mode="listening")
        path = self._path
        path.update(self._pose.x, self._pose.y)
        goal = Goal(x=path.end[0], y=path.end[1])
        if measures.time - self._heard_at >= self._silence:
            return Actions(left_motor=0.0, right_motor=0.0, mode="silent", goal=goal)
        stopping_distance = min(path.remaining - self._gap, self._scan.gap - self._stop)
        if braking(stopping_distance) < MIN_SPEED:
            return Actions(left_motor=0.0, right_motor=0.0, mode="near", goal=goal)
        steering = self._pilot.steer(path, self._pose, stopping_distance)
        turn_rate = steering.turn_rate if steering.turns else steering.speed * steering.curvature
        left, right = powers(self._robot, steering.speed, turn_rate)
        return Actions(left_motor=left, right_motor=right, mode="following", goal=goal)

    def _listen(self, measures: Measures) -> None:
        for message in measures.message:
            point = position_in(message.text) if message.sender == self._leader else None
            if point is None:
                continue
            self._heard_at = measures.time
            if self._path is not None:
                self._path.extend(point)
            elif point != (self._pose.x, self._pose.y):
                self._path = Path([(self._pose.x, self._pose.y), point])
