"""Plays a log on the network as a world. It can be paused, and its position and speed set, but it cannot be steered.

Nothing here waits, reads a clock or knows Zenoh: it is driven as a live run is. Map, bodies, states, clock, events
and measures are published as they were. Powers are not, so that a playback can never move a real chair.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import singledispatchmethod
from typing import Final

import msgspec

from intellwheels_schemas.codec import Encoding
from intellwheels_schemas.messages import Pause, Quit, Record, Refused, Resume, Seek, Speed, Step
from intellwheels_server.log.reported_poses import ReportedPoses
from intellwheels_server.log.seekable_log import Place, SeekableLog
from intellwheels_server.service import control, outbound
from intellwheels_server.service.arrival import Arrival, Put, Query, Token
from intellwheels_server.service.error_replies import Fault
from intellwheels_server.service.event_buffer import EventBuffer
from intellwheels_server.service.load_floor import LoadRequest
from intellwheels_server.service.pacing import PendingSteps
from intellwheels_server.service.publisher import Outlet
from intellwheels_server.service.service_state import Options, PlaybackProgress, ServiceState
from intellwheels_server.world import State

READ_ONLY: Final = "a played log cannot be steered"
"""The answer to every request that would change the run."""
NO_SESSION: Final = "0" * 16
"""The session in the poses of a playback."""
AT_END: Final = "the log is at its end; seek back"


class Playback:
    """Decides when the next tick of a log is shown and what is sent."""

    def __init__(
        self,
        options: Options,
        outlet: Outlet,
        unix_time: Callable[[], float],
        log: SeekableLog,
        reported: ReportedPoses | None = None,
    ) -> None:
        """Begin at the beginning of the log.

        Args:
            options: World, speed and whether to quit at the end; the pace is real time.
            outlet: Where messages go.
            unix_time: Returns Unix time in seconds, for stamps.
            log: What is played.
            reported: The poses that the bridges of its chairs reported, if another log has them.
        """
        self._service = ServiceState(options, outlet, _NoFloors(), unix_time, run=log.header.run)
        self._service.pacing.waiting_to_start = False
        # It waits for a viewer: the first page that opens resumes it. With `quit_at_end` it plays at once.
        self._service.pacing.paused = not options.quit_at_end
        self._log, self._reported = log, reported
        first = log.header.run
        self._progress = PlaybackProgress(last_tick=self._last_tick(first))
        self._service.playback = self._progress
        self._place = Place(0, self._service.run.state)
        self._started = False
        self._beginning = log.go_to(first, 0)

    @property
    def exit(self) -> int | None:
        """The exit code of the process once the service is over, else None."""
        return self._service.exit

    @property
    def state(self) -> State:
        """The world."""
        return self._service.run.state

    def digest(self) -> str:
        """Return the hash of the state."""
        return self._service.run.digest()

    def begin(self) -> None:
        """Publish the beginning of the log."""
        outbound.publish_map(self._service.run, self._service.publisher)
        self._jump(self._beginning)

    def take(self, arrival: Arrival, now: float) -> None:
        """Take what arrived."""
        service = self._service
        if isinstance(arrival, Put):
            if not arrival.agent:
                return  # a key that nobody reads, with no name that could get an error
            if arrival.kind == "pose" and self._reported is not None:
                return  # the playback puts these poses itself, and receives them too
            fault = Fault("not-joined", f"{arrival.kind}: {READ_ONLY}")
            if service.message_limit.admit(arrival.agent, service.run.state.tick, now):
                outbound.send_error(service, arrival.agent, fault, now)
        elif not isinstance(arrival, Token):
            self._take_query(arrival, now)

    def work(self, now: float) -> None:
        """Do everything that is due; at most one tick is played."""
        service, metronome = self._service, self._service.pacing.metronome
        if service.exit is not None:
            return
        if not self._started:
            self._started = True
            metronome.start(now)
        if self._moves() and now >= metronome.due():
            metronome.begin_tick(now)
            self._play_tick(now)
        if service.publisher.schedule.take_due(now):
            self._publish(now)

    def due(self, now: float) -> float:
        """Return when to call `work` next if nothing arrives; `now` or less means at once."""
        due = self._service.publisher.schedule.due()
        return min(due, max(self._service.pacing.metronome.due(), now)) if self._moves() else due

    def spend(self, seconds: float, now: float) -> None:
        """Note that the work of this playback has taken so many seconds of wall time until now."""
        self._service.pacing.busy_share.spend(seconds, now)

    def finish(self, now: float) -> None:
        """Publish what is left before the service ends."""
        self._service.answer_steps("failed", "the player ends")
        outbound.publish(self._service, now)

    def _publish(self, now: float) -> None:
        outbound.publish(self._service, now)
        self._put_reported()

    def _put_reported(self) -> None:
        """Put the poses that bridges reported at this tick. They go out with each state, for late subscribers."""
        if self._reported is not None:
            state = self._service.run.state
            for agent, pose in self._reported.at(state.run, state.tick).items():
                # A pose that the state stands in for has no session, and the sessions of a log are over.
                self._service.publisher.outlet.pose(agent, msgspec.structs.replace(pose, session=NO_SESSION))

    # ------------------------------------------------------------ moving

    def _last_tick(self, run: str) -> int:
        ticks = self._log.ticks(run)
        return ticks[1] if ticks is not None else 0

    def _moves(self) -> bool:
        pacing = self._service.pacing
        return not self._progress.at_end and (not pacing.paused or pacing.steps is not None)

    def _play_tick(self, now: float) -> None:
        service, pacing = self._service, self._service.pacing
        self._show(self._log.next_place(self._place))
        for event in self._place.events:
            service.publisher.put_event(event)
        pacing.real_time_factor.count_tick(now)
        outbound.put_all_measures(service)
        if pacing.steps is not None:
            pacing.steps.left -= 1
            if pacing.steps.left <= 0:
                service.answer_steps("ok")
                outbound.publish(service, now)
        if self._progress.at_end:
            self._end(now)

    def _end(self, now: float) -> None:
        service, run = self._service, self._service.run
        service.answer_steps("ok", "the log is at its end")
        outbound.publish(service, now)
        service.publisher.outlet.print_line(f"ended tick={run.state.tick} hash={run.digest()} run={run.state.run}")
        if service.options.quit_at_end:
            service.exit = 0

    def _jump(self, place: Place) -> None:
        """Show a place that does not follow the last one. Its earlier events can be queried, but are not published."""
        publisher = self._service.publisher
        self._show(place)
        publisher.events = EventBuffer()
        for event in self._log.events(place.state.run, place.state.tick):
            publisher.events.add(event)
        outbound.put_all_measures(self._service)

    def _show(self, place: Place) -> None:
        service, before, state = self._service, self._service.run.state, place.state
        self._place = place
        self._progress.last_tick = self._last_tick(state.run)
        self._progress.at_end = place.position >= self._log.end
        service.run.state = state
        service.publisher.schedule.mark_changed()
        if state.run != before.run or state.setup.floor is not before.setup.floor:
            outbound.publish_map(service.run, service.publisher)
        if state.body_set is not before.body_set or state.run != before.run:
            self._show_bodies(before, state)

    def _show_bodies(self, before: State, state: State) -> None:
        """Publish the bodies that are new or changed, and declare the publishers of agents that come and go."""
        outlet, agents = self._service.publisher.outlet, self._service.agents
        models, known = state.body_set.models, before.body_set.models
        for name in known.keys() - models.keys():
            agents.set_encoding(name, None)
            outlet.undeclare_agent(name)
        for name, model in models.items():
            if model is known.get(name) and state.run == before.run:
                continue
            if model.robot.instance is not None and name not in agents.encodings:
                agents.set_encoding(name, Encoding.JSON)
                outlet.declare_agent(name, Encoding.JSON, Encoding.JSON)
            outbound.publish_body(self._service, name)

    # ------------------------------------------------------------ queries

    def _take_query(self, query: Query, now: float) -> None:
        service = self._service
        match query.topic:
            case "join":
                if query.name or not query.has_wildcards:
                    query.refuse(Refused(code="full", text=f"{READ_ONLY}: agents cannot join it"))
                else:
                    query.close()
            case "leave":
                query.reply(service.result("unsupported", READ_ONLY))
            case "ctl":
                message = control.read_message(service, query)
                if message is not None:
                    self._handle(message, query, now)
            case _:
                outbound.answer_query(service, query, now)

    @singledispatchmethod
    def _handle(self, _message: Record, query: Query, _now: float) -> None:
        """Handle a control message."""
        query.reply(self._service.result("unsupported", READ_ONLY))

    @_handle.register
    def _quit(self, _message: Quit, query: Query, _now: float) -> None:
        query.reply(self._service.result("ok"))
        self._service.exit = 0

    @_handle.register
    def _speed(self, message: Speed, query: Query, now: float) -> None:
        self._service.pacing.metronome.change_speed(message.factor, now)
        self._service.pacing.real_time_factor.reset()
        self._service.publisher.schedule.mark_changed()
        query.reply(self._service.result("ok"))

    @_handle.register
    def _pause(self, _message: Pause, query: Query, now: float) -> None:
        service = self._service
        service.answer_steps("incorrect-state", "paused before all steps were made")
        service.pacing.paused = True
        service.pacing.real_time_factor.reset()
        outbound.publish(service, now)
        query.reply(service.result("ok"))

    @_handle.register
    def _resume(self, _message: Resume, query: Query, now: float) -> None:
        service = self._service
        if self._progress.at_end:
            query.reply(service.result("incorrect-state", AT_END))
            return
        service.answer_steps("incorrect-state", "resumed before all steps were made")
        service.pacing.paused = False
        service.pacing.metronome.start(now)
        service.publisher.schedule.mark_changed()
        query.reply(service.result("ok"))

    @_handle.register
    def _step(self, message: Step, query: Query, now: float) -> None:
        service, pacing = self._service, self._service.pacing
        if not pacing.paused:
            query.reply(service.result("incorrect-state", "expected a paused log"))
        elif self._progress.at_end:
            query.reply(service.result("incorrect-state", AT_END))
        elif pacing.steps is not None:
            query.reply(service.result("incorrect-state", "steps are being made"))
        else:
            pacing.steps = PendingSteps(message.count, query)
            pacing.metronome.start(now)

    @_handle.register
    def _seek(self, message: Seek, query: Query, now: float) -> None:
        service = self._service
        try:
            place = self._log.go_to(message.run or service.run.state.run, message.tick)
        except LookupError as error:
            query.reply(service.result("not-found", f"Seek: {error}"))
            return
        service.answer_steps("incorrect-state", "a seek came before all steps were made")
        self._jump(place)
        service.pacing.metronome.start(now)
        service.pacing.real_time_factor.reset()
        self._publish(now)
        query.reply(service.result("ok"))


class _NoFloors:
    """Takes the place of the worker that loads floors. A playback refuses loads."""

    def begin(self, request: LoadRequest, limit: float) -> None:
        raise TypeError(f"expected no load in a playback, got {request!r} within {limit} s")

    def take(self) -> None:
        return None
