"""The outgoing side: the outlet for messages, the schedule, and the events for late subscribers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from intellwheels_schemas.codec import Encoding
from intellwheels_schemas.keys import OutKind
from intellwheels_schemas.messages import Body, Clock, CrewError, Event, MapInfo, Pose, Record
from intellwheels_server.service.event_buffer import EventBuffer
from intellwheels_server.service.publish_schedule import PublishSchedule
from intellwheels_server.service.truth_filter import without_positions
from intellwheels_server.world.measures_writer import MeasuresWriter
from intellwheels_server.world.state_writer import StateWriter


class Outlet(Protocol):
    """Puts messages on the network and prints lines. No call waits."""

    def agent(self, agent: str, kind: OutKind, message: Record, encoding: Encoding) -> None:
        """Put `out/<agent>/<kind>`."""

    def put_measures(self, agent: str, data: bytes, encoding: Encoding, /) -> None:
        """Put the bytes of measures on `out/<agent>/measures`. The agent is declared, with that encoding."""

    def declare_agent(self, agent: str, mind: Encoding, body: Encoding) -> None:
        """Declare the publishers of an agent: measures and errors in one encoding, power in the other."""

    def undeclare_agent(self, agent: str) -> None:
        """Undeclare the publishers of an agent."""

    def crew_measures(self, crew: str, data: bytes, encoding: Encoding) -> None:
        """Put encoded `CrewMeasures` on `crew/<crew>/measures`."""

    def crew_error(self, crew: str, error: CrewError, encoding: Encoding) -> None:
        """Put `crew/<crew>/error`, also for a crew that has not joined."""

    def undeclare_crew(self, crew: str) -> None:
        """Undeclare the publishers of a crew, if there are any."""

    def body(self, agent: str, body: Body) -> None:
        """Put `body/<agent>`."""

    def pose(self, agent: str, pose: Pose) -> None:
        """Put `in/<agent>/pose`: in a playback, the pose that the bridge reported when the log was written."""

    def put_state(self, part: int, data: bytes) -> None:
        """Put the bytes of a part of the state on `state/<part>`."""

    def is_state_read(self) -> bool:
        """Return whether anybody reads the state."""

    def event(self, event: Event) -> None:
        """Put `event`."""

    def clock(self, clock: Clock) -> None:
        """Put `clock`."""

    def map(self, info: MapInfo) -> None:
        """Put `map`."""

    def print_line(self, line: str) -> None:
        """Print a line that scripts wait for."""

    def log_line(self, line: str) -> None:
        """Print a line for people."""


class Publisher:
    """The outgoing side of the service.

    Attributes:
        outlet: Where messages go.
        schedule: When state and clock are due.
        events: The newest events of the run.
        hide_truth: Whether true poses stay off the network.
        unix_time: Returns Unix time in seconds, for the stamp of a clock.
        observer: Called with each event before positions are removed, if set.
        power_seq: Number of the last power for a real chair.
        idle_power_at: When real chairs next get power 0 while the run is stopped.
        state_writer: What writes the state of the world.
        writers: What writes measures in each encoding.
    """

    def __init__(self, outlet: Outlet, unix_time: Callable[[], float], *, hide_truth: bool) -> None:
        self.outlet = outlet
        self.schedule = PublishSchedule()
        self.events = EventBuffer()
        self.hide_truth = hide_truth
        self.unix_time = unix_time
        self.observer: Callable[[Event], None] | None = None
        self.power_seq = 0
        self.idle_power_at = 0.0
        self.state_writer = StateWriter()
        self.writers = {encoding: MeasuresWriter(encoding) for encoding in Encoding}

    def put_event(self, event: Event) -> None:
        """Keep an event and publish it."""
        if self.observer is not None:
            self.observer(event)
        if self.hide_truth:
            event = without_positions(event)
        self.events.add(event)
        self.outlet.event(event)
