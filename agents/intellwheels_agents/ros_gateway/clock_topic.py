"""The topic `/clock`: the simulated time of the run, from whoever knows it first. Pure but for a lock."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any, Final

from intellwheels_agents.ros_gateway.chair_messages import Topic
from intellwheels_agents.ros_gateway.rmw_wire import Qos
from intellwheels_agents.ros_gateway.ros_messages import time_message
from intellwheels_agents.ros_gateway.ros_types import made_of

CLOCK: Final = Topic("/clock", "rosgraph_msgs/msg/Clock", Qos(depth=1, reliable=False))
REPEAT: Final = 0.4
"""Wall seconds after which the same time is published again, for nodes that come while a run is paused."""


class ClockTopic:
    """Publishes each time once, and repeats it while it stands still. A run that is over is never published again.

    Attributes:
        time: The last time, s; 0 before the first.
    """

    def __init__(self, publish: Callable[[Any], None]) -> None:
        """Take what publishes a message."""
        self.time = 0.0
        self._publish = publish
        self._run = ""
        self._past: set[str] = set()
        self._told_at = 0.0
        self._lock = threading.Lock()

    def tell(self, run: str, seconds: float, now: float) -> None:
        """Take the time of a run.

        Args:
            run: The run.
            seconds: Its simulated time.
            now: Seconds of a monotonic clock.
        """
        with self._lock:
            if run in self._past:
                return
            if run == self._run:
                if seconds < self.time or (seconds == self.time and now - self._told_at < REPEAT):
                    return
            elif self._run:
                self._past.add(self._run)
            self._run, self.time, self._told_at = run, seconds, now
            self._publish(made_of("rosgraph_msgs/msg/Clock")(clock=time_message(seconds)))
