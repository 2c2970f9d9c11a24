"""A log on the network: told as a live world is told, sought and paced, never steered.

Nothing here waits, reads a clock or knows zenoh: it is driven as the conductor is. Map, bodies, states, clock, events
and measures go out as they did; powers do not, so that no chair of metal moves by what another day was.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final, NoReturn

from intellwheels_schemas.codec import Encoding
from intellwheels_schemas.messages import Load, Refused, Seek, Speed, Step
from intellwheels_server import publication, reception, verbs
from intellwheels_server.arrival import Arrival, Ask, Put, Token
from intellwheels_server.complaint import Fault
from intellwheels_server.desk import Desk, Options, Outlet, Played, Steps
from intellwheels_server.recording import Place, Recording
from intellwheels_server.reported import Reported
from intellwheels_server.ring import Ring
from intellwheels_server.world import State

STEERED: Final = "a played log cannot be steered"
"""What everybody is told who wants more than to watch."""
AT_END: Final = "the log is at its end; seek back"


class Player:
    """The decisions of a service that plays a log."""

    def __init__(
        self,
        options: Options,
        outlet: Outlet,
        wall: Callable[[], float],
        recording: Recording,
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
        self._desk = Desk(options, outlet, _no_floor, wall, run=recording.header.run)
        self._desk.held = False
        self._desk.played = Played(last=0)
        self._recording, self._reported = recording, reported
        first = recording.header.run
        self._place = Place(0, self._desk.state)
        self._begun = False
        self._beginning = recording.go_to(first, 0)
        self._played.last = self._last(first)

    @property
    def exit(self) -> int | None:
        """The process's exit code once the service is over, else None."""
        return self._desk.exit

    @property
    def state(self) -> State:
        """The world."""
        return self._desk.state

    def digest(self) -> str:
        """Return the hash of the state."""
        return self._desk.digest()

    def begin(self) -> None:
        """Publish what there is at the beginning."""
        publication.publish_map(self._desk)
        self._jump(self._beginning)

    def take(self, arrival: Arrival, now: float) -> None:
        """Take in what arrived."""
        desk = self._desk
        if isinstance(arrival, Put):
            if arrival.kind == "pose" and self._reported is not None:
                return  # our own: this key is heard here too
            fault = Fault("not-joined", f"{arrival.kind}: {STEERED}")
            if desk.gate.admit(arrival.agent, desk.state.tick, now):
                reception.complain(desk, arrival.agent, fault, now)
        elif not isinstance(arrival, Token):
            self._answer(arrival, now)

    def work(self, now: float) -> None:
        """Do all that is due; at most one tick is played."""
        desk = self._desk
        if desk.exit is not None:
            return
        if not self._begun:
            self._begun = True
            desk.metronome.start(now)
        if self._moves() and now >= desk.metronome.due():
            desk.metronome.began(now)
            self._go_on(now)
        if desk.cadence.ready(now):
            publication.publish(desk, now)
            self._put_reported()

    def due(self, now: float) -> float:
        """Return when `work` must be called next if nothing arrives; `now` or less: at once."""
        desk = self._desk
        due = desk.cadence.due()
        return min(due, max(desk.metronome.due(), now)) if self._moves() else due

    def finish(self, now: float) -> None:
        """Publish what is left before the service ends."""
        self._desk.close_steps("failed", "the player ends")
        publication.publish(self._desk, now)

    def _put_reported(self) -> None:
        """Tell where bridges said their chairs were at this tick. With each state: who comes late hears it too."""
        if self._reported is not None:
            state = self._desk.state
            for agent, pose in self._reported.at(state.run, state.tick).items():
                self._desk.out.pose(agent, pose)

    # ------------------------------------------------------------ moving

    @property
    def _played(self) -> Played:
        played = self._desk.played
        if played is None:
            raise TypeError("expected a desk of a log that is played")
        return played

    def _last(self, run: str) -> int:
        ticks = self._recording.ticks(run)
        return ticks[1] if ticks is not None else 0

    def _moves(self) -> bool:
        desk = self._desk
        return not self._played.over and (not desk.paused or desk.steps is not None)

    def _go_on(self, now: float) -> None:
        desk = self._desk
        self._show(self._recording.go_on(self._place))
        for event in self._place.events:
            desk.put_event(event)
        desk.tachometer.ticked(now)
        publication.put_all_measures(desk)
        if desk.steps is not None:
            desk.steps.left -= 1
            if desk.steps.left <= 0:
                desk.close_steps("ok", None)
                publication.publish(desk, now)
        if self._played.over:
            self._end(now)

    def _end(self, now: float) -> None:
        desk = self._desk
        desk.close_steps("ok", "the log is at its end")
        publication.publish(desk, now)
        desk.out.tell(f"ended tick={desk.state.tick} hash={desk.digest()} run={desk.state.run}")
        if desk.options.quit_at_end:
            desk.exit = 0

    def _jump(self, place: Place) -> None:
        """Show a place that does not follow: its events are there for who asks, but are not told."""
        desk = self._desk
        self._show(place)
        desk.ring = Ring()
        for event in self._recording.events(place.state.run, place.state.tick):
            desk.ring.add(event)
        publication.put_all_measures(desk)

    def _show(self, place: Place) -> None:
        desk, before, state = self._desk, self._desk.state, place.state
        self._place = place
        self._played.last = self._last(state.run)
        self._played.over = place.position >= self._recording.end
        desk.state = state
        desk.cadence.note()
        if state.run != before.run or state.setup.floor is not before.setup.floor:
            publication.publish_map(desk)
        if state.fleet is before.fleet and state.run == before.run:
            return
        figures, known = state.fleet.figures, before.fleet.figures
        for name in known.keys() - figures.keys():
            desk.encodings.pop(name, None)
            desk.out.farewell(name)
        for name, figure in figures.items():
            if figure is known.get(name) and state.run == before.run:
                continue
            if figure.robot.instance is not None and name not in desk.encodings:
                desk.encodings[name] = Encoding.JSON
                desk.out.welcome(name, Encoding.JSON, Encoding.JSON)
            desk.out.body(name, publication.body_of(desk, name))

    # ------------------------------------------------------------ what is asked

    def _answer(self, ask: Ask, now: float) -> None:
        desk = self._desk
        match ask.topic:
            case "join":
                if ask.name or not ask.wild:
                    ask.refuse(Refused(code="full", text=f"{STEERED}: nobody can join it"))
                else:
                    ask.close()
            case "leave":
                ask.reply(desk.result("unsupported", STEERED))
            case "ctl":
                message = verbs.read_verb(desk, ask)
                if message is not None:
                    self._obey(ask, message, now)
            case _:
                publication.ask_what_is(desk, ask, now)

    def _obey(self, ask: Ask, message: Any, now: float) -> None:
        desk = self._desk
        match ask.name:
            case "pause":
                self._pause(ask, now)
            case "resume":
                self._resume(ask, now)
            case "step":
                self._step_on(ask, message, now)
            case "speed":
                speed: Speed = message
                desk.metronome.change_speed(speed.factor, now)
                desk.tachometer.stop()
                desk.cadence.note()
                ask.reply(desk.result("ok"))
            case "seek":
                self._seek(ask, message, now)
            case "quit":
                ask.reply(desk.result("ok"))
                desk.exit = 0
            case _:
                ask.reply(desk.result("unsupported", STEERED))

    def _pause(self, ask: Ask, now: float) -> None:
        desk = self._desk
        desk.close_steps("incorrect-state", "paused before all steps were made")
        desk.paused = True
        desk.tachometer.stop()
        publication.publish(desk, now)
        ask.reply(desk.result("ok"))

    def _resume(self, ask: Ask, now: float) -> None:
        desk = self._desk
        if self._played.over:
            ask.reply(desk.result("incorrect-state", AT_END))
            return
        desk.close_steps("incorrect-state", "resumed before all steps were made")
        desk.paused = False
        desk.metronome.start(now)
        desk.cadence.note()
        ask.reply(desk.result("ok"))

    def _step_on(self, ask: Ask, step: Step, now: float) -> None:
        desk = self._desk
        if not desk.paused:
            ask.reply(desk.result("incorrect-state", "expected a paused log"))
        elif self._played.over:
            ask.reply(desk.result("incorrect-state", AT_END))
        elif desk.steps is not None:
            ask.reply(desk.result("incorrect-state", "steps are being made"))
        else:
            desk.steps = Steps(step.count, ask)
            desk.metronome.start(now)

    def _seek(self, ask: Ask, seek: Seek, now: float) -> None:
        desk = self._desk
        try:
            place = self._recording.go_to(seek.run or desk.state.run, seek.tick)
        except LookupError as error:
            ask.reply(desk.result("not-found", f"Seek: {error}"))
            return
        desk.close_steps("incorrect-state", "another tick was sought")
        self._jump(place)
        desk.metronome.start(now)
        desk.tachometer.stop()
        publication.publish(desk, now)
        self._put_reported()
        ask.reply(desk.result("ok"))


def _no_floor(_load: Load) -> NoReturn:
    raise TypeError("a played log loads no floor")
