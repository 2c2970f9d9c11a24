"""A log on the network: published like a live world, with seeking and speed, but without control of the bodies.

Nothing here waits, reads a clock or knows zenoh: it is driven as a live run is. Map, bodies, states, clock, events
and measures go out as they did; powers do not, so that no chair of metal moves by what another day was.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final, NoReturn

from intellwheels_schemas.codec import Encoding
from intellwheels_schemas.messages import Load, Refused, Seek, Speed, Step
from intellwheels_server.log.reported_poses import Reported
from intellwheels_server.log.seekable_log import Place, SeekableLog
from intellwheels_server.service import control, inbound, outbound
from intellwheels_server.service.arrival import Arrival, Ask, Put, Token
from intellwheels_server.service.error_replies import Fault
from intellwheels_server.service.event_buffer import EventBuffer
from intellwheels_server.service.service_state import Options, Outlet, Played, ServiceState, Steps
from intellwheels_server.world import State

STEERED: Final = "a played log cannot be steered"
"""What everybody is told who wants more than to watch."""
AT_END: Final = "the log is at its end; seek back"


class Playback:
    """The decisions of a service that plays a log."""

    def __init__(
        self,
        options: Options,
        outlet: Outlet,
        wall: Callable[[], float],
        recording: SeekableLog,
        reported: Reported | None = None,
    ) -> None:
        """Begin at the log's beginning.

        Args:
            options: World, speed and whether to quit at the end; the pace is real time.
            outlet: Where messages go.
            wall: Gives Unix time, for stamps.
            recording: What is played.
            reported: Where the bridges of its chairs said that they were, if another log tells.
        """
        self._service = ServiceState(options, outlet, _no_floor, wall, run=recording.header.run)
        self._service.held = False
        # It waits for somebody to look: the first page that opens resumes it. Without an audience it plays at once.
        self._service.paused = not options.quit_at_end
        self._service.played = Played(last=0)
        self._recording, self._reported = recording, reported
        first = recording.header.run
        self._place = Place(0, self._service.state)
        self._begun = False
        self._beginning = recording.go_to(first, 0)
        self._played.last = self._last(first)

    @property
    def exit(self) -> int | None:
        """The process's exit code once the service is over, else None."""
        return self._service.exit

    @property
    def state(self) -> State:
        """The world."""
        return self._service.state

    def digest(self) -> str:
        """Return the hash of the state."""
        return self._service.digest()

    def begin(self) -> None:
        """Publish what there is at the beginning."""
        outbound.publish_map(self._service)
        self._jump(self._beginning)

    def take(self, arrival: Arrival, now: float) -> None:
        """Take in what arrived."""
        service = self._service
        if isinstance(arrival, Put):
            if arrival.kind == "pose" and self._reported is not None:
                return  # our own: this key is heard here too
            fault = Fault("not-joined", f"{arrival.kind}: {STEERED}")
            if service.gate.admit(arrival.agent, service.state.tick, now):
                inbound.complain(service, arrival.agent, fault, now)
        elif not isinstance(arrival, Token):
            self._answer(arrival, now)

    def work(self, now: float) -> None:
        """Do all that is due; at most one tick is played."""
        service = self._service
        if service.exit is not None:
            return
        if not self._begun:
            self._begun = True
            service.metronome.start(now)
        if self._moves() and now >= service.metronome.due():
            service.metronome.began(now)
            self._go_on(now)
        if service.cadence.ready(now):
            outbound.publish(service, now)
            self._put_reported()

    def due(self, now: float) -> float:
        """Return when `work` must be called next if nothing arrives; `now` or less: at once."""
        service = self._service
        due = service.cadence.due()
        return min(due, max(service.metronome.due(), now)) if self._moves() else due

    def finish(self, now: float) -> None:
        """Publish what is left before the service ends."""
        self._service.close_steps("failed", "the player ends")
        outbound.publish(self._service, now)

    def _put_reported(self) -> None:
        """Tell where bridges said their chairs were at this tick. With each state: who comes late hears it too."""
        if self._reported is not None:
            state = self._service.state
            for agent, pose in self._reported.at(state.run, state.tick).items():
                self._service.out.pose(agent, pose)

    # ------------------------------------------------------------ moving

    @property
    def _played(self) -> Played:
        played = self._service.played
        if played is None:
            raise TypeError("expected the service state of a log that is played")
        return played

    def _last(self, run: str) -> int:
        ticks = self._recording.ticks(run)
        return ticks[1] if ticks is not None else 0

    def _moves(self) -> bool:
        service = self._service
        return not self._played.over and (not service.paused or service.steps is not None)

    def _go_on(self, now: float) -> None:
        service = self._service
        self._show(self._recording.go_on(self._place))
        for event in self._place.events:
            service.put_event(event)
        service.tachometer.ticked(now)
        outbound.put_all_measures(service)
        if service.steps is not None:
            service.steps.left -= 1
            if service.steps.left <= 0:
                service.close_steps("ok", None)
                outbound.publish(service, now)
        if self._played.over:
            self._end(now)

    def _end(self, now: float) -> None:
        service = self._service
        service.close_steps("ok", "the log is at its end")
        outbound.publish(service, now)
        service.out.tell(f"ended tick={service.state.tick} hash={service.digest()} run={service.state.run}")
        if service.options.quit_at_end:
            service.exit = 0

    def _jump(self, place: Place) -> None:
        """Show a place that does not follow: its events are there for who asks, but are not told."""
        service = self._service
        self._show(place)
        service.ring = EventBuffer()
        for event in self._recording.events(place.state.run, place.state.tick):
            service.ring.add(event)
        outbound.put_all_measures(service)

    def _show(self, place: Place) -> None:
        service, before, state = self._service, self._service.state, place.state
        self._place = place
        self._played.last = self._last(state.run)
        self._played.over = place.position >= self._recording.end
        service.state = state
        service.cadence.note()
        if state.run != before.run or state.setup.floor is not before.setup.floor:
            outbound.publish_map(service)
        if state.body_set is before.body_set and state.run == before.run:
            return
        figures, known = state.body_set.figures, before.body_set.figures
        for name in known.keys() - figures.keys():
            service.encodings.pop(name, None)
            service.out.farewell(name)
        for name, figure in figures.items():
            if figure is known.get(name) and state.run == before.run:
                continue
            if figure.robot.instance is not None and name not in service.encodings:
                service.encodings[name] = Encoding.JSON
                service.out.welcome(name, Encoding.JSON, Encoding.JSON)
            service.out.body(name, outbound.body_of(service, name))

    # ------------------------------------------------------------ what is asked

    def _answer(self, ask: Ask, now: float) -> None:
        service = self._service
        match ask.topic:
            case "join":
                if ask.name or not ask.wild:
                    ask.refuse(Refused(code="full", text=f"{STEERED}: nobody can join it"))
                else:
                    ask.close()
            case "leave":
                ask.reply(service.result("unsupported", STEERED))
            case "ctl":
                message = control.read_verb(service, ask)
                if message is not None:
                    self._obey(ask, message, now)
            case _:
                outbound.ask_what_is(service, ask, now)

    def _obey(self, ask: Ask, message: Any, now: float) -> None:
        service = self._service
        match ask.name:
            case "pause":
                self._pause(ask, now)
            case "resume":
                self._resume(ask, now)
            case "step":
                self._step_on(ask, message, now)
            case "speed":
                speed: Speed = message
                service.metronome.change_speed(speed.factor, now)
                service.tachometer.stop()
                service.cadence.note()
                ask.reply(service.result("ok"))
            case "seek":
                self._seek(ask, message, now)
            case "quit":
                ask.reply(service.result("ok"))
                service.exit = 0
            case _:
                ask.reply(service.result("unsupported", STEERED))

    def _pause(self, ask: Ask, now: float) -> None:
        service = self._service
        service.close_steps("incorrect-state", "paused before all steps were made")
        service.paused = True
        service.tachometer.stop()
        outbound.publish(service, now)
        ask.reply(service.result("ok"))

    def _resume(self, ask: Ask, now: float) -> None:
        service = self._service
        if self._played.over:
            ask.reply(service.result("incorrect-state", AT_END))
            return
        service.close_steps("incorrect-state", "resumed before all steps were made")
        service.paused = False
        service.metronome.start(now)
        service.cadence.note()
        ask.reply(service.result("ok"))

    def _step_on(self, ask: Ask, step: Step, now: float) -> None:
        service = self._service
        if not service.paused:
            ask.reply(service.result("incorrect-state", "expected a paused log"))
        elif self._played.over:
            ask.reply(service.result("incorrect-state", AT_END))
        elif service.steps is not None:
            ask.reply(service.result("incorrect-state", "steps are being made"))
        else:
            service.steps = Steps(step.count, ask)
            service.metronome.start(now)

    def _seek(self, ask: Ask, seek: Seek, now: float) -> None:
        service = self._service
        try:
            place = self._recording.go_to(seek.run or service.state.run, seek.tick)
        except LookupError as error:
            ask.reply(service.result("not-found", f"Seek: {error}"))
            return
        service.close_steps("incorrect-state", "another tick was sought")
        self._jump(place)
        service.metronome.start(now)
        service.tachometer.stop()
        outbound.publish(service, now)
        self._put_reported()
        ask.reply(service.result("ok"))


def _no_floor(_load: Load) -> NoReturn:
    raise TypeError("a played log loads no floor")
