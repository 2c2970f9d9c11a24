"""A chair that another mind drives: its measures become topics, and goals of ROS become those of its user."""

from __future__ import annotations

import contextlib
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
from intellwheels_schemas.crew_messages import split_measures
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import AgentMeasures, Body, Measures, Robot
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
        self._crew: str | None = None
        self._crew_measures: Any = None

    def run(self, stop: threading.Event, tell: Callable[[str], None]) -> None:
        """Watch until `stop` is set; `tell` prints the line that says that the chair is there."""
        inbox, agent = Inbox(), self._agent
        session, keys = self._session, self._keys
        publisher = link.declare(session, keys.user(agent), CHANNELS["user"], Encoding.JSON)
        with (
            publisher,
            session.declare_subscriber(keys.measures(agent), inbox.on_sample),
            session.declare_subscriber(keys.body(agent), inbox.on_sample),
            contextlib.closing(self),
        ):
            self._ask_crew(inbox)
            while not stop.is_set():
                inbox.wait(GOAL_DELAY)
                for arrival in inbox.take():
                    if isinstance(arrival, Put) and arrival.key == keys.body(agent):
                        self._take_body(arrival, inbox)
                    elif isinstance(arrival, Put):
                        self._take(arrival, tell)
                for _, message in self._goals.take():
                    try:
                        publisher.put(encode(user_goal(message)))
                    except WireError as error:
                        self._goals.refuse(error)

    def close(self) -> None:
        """End the subscription to the measures of a crew, if there is one."""
        if self._crew_measures is not None:
            self._crew_measures.undeclare()
            self._crew_measures = None

    def _ask_crew(self, inbox: Inbox) -> None:
        """Find out in which crew the chair is, if it is here already; else its body will be published."""
        with contextlib.suppress(ConnectionError):
            self._follow(self._world.body(self._agent).robot.crew, inbox)

    def _take_body(self, put: Put, inbox: Inbox) -> None:
        try:
            body = decode(Body, put.data, encoding_of(put.encoding, put.data), strict=False)
        except WireError as error:
            self._log(f"dropped key={put.key} why={error.text!r}")
            return
        self._follow(body.robot.crew, inbox)

    def _follow(self, crew: str | None, inbox: Inbox) -> None:
        """Subscribe to the measures of the crew that the chair is in now."""
        if crew == self._crew:
            return
        self.close()
        self._crew = crew
        if crew is not None:
            self._crew_measures = self._session.declare_subscriber(self._keys.crew_measures(crew), inbox.on_sample)

    def _measures(self, put: Put) -> Measures | None:
        """Return the measures of the chair; None if those of a crew have none of it.

        Raises:
            WireError: They cannot be read.
        """
        encoding = encoding_of(put.encoding, put.data)
        if self._keys.parse_crew_measures(put.key) is None:
            return decode(Measures, put.data, encoding, strict=False)
        own = split_measures(put.data, encoding).measures.get(self._agent)
        return None if own is None else decode(AgentMeasures, own, encoding, strict=False)

    def _take(self, put: Put, tell: Callable[[str], None]) -> None:
        try:
            measures = self._measures(put)
        except WireError as error:
            self._log(f"dropped key={put.key} why={error.text!r}")
            return
        # The period follows from a tick, so the first tick of a run cannot be told.
        if measures is None or tick_length(measures) is None:
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
