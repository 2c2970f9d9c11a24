"""What is recorded of each message of a world: messages of Foxglove, and the message itself as JSON. Pure.

Bytes that are no message of their key are counted and left out. A stranger can put any number of keys, so the number
of topics is bounded.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Mapping
from typing import Any, Final, NamedTuple

from foxglove.messages import LogLevel

from intellwheels_agents.map_cells import map_cells
from intellwheels_agents.record_gateway import motion_messages as motion
from intellwheels_agents.record_gateway import scene_messages as scene
from intellwheels_agents.record_gateway.run_times import RunTimes, Ticks
from intellwheels_schemas.codec import decode, encode, encoding_of
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import (
    Actions,
    Body,
    Clock,
    Entity,
    Error,
    Event,
    Map,
    MapInfo,
    Measures,
    Pose,
    PowerInForce,
    Record,
    Robot,
    Say,
    UserInput,
    WorldState,
)
from intellwheels_schemas.messages import Record as Message

MOST_TOPICS: Final = 4096
"""Topics of a recording; messages on more are left out."""
RUNS_KNOWN: Final = 16
"""Past runs whose late messages are recognised."""
RETURNS: Final = 1.0
"""Seconds after which a past run whose clock still comes is the current one again."""
_TO_AGENT: Final[Mapping[str, type[Record]]] = {"measures": Measures, "power": PowerInForce, "error": Error}
_FROM_AGENT: Final[Mapping[str, type[Record]]] = {"actions": Actions, "say": Say, "pose": Pose}


class Entry(NamedTuple):
    """A message to record.

    Attributes:
        topic: Its topic.
        message: A message of Foxglove, or JSON.
        time: Its time, ns.
        kind: The document's name, of JSON.
        keep: What it is the latest of, for files and pages that begin later; empty for what only counts now.
        forgets: What of these is over.
    """

    topic: str
    message: Any
    time: int
    kind: str = ""
    keep: str = ""
    forgets: tuple[str, ...] = ()


class Translator:
    """Translates the messages of one world.

    Attributes:
        times: The time of the recording.
        ticks: What was seen and missed.
        refused: Messages that were left out: no message of their key, or on a topic too many.
        wants_map: Whether the map is unknown.
        wants_bodies: Whether the body of an agent in the state is unknown.
        clock: The latest clock of the current run.
    """

    def __init__(self, keys: Keys, unix_time: Callable[[], float]) -> None:
        """Begin.

        Args:
            keys: The keys of the world.
            unix_time: Returns the time of day, s, at which a run begins in the recording.
        """
        self.times = RunTimes()
        self.ticks = Ticks()
        self.refused = 0
        self.wants_map = False
        self.wants_bodies = False
        self.clock: Clock | None = None
        self.robots: dict[str, Robot] = {}
        self._keys = keys
        self._unix_time = unix_time
        self._past: deque[str] = deque(maxlen=RUNS_KNOWN)
        self._topics: set[str] = set()
        self._shown: set[str] = set()
        self._reported = 0
        self._began = 0.0

    def take(self, key: str, data: bytes, encoding: str) -> list[Entry]:
        """Return what to record of a message; nothing of bytes that are none."""
        kind, topic = self._kind_of(key)
        if kind is None:
            self.refused += 1
            return []
        try:
            message = decode(kind, data, encoding_of(encoding, data), strict=False)
        except WireError:
            self.refused += 1
            return []
        return self._admitted(self._entries(key, topic, message))

    def take_map(self, document: Map) -> list[Entry]:
        """Return what to record of a map that was asked for."""
        self.wants_map = False
        time, grid = self.times.now, map_cells(document)
        return self._admitted([
            Entry("/scene", scene.floor_update(document, grid, time), time, keep="scene map"),
            Entry("/grid", scene.grid_message(grid, time), time, keep="grid"),
            Entry("/iw/map", encode(document), time, "Map", "map"),
        ])  # fmt: skip

    def report(self, text: str) -> list[Entry]:
        """Return a line for the log of the recording."""
        time = self.times.now
        return [Entry("/log", motion.log_line(text, "iw-record", LogLevel.Warning, time), time)]

    # ------------------------------------------------------------ which message

    def _kind_of(self, key: str) -> tuple[type[Record] | None, str]:
        keys = self._keys
        one: Mapping[str, tuple[type[Record], str]] = {
            keys.clock: (Clock, "clock"), keys.event: (Event, "event"), keys.map: (MapInfo, "mapinfo"),
        }  # fmt: skip
        if key in one:
            kind, name = one[key]
            return kind, f"/iw/{name}"
        if keys.parse_state(key) is not None:
            return WorldState, "/iw/state"
        if agent := keys.parse_body(key):
            return Body, f"/iw/body/{agent}"
        if agent := keys.parse_user(key):
            return UserInput, f"/iw/user/{agent}"
        if out := keys.parse_out(key):
            return _TO_AGENT[out.kind], f"/iw/out/{out.agent}/{out.kind}"
        if into := keys.parse_in(key):
            return _FROM_AGENT[into.kind], f"/iw/in/{into.agent}/{into.kind}"
        return None, ""

    def _admitted(self, entries: list[Entry]) -> list[Entry]:
        found = []
        for entry in entries:
            if entry.topic not in self._topics and len(self._topics) >= MOST_TOPICS:
                self.refused += 1
                continue
            self._topics.add(entry.topic)
            found.append(entry)
        return found

    # ------------------------------------------------------------ what becomes of it

    def _entries(self, key: str, topic: str, message: Message) -> list[Entry]:
        run = getattr(message, "run", None)
        if run is not None and run != self.times.run and not self._begins(run, message):
            self.refused += 1
            return []
        time = self._time_of(message)
        keep = topic if isinstance(message, (Body, MapInfo)) else ""
        kind = "Power" if isinstance(message, PowerInForce) else type(message).__name__
        found = [Entry(topic, encode(message), time, kind, keep)]
        if isinstance(message, WorldState):
            found += self._state(message, time)
        elif isinstance(message, Body):
            found += self._body(key, message, time)
        elif isinstance(message, MapInfo):
            self.wants_map = True
        elif isinstance(message, Clock):
            self.clock = message
        elif isinstance(message, Event):
            found.append(Entry("/log", motion.log_of_event(message, time), time))
        elif isinstance(message, Measures):
            found += self._measures(self._agent(key), message)
        elif isinstance(message, Error):
            found.append(Entry("/log", motion.log_of_error(self._agent(key), message, time), time))
        elif isinstance(message, Say):
            found.append(Entry("/log", motion.log_line(message.text, self._agent(key), LogLevel.Info, time), time))
        elif isinstance(message, Pose):
            pose = motion.pose_in_map(message.x, message.y, message.heading, time)
            found.append(Entry(f"/{self._agent(key)}/reported", pose, time))
        return found

    def _agent(self, key: str) -> str:
        """Return the agent of a key `in/<agent>/...` or `out/<agent>/...`."""
        return key.removeprefix(self._keys.prefix).split("/")[1]

    def _begins(self, run: str, message: Message) -> bool:
        """Begin a run with the first clock, state, body or map of it; return whether it is the current one now.

        A past run whose clock still comes a while later never ended: a stranger named another.
        """
        now = self._unix_time()
        if run in self._past:
            if not isinstance(message, Clock) or now < self._began + RETURNS:
                return False
            self._past.remove(run)
        if not isinstance(message, (Clock, WorldState, Body, MapInfo)):
            return False
        self._began = now
        if self.times.run:
            self._past.append(self.times.run)
        seconds = message.time if isinstance(message, (Clock, WorldState)) else 0.0
        self.times.begin(run, seconds, now)
        self.clock, self.wants_map, self.wants_bodies = None, True, True
        return True

    def _time_of(self, message: Message) -> int:
        if isinstance(message, (Clock, WorldState, Measures)):
            self.times.learn_period(message.tick, message.time)
            return self.times.at(message.time)
        if isinstance(message, Event):
            return self.times.at_tick(message.tick)
        return self.times.now

    def _state(self, state: WorldState, time: int) -> Iterator[Entry]:
        parts = self.ticks.add(state)
        if not parts:
            return
        entities = [entity for part in parts for entity in part.entity]
        here = {entity.name for entity in entities}
        self.wants_bodies = self.wants_bodies or bool(here - self.robots.keys())
        if entities:
            yield Entry("/tf", motion.transforms(entities, self.robots, time), time)
        for entity in entities:
            yield from self._motion(entity, time)
        gone = sorted(self._shown - here)
        if gone:
            ids = [f"{word} {agent}" for agent in gone for word in ("body", "wedges", "start wedges")]
            over = tuple(f"scene {agent}" for agent in gone) + tuple(f"/iw/body/{agent}" for agent in gone)
            yield Entry("/scene", scene.removal(ids, time), time, forgets=over)
            self._shown -= set(gone)
            for agent in gone:
                self.robots.pop(agent, None)
        if self.ticks.missed > self._reported:
            missed, self._reported = self.ticks.missed - self._reported, self.ticks.missed
            yield from self.report(f"missed ticks={missed} before={parts[0].tick}")

    def _motion(self, entity: Entity, time: int) -> Iterator[Entry]:
        name = entity.name
        yield Entry(f"/{name}/pose", motion.pose_in_map(entity.x, entity.y, entity.heading, time), time)
        yield Entry(f"/{name}/truth", motion.true_motion(entity, time), time)
        if entity.goal is not None:
            yield Entry(f"/{name}/goal", motion.goal_in_map(entity.goal, time), time)

    def _body(self, key: str, body: Body, time: int) -> Iterator[Entry]:
        agent = self._keys.parse_body(key)
        # A stranger's body that is in no state is forgotten with the next state.
        if agent is None or (agent not in self.robots and len(self.robots) >= MOST_TOPICS):
            return
        self.robots[agent] = body.robot
        self._shown.add(agent)
        yield Entry("/scene", scene.body_update(agent, body.robot, time), time, keep=f"scene {agent}")

    def _measures(self, agent: str, measures: Measures) -> Iterator[Entry]:
        robot, sensors = self.robots.get(agent), measures.sensors
        if robot is None or sensors is None:
            return
        for reading in sensors.lidar:
            time = self._sampled(reading.tick, measures)
            scan = motion.laser_scan(agent, robot, reading, time)
            if scan is not None:
                yield Entry(f"/{agent}/scan/{reading.id}", scan, time)
        for dead_reckoned in sensors.odometry:
            time = self._sampled(dead_reckoned.tick, measures)
            yield Entry(f"/{agent}/odometry/{dead_reckoned.id}", motion.odometry(agent, dead_reckoned, time), time)
        if robot.proximity and sensors.proximity:
            time = self.times.at(measures.time)
            yield Entry("/wedges", scene.wedges_update(agent, robot, sensors.proximity, time), time)

    def _sampled(self, tick: int | None, measures: Measures) -> int:
        """Return the time of a sample, which may be earlier than the message."""
        return self.times.at(measures.time) if tick is None else self.times.at_tick(min(tick, measures.tick))
