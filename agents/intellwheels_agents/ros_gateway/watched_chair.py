"""A chair that another mind drives: its measures become topics, and goals of ROS become those of its user."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any, Final

from intellwheels_agents.ros_gateway.chair_goal import user_goal
from intellwheels_agents.ros_gateway.chair_messages import ChairMessages, Localisation, chair_topics, tick_length
from intellwheels_agents.ros_gateway.plane_pose import PlanePose
from intellwheels_agents.ros_gateway.ros_mind import Commands, Publishing
from intellwheels_agents.ros_gateway.ros_names import ros_name
from intellwheels_agents.ros_gateway.world_link import TRY_EVERY, WorldQueries
from intellwheels_schemas import link
from intellwheels_schemas.channels import CHANNELS
from intellwheels_schemas.codec import Encoding, decode, encode, encoding_of
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import Measures, Robot
from intellwheels_schemas.zenoh_inbox import Inbox, Put

GOAL_DELAY: Final = 0.05
"""Longest wait for measures before goals are looked for, s."""


class WatchedChair:
    """Watches one chair until it is stopped."""

    def __init__(
        self, session: Any, keys: Keys, world: WorldQueries, agent: str, node: Publishing, goals: Commands, *,
        localisation: Localisation, tell_clock: Callable[[str, float, float], None], log: Callable[[str], None],
    ) -> None:  # fmt: skip
        """Take the chair and the node.

        Args:
            session: An open session of the world.
            keys: The keys of the world.
            world: Answers for the body.
            agent: The chair's agent.
            node: Publishes the topics.
            goals: Goals that arrive.
            localisation: Where the pose of `odom` on the map comes from.
            tell_clock: Takes the run, its time and the monotonic clock at each tick.
            log: Takes lines for the log.
        """
        self._session = session
        self._keys = keys
        self._world = world
        self._agent = agent
        self._node = node
        self._goals = goals
        self._localisation = localisation
        self._tell_clock = tell_clock
        self._log = log
        self._robot: Robot | None = None
        self._messages: ChairMessages | None = None
        self._run = ""
        self._try_at = 0.0

    def run(self, stop: threading.Event, tell: Callable[[str], None]) -> None:
        """Watch until `stop` is set; `tell` prints the line that says that the chair is there."""
        inbox, agent = Inbox(), self._agent
        publisher = link.declare(self._session, self._keys.user(agent), CHANNELS["user"], Encoding.JSON)
        with publisher, self._session.declare_subscriber(self._keys.measures(agent), inbox.on_sample):
            while not stop.is_set():
                inbox.wait(GOAL_DELAY)
                for arrival in inbox.take():
                    if isinstance(arrival, Put):
                        self._take(arrival, tell)
                for _, message in self._goals.take():
                    try:
                        publisher.put(encode(user_goal(message)))
                    except WireError as error:
                        self._goals.refuse(error)

    def _take(self, put: Put, tell: Callable[[str], None]) -> None:
        try:
            measures = decode(Measures, put.data, encoding_of(put.encoding, put.data), strict=False)
        except WireError as error:
            self._log(f"dropped key={put.key} why={error.text!r}")
            return
        # The period follows from a tick, so the first tick of a run cannot be told.
        if tick_length(measures) is None:
            return
        known = measures.run == self._run and self._messages is not None and self._messages.takes(measures)
        if not known and not self._begin(measures, tell):
            return
        if self._messages is not None:
            self._tell_clock(measures.run, measures.time, time.monotonic())
            for message in self._messages.messages(measures):
                self._node.publish(*message)

    def _begin(self, measures: Measures, tell: Callable[[str], None]) -> bool:
        """Begin a run; return whether the body of the chair is known."""
        if time.monotonic() < self._try_at:
            return False
        self._try_at = time.monotonic() + TRY_EVERY
        try:
            robot = self._world.body(self._agent).robot
            _, entities = self._world.entities()
        except ConnectionError:
            return False
        here = next((PlanePose(one.x, one.y, one.heading) for one in entities if one.name == self._agent), None)
        chair, period = ros_name(self._agent), measures.time / measures.tick
        localisation = self._localisation
        if here is None and localisation == "start":
            localisation = "none"
            self._log("no transform from map to odom: the world hides true poses")
        messages = ChairMessages(chair, robot, period, here or PlanePose(0.0, 0.0, 0.0), localisation, moved=True)
        self._node.advertise(chair_topics(chair, robot))
        self._node.publish(*messages.static())
        self._messages, self._run = messages, measures.run
        tell(f"watching agent={self._agent} run={measures.run}")
        return True
