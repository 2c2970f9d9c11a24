"""A world of the contract for the gateway: its clock and map as topics, and its control verbs for the services."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from typing import Any, Final, Protocol, TypeVar

from intellwheels_agents.map_cells import fitting_size, plan_of
from intellwheels_agents.ros_gateway.chair_messages import Topic
from intellwheels_agents.ros_gateway.clock_topic import CLOCK, ClockTopic
from intellwheels_agents.ros_gateway.floor_grid import floor_grid
from intellwheels_agents.ros_gateway.rmw_wire import LATCHED
from intellwheels_schemas import link
from intellwheels_schemas.codec import decode, encode, encoding_of
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.keys import Keys, Verb
from intellwheels_schemas.messages import Body, Clock, Entity, Map, Record, Result, WorldState
from intellwheels_schemas.process import SLICE
from intellwheels_schemas.simulator_query import ask_simulator
from intellwheels_schemas.zenoh_inbox import Inbox, Presence, Put

MAP_TOPIC: Final = Topic("/map", "nav_msgs/msg/OccupancyGrid", LATCHED)
ANSWER_TIMEOUT: Final = 5.0
"""Seconds to wait for what the simulator answers at once."""
CONTROL_TIMEOUT: Final = 600.0
"""Seconds to wait for a control verb: many steps take minutes."""
MOST_WANTED: Final = 50_000_000
"""Cells of `/map` with a resolution that somebody asked for."""
MOST_ROWS_WANTED: Final = 3_000_000
"""Rows that the walls of such a map cross: some ten seconds of work."""
TRY_EVERY: Final = 1.0
"""Seconds between two requests for the map."""

_Message = TypeVar("_Message", bound=Record)


class WorldQueries:
    """Asks a world. Every method raises `ConnectionError` without an answer that can be read."""

    def __init__(self, session: Any, keys: Keys, stop: threading.Event) -> None:
        """Take an open session, the keys of the world, and the event that ends every wait."""
        self._session = session
        self._keys = keys
        self._stop = stop

    def control(self, verb: Verb, message: Record) -> Result:
        """Send a control verb, and return its result, also that of an error reply."""
        key = self._keys.ctl_of(verb, message)
        answers = ask_simulator(
            self._session, self._keys, key, encode(message), timeout=CONTROL_TIMEOUT, stop=self._stop
        )
        return _read(Result, answers[0])

    def clock(self) -> Clock:
        """Return the clock."""
        return self._all(Clock, self._keys.clock)[0]

    def floor(self) -> Map:
        """Return the map."""
        return self._all(Map, self._keys.map)[0]

    def bodies(self) -> Sequence[Body]:
        """Return all bodies; none is no error."""
        return [] if not self.entities()[1] else self._all(Body, self._keys.every_body)

    def body(self, agent: str) -> Body:
        """Return a body."""
        return self._all(Body, self._keys.body(agent))[0]

    def entities(self) -> tuple[float, Sequence[Entity]]:
        """Return the simulated time, s, and the true states of all bodies, in the order of their names."""
        parts = sorted(self._all(WorldState, self._keys.every_state), key=lambda state: state.part)
        return parts[0].time, [entity for part in parts for entity in part.entity]

    def _all(self, kind: type[_Message], key: str) -> list[_Message]:
        answers = ask_simulator(self._session, self._keys, key, timeout=ANSWER_TIMEOUT, stop=self._stop)
        found = [_read(kind, answer) for answer in answers if answer.ok]
        if not found:
            raise ConnectionError(f"{key}: expected an answer, got an error: {answers[0].data[:200]!r}")
        return found


def _read(kind: type[_Message], answer: link.Answer) -> _Message:
    try:
        return decode(kind, answer.data, encoding_of(answer.encoding, answer.data), strict=False)
    except WireError as error:
        raise ConnectionError(f"expected a {kind.__name__}: {error.text}") from None


class Advertising(Protocol):
    """Where topics go: a node."""

    def advertise(self, topics: Sequence[Topic]) -> None:
        """Declare topics."""
        ...

    def publish(self, topic: str, message: Any) -> None:
        """Send a message."""
        ...


class WorldTopics:
    """Publishes `/clock` and `/map` until it is stopped."""

    def __init__(
        self, session: Any, keys: Keys, world: WorldQueries, node: Advertising, *,
        resolution: float | None, log: Callable[[str], None],
    ) -> None:  # fmt: skip
        """Take the world and the node.

        Args:
            session: An open session of the world.
            keys: The keys of the world.
            world: Answers for the map.
            node: Publishes the topics.
            resolution: Size of a cell of `/map`, m; None for the smallest of 0.05 and its doubles that fits.
            log: Takes lines for the log.
        """
        node.advertise([CLOCK, MAP_TOPIC])
        self.clock = ClockTopic(lambda message: node.publish(CLOCK.name, message))
        self._session = session
        self._keys = keys
        self._world = world
        self._node = node
        self._resolution = resolution
        self._log = log
        self._map_due = -float("inf")
        self._waiting = False

    def run(self, stop: threading.Event) -> None:
        """Publish until `stop` is set."""
        inbox, session, keys = Inbox(), self._session, self._keys
        with (
            session.declare_subscriber(keys.clock, inbox.on_sample),
            session.declare_subscriber(keys.map, inbox.on_sample),
            link.watch_tokens(session, keys.alive, inbox),
        ):
            while not stop.is_set():
                inbox.wait(SLICE)
                for arrival in inbox.take():
                    if isinstance(arrival, Put) and arrival.key == keys.clock:
                        self._take_clock(arrival)
                    elif isinstance(arrival, (Put, Presence)):
                        # Another map, or another simulator, which may have another map.
                        self._map_due = time.monotonic()
                if time.monotonic() >= self._map_due:
                    self._publish_map()

    def _take_clock(self, put: Put) -> None:
        try:
            clock = decode(Clock, put.data, encoding_of(put.encoding, put.data), strict=False)
        except WireError as error:
            self._log(f"dropped key={put.key} why={error.text!r}")
            return
        self.clock.tell(clock.run, clock.time, time.monotonic())

    def _publish_map(self) -> None:
        try:
            document = self._world.floor()
        except ConnectionError as error:
            self._map_due = time.monotonic() + TRY_EVERY
            if not self._waiting:
                self._waiting = True
                self._log(f"waiting why={str(error)!r}")
            return
        self._waiting = False
        self._map_due = float("inf")
        resolution = self._resolution or fitting_size(document)
        if self._resolution is not None:
            plan = plan_of(document, resolution)
            wrong = ""
            if plan.cells > MOST_WANTED:
                wrong = f"expected at most {MOST_WANTED} cells of /map, got {plan.cells}"
            elif plan.rows > MOST_ROWS_WANTED:
                wrong = f"expected at most {MOST_ROWS_WANTED} rows of cells along walls, got {plan.rows}"
            if wrong:
                resolution = fitting_size(document)
                self._log(f"--resolution: {wrong}: {resolution:g} is used")
        self._node.publish(MAP_TOPIC.name, floor_grid(document, resolution, self.clock.time))
        self._log(f"published topic=/map name={document.name} resolution={resolution:g}")
