"""A chair that a ROS node drives: at each tick its messages go out, and the velocity that counts becomes powers.

In lockstep the mind can wait for the velocity that answers a tick. A stamped one answers the tick of its stamp and all
before; one without a stamp answers every tick that was published before it arrived.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from typing import Any, Final, Protocol

from intellwheels_agents.mind import Context
from intellwheels_agents.ros_gateway.chair_messages import ChairMessages, Localisation, Topic, chair_topics
from intellwheels_agents.ros_gateway.plane_pose import PlanePose
from intellwheels_agents.ros_gateway.ros_names import ros_name
from intellwheels_agents.ros_gateway.velocity_command import VelocityCommand
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Actions, Measures
from intellwheels_schemas.process import SLICE

_HALF: Final = 0.5


class Publishing(Protocol):
    """Where messages go: a node."""

    def advertise(self, topics: Sequence[Topic]) -> None:
        """Declare topics."""
        ...

    def publish(self, topic: str, message: Any) -> None:
        """Send a message."""
        ...


class Commands(Protocol):
    """Where velocities come from: the inbox of a topic."""

    def take(self) -> list[tuple[str, Any]]:
        """Return the messages that have arrived: name of the type, and message."""
        ...

    def wait(self, seconds: float) -> bool:
        """Wait for a message."""
        ...

    def refuse(self, error: WireError) -> None:
        """Tell that a message is not obeyed."""
        ...


class RosMind:
    """Publishes measures and obeys velocities, for one run."""

    def __init__(
        self,
        context: Context,
        node: Publishing,
        commands: Commands,
        *,
        localisation: Localisation,
        await_command: float,
        tell_clock: Callable[[str, float, float], None],
        stop: threading.Event,
    ) -> None:
        """Begin a run: advertise the topics of the robot, and publish its fixed transforms.

        Args:
            context: The run.
            node: Publishes.
            commands: Velocities that arrive.
            localisation: Where the pose of `odom` on the map comes from.
            await_command: Wall seconds for which a tick of a lockstep waits for a velocity.
            tell_clock: Takes the run, its time and the monotonic clock at each tick, before the messages.
            stop: Ends a wait.
        """
        chair, start = ros_name(context.agent), context.position
        self._run = context.run
        self._node = node
        self._commands = commands
        self._tell_clock = tell_clock
        self._stop = stop
        self._period = context.parameters.period
        self._await = await_command if context.parameters.pace == "lockstep" else 0.0
        self._velocity = VelocityCommand(chair, context.robot)
        self._messages = ChairMessages(
            chair, context.robot, self._period, PlanePose(start.x, start.y, start.heading), localisation
        )
        commands.take()  # of the last run
        node.advertise(chair_topics(chair, context.robot))
        node.publish(*self._messages.static())

    def decide(self, measures: Measures) -> Actions:
        """Publish the measures of a tick, and return the powers of the velocity that counts."""
        now = measures.time
        # What came before the messages of this tick does not answer it, but counts.
        self._take(now)
        self._tell_clock(self._run, now, time.monotonic())
        for message in self._messages.messages(measures):
            self._node.publish(*message)
        if self._await > 0.0:
            self._wait(now)
        left, right = self._velocity.powers(now)
        return Actions(left_motor=left, right_motor=right, mode="ros")

    def _wait(self, now: float) -> None:
        deadline = time.monotonic() + self._await
        while (left := deadline - time.monotonic()) > 0.0 and not self._stop.is_set():
            if self._commands.wait(min(left, SLICE)):
                self._take(now)
                if self._velocity.stamp > now - self._period * _HALF:
                    return

    def _take(self, now: float) -> None:
        for kind, message in self._commands.take():
            try:
                self._velocity.take(kind, message, now)
            except WireError as error:
                self._commands.refuse(error)
