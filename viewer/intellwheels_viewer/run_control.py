"""Requests that control the run: pause, resume, step, speed, run again and the playback's position."""

from __future__ import annotations

from typing import TYPE_CHECKING

from intellwheels_schemas.messages import Pause, Reset, Result, Resume, Seek, Speed, Step

if TYPE_CHECKING:
    from intellwheels_viewer.snapshot import Snapshot
    from intellwheels_viewer.steering import RequestQueue


class RunControl:
    """The controls of one page. Nothing here blocks.

    Args:
        requests: Takes the requests.
    """

    def __init__(self, requests: RequestQueue) -> None:
        self._requests = requests
        self._started = ""

    def pause(self) -> None:
        """Pause the run."""
        self._requests.ask("Not paused", "pause", Pause())

    def resume(self) -> None:
        """Resume the run. A run that has ended continues."""
        self._requests.ask("Not resumed", "resume", Resume())

    def step(self, count: int) -> None:
        """Step a paused run by this many ticks."""
        self._requests.ask("Not stepped", "step", Step(count=count))

    def reset(self) -> None:
        """Start a new run."""
        # A run that was reset while paused stays paused, which is not what `Run again` means.
        self._requests.ask("Not reset", "reset", Reset())

    def speed(self, factor: float) -> None:
        """Change the speed, simulated time over wall time."""
        self._requests.ask("Speed not changed", "speed", Speed(factor=factor))

    def seek(self, tick: int) -> None:
        """Move a playback to a tick."""
        self._requests.ask("Not moved in time", "seek", Seek(tick=tick))

    def play(self, snapshot: Snapshot) -> None:
        """Play a log; from the beginning if it is at its end."""

        def sought(_: Result) -> None:
            self.resume()

        if is_at_end(snapshot):
            self._requests.ask("Not moved in time", "seek", Seek(tick=0), sought)
        else:
            self.resume()

    def toggle(self, snapshot: Snapshot) -> None:
        """Do what the main button shows: pause, resume, play, or run again after the end."""
        state = None if snapshot.clock is None else snapshot.clock.state
        if snapshot.last_tick is not None:
            if state == "paused" or is_at_end(snapshot):
                self.play(snapshot)
            else:
                self.pause()
        elif state == "ended":
            self.reset()
        elif state == "paused":
            self.resume()
        else:
            self.pause()

    def start_waiting(self, snapshot: Snapshot) -> None:
        """Start a run or a playback that waits at its beginning for a page to open; once for each run."""
        if self._started != snapshot.run and waits_for_page(snapshot):
            self._started = snapshot.run
            self._requests.ask(None, "resume", Resume())


def waits_for_page(snapshot: Snapshot) -> bool:
    """Return whether a run or a playback waits at its beginning for a page to open.

    If somebody paused or reset the run, there is an event of it, and the run is not started.
    """
    clock = snapshot.clock
    if snapshot.phase != "live" or clock is None or clock.state != "paused" or clock.tick != 0 or snapshot.tick != 0:
        return False
    if snapshot.last_tick is not None:
        return True
    codes = {event.code for event in snapshot.events if event.run == snapshot.run}
    return codes == {"joined"}


def step_hint(snapshot: Snapshot) -> str | None:
    """Return what to do before a step is possible; None if the run can be stepped, or if only the simulator knows."""
    if snapshot.is_over:
        return "The run is over. Space runs it again; `Continue this run` goes on beyond its end."
    if snapshot.phase == "live" and snapshot.clock is not None and snapshot.clock.state == "running":
        return "The run is not paused. Space pauses it, then N makes one step."
    return None


def is_at_end(snapshot: Snapshot) -> bool:
    """Return whether a playback has reached the end of its log."""
    return snapshot.last_tick is not None and snapshot.tick >= snapshot.last_tick
