"""What is recorded of a world as ROS 2 nodes would see it: the topics of `iw-ros`, of every chair. Pure.

/clock, /map, /tf, /tf_static, /diagnostics
/<name>/odom, scan, imu, range/<id>, joint_states
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Any, Final, NamedTuple

from intellwheels_agents.map_cells import fitting_size
from intellwheels_agents.record_gateway.translator import MOST_TOPICS, Translator
from intellwheels_agents.ros_gateway.chair_messages import ChairMessages, Outgoing, Topic, chair_topics, tick_length
from intellwheels_agents.ros_gateway.clock_topic import CLOCK
from intellwheels_agents.ros_gateway.floor_grid import floor_grid
from intellwheels_agents.ros_gateway.plane_pose import PlanePose
from intellwheels_agents.ros_gateway.rmw_wire import LATCHED
from intellwheels_agents.ros_gateway.ros_messages import time_message
from intellwheels_agents.ros_gateway.ros_names import ros_name
from intellwheels_agents.ros_gateway.ros_types import made_of
from intellwheels_schemas.codec import decode, encoding_of
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import Clock, Map, Measures, Robot, WorldState

MAP_TOPIC: Final = Topic("/map", "nav_msgs/msg/OccupancyGrid", LATCHED)
PATIENCE: Final = 5
"""Ticks for which a chair waits for its true pose before it goes without the transform from `map` to `odom`."""
AHEAD: Final = 100
"""Ticks that measures may be ahead of the latest clock, as clocks may be lost."""


class BagEntry(NamedTuple):
    """A message of ROS to record, and its time, ns."""

    topic: Topic
    message: Any
    time: int


class _Chair(NamedTuple):
    robot: Robot
    topics: dict[str, Topic]
    messages: ChairMessages


class RosTranslator:
    """Translates the messages of one world, after the translator of the recording has seen them.

    Attributes:
        refused: Why chairs are left out, by agent: names that are one name in ROS, or too many topics.
    """

    def __init__(self, keys: Keys, translator: Translator) -> None:
        """Take the keys of the world, and who knows its times and robots."""
        self.refused: dict[str, str] = {}
        self._topics: set[str] = set()
        self._keys = keys
        self._known = translator
        self._run = ""
        self._clock = -1.0
        self._state: tuple[int, dict[str, PlanePose]] = (-1, {})
        self._waiting: dict[str, tuple[Measures, int]] = {}
        self._chairs: dict[str, _Chair] = {}

    def take(self, key: str, data: bytes, encoding: str) -> list[BagEntry]:
        """Return what to record of a message; nothing of bytes that are none."""
        keys = self._keys
        out = keys.parse_out(key)
        kind: type[Clock | WorldState | Measures]
        if key == keys.clock:
            kind = Clock
        elif keys.parse_state(key) is not None:
            kind = WorldState
        elif out is not None and out.kind == "measures":
            kind = Measures
        else:
            return []
        try:
            message = decode(kind, data, encoding_of(encoding, data), strict=False)
        except WireError:
            return []  # The translator has counted it.
        if message.run != self._known.times.run:
            return []
        if message.run != self._run:
            self._begin(message.run)
        if isinstance(message, Clock):
            return list(self._of_clock(message))
        if isinstance(message, WorldState):
            return list(self._of_state(message))
        return list(self._of_measures(out.agent, message)) if out is not None else []

    def take_map(self, document: Map) -> list[BagEntry]:
        """Return what to record of a map that was asked for."""
        grid = floor_grid(document, fitting_size(document), max(self._clock, 0.0))
        return [BagEntry(MAP_TOPIC, grid, self._known.times.now)]

    def _begin(self, run: str) -> None:
        self._run, self._clock, self._state = run, -1.0, (-1, {})
        self._waiting, self._chairs = {}, {}

    def _of_clock(self, clock: Clock) -> Iterator[BagEntry]:
        if clock.time > self._clock:
            self._clock = clock.time
            message = made_of("rosgraph_msgs/msg/Clock")(clock=time_message(clock.time))
            yield BagEntry(CLOCK, message, self._known.times.at(clock.time))

    def _of_state(self, state: WorldState) -> Iterator[BagEntry]:
        tick, poses = self._state
        if state.tick < tick:
            return
        found = {one.name: PlanePose(one.x, one.y, one.heading) for one in state.entity}
        self._state = state.tick, found if state.tick > tick else poses | found
        for agent, (measures, _) in list(self._waiting.items()):
            if measures.tick == state.tick and agent in found:
                yield from self._start(agent, measures, found[agent])

    def _of_measures(self, agent: str, measures: Measures) -> Iterator[BagEntry]:
        robot = self._known.robots.get(agent)
        if robot is None or agent in self.refused or not self._can_be(measures):
            return
        chair = self._chairs.get(agent)
        if chair is not None and chair.robot == robot and chair.messages.takes(measures):
            yield from self._entries(chair, chair.messages.messages(measures), measures)
            return
        tick, poses = self._state
        if tick == measures.tick and agent in poses:
            yield from self._start(agent, measures, poses[agent])
            return
        _, waited = self._waiting.get(agent, (measures, 0))
        self._waiting[agent] = measures, waited + 1
        if waited >= PATIENCE:
            yield from self._start(agent, measures, None)

    def _can_be(self, measures: Measures) -> bool:
        """Return whether measures fit the clock; those of a stranger may not."""
        seconds, clock = tick_length(measures), self._known.clock
        if seconds is None or clock is None or clock.tick < 1:
            return seconds is not None
        return measures.tick <= clock.tick + AHEAD and math.isclose(seconds, clock.time / clock.tick, rel_tol=0.01)

    def _start(self, agent: str, measures: Measures, pose: PlanePose | None) -> Iterator[BagEntry]:
        """Begin with a chair whose pose at these measures is known, or will not be."""
        self._waiting.pop(agent, None)
        name, robot = ros_name(agent), self._known.robots.get(agent)
        if robot is None:
            return
        other = next((one for one in self._chairs if one != agent and ros_name(one) == name), None)
        if other is not None:
            self._refuse(agent, f"expected a name that is not {name} in ROS, as that of {other} is")
            return
        try:
            topics = {topic.name: topic for topic in chair_topics(name, robot)}
        except WireError as error:
            self._refuse(agent, error.text)
            return
        if len(self._topics | topics.keys()) > MOST_TOPICS:
            self._refuse(agent, f"expected at most {MOST_TOPICS} topics of a bag, got more")
            return
        self._topics |= topics.keys()
        messages = ChairMessages(
            name, robot, measures.time / measures.tick, pose or PlanePose(0.0, 0.0, 0.0),
            "none" if pose is None else "start", moved=True,
        )  # fmt: skip
        chair = self._chairs[agent] = _Chair(robot, topics, messages)
        yield from self._entries(chair, [messages.static()], measures)
        yield from self._entries(chair, messages.messages(measures), measures)

    def _refuse(self, agent: str, why: str) -> None:
        # Strangers can put any number of names.
        if len(self.refused) < MOST_TOPICS:
            self.refused[agent] = why

    def _entries(self, chair: _Chair, outgoing: Iterable[Outgoing], measures: Measures) -> Iterator[BagEntry]:
        time = self._known.times.at(measures.time)
        for topic, message in outgoing:
            yield BagEntry(chair.topics[topic], message, time)
