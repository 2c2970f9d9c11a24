"""The clock of the run and its buttons. A paused run has no real-time factor."""

from __future__ import annotations

import html
from collections.abc import Callable
from typing import Final

import viser

from intellwheels_schemas.agent_colours import natural_key
from intellwheels_schemas.keys import Verb
from intellwheels_schemas.messages import Clock
from intellwheels_viewer.panels import number_format
from intellwheels_viewer.panels.callbacks import chosen, clicked, disable
from intellwheels_viewer.panels.choices import Choices
from intellwheels_viewer.panels.segments import Segments
from intellwheels_viewer.panels.style_sheet import STYLE_SHEET, block, note
from intellwheels_viewer.panels.style_sheet import figures as large
from intellwheels_viewer.snapshot import Snapshot

STEPS: Final = ("1", "10", "100")
SPEEDS: Final = ("0.5", "1", "2", "5")
RUN_VERBS: Final[tuple[Verb, ...]] = ("pause", "resume", "step", "speed", "reset")
"""What the buttons of a live run ask for."""
LOG_VERBS: Final[tuple[Verb, ...]] = ("pause", "resume", "step", "speed", "seek")
"""The same in a playback, with its timeline."""
_SHOWN: Final = 3
_BUSY: Final = 0.8
"""Share of the time from which on the page says that the simulator is busy."""
_PACES: Final = {
    "realtime": "in real time",
    "free": "as fast as it can",
    "lockstep": "in lockstep with its agents",
}
_WHY_LATE: Final = (
    "In real time, each tick has its time by the clock. A late one begins after it, because the machine is busy. "
    "It is simulated all the same."
)
_STATES: Final = {
    "running": ("good", "Running"),
    "paused": ("wait", "Paused"),
    "waiting": ("wait", "Waiting"),
    "ended": ("wait", "Ended"),
}


def clock_html(snapshot: Snapshot) -> str:
    """Return state, time, tick, real-time factor and late ticks."""
    clock = snapshot.clock
    if clock is None:
        return block("clock", '<span class="iw-soft">No clock yet.</span>')
    live = snapshot.phase == "live"
    tone, word = _STATES[clock.state] if live else ("", "Last known")
    return block(
        "clock",
        f'<div class="iw-head" data-state="{clock.state}"><i class="iw-dot {tone}"></i>'
        f'<b class="iw-cut">{html.escape(word + _awaited(clock))}</b></div>',
        large(
            (
                (number_format.decimal(clock.time), "time, s"),
                (str(clock.tick), "tick"),
                (_factor(clock), "real-time factor"),
            )
        ),
        f'<div class="iw-small iw-why" title="{_WHY_LATE}">{html.escape(_pace(clock))}, {_late(clock)}</div>',
        _load_line(clock, live),
        _end(snapshot) if live else "",
        classes="" if live else "iw-old",
    )


def _end(snapshot: Snapshot) -> str:
    """Return a note about the end of a run: it stands still since then, or has gone on."""
    if snapshot.is_over:
        return note("The run is over and stands still; speeds are its last ones. Space runs it again.")
    if snapshot.judged is None:
        return ""
    at = number_format.decimal(snapshot.judged)
    return note(f"The end condition was met at {at} s. The world has gone on since then.", "wait")


def _awaited(clock: Clock) -> str:
    if clock.state != "waiting":
        return ""
    if not clock.waiting:
        return " for the first agent"
    more = len(clock.waiting) - _SHOWN
    return (
        " for " + ", ".join(sorted(clock.waiting, key=natural_key)[:_SHOWN]) + (f" and {more} more" if more > 0 else "")
    )


def _factor(clock: Clock) -> str:
    return number_format.decimal(clock.factor) if clock.state == "running" else clock.state


def _late(clock: Clock) -> str:
    return f"{clock.late or 'no'} tick{'s' if clock.late > 1 else ''} began late"


def _load_line(clock: Clock, live: bool) -> str:
    """Return a line about why ticks are late. It is there always, so that nothing below it moves when it says so."""
    parts = _busy(clock) if live and clock.pace == "realtime" else []
    if not parts:
        return '<div class="iw-small">&nbsp;</div>'
    text = html.escape(" ".join(parts))
    return f'<div class="iw-small iw-cut iw-amber" title="{text}">{text}</div>'


def _busy(clock: Clock) -> list[str]:
    """Return sentences about what costs: how busy the simulator is, who floods, and whose sensors cost most."""
    parts = []
    if clock.load >= _BUSY:
        parts.append(f"Busy {_percent(clock.load)}: world {_percent(clock.world)}, messages {_percent(clock.wire)}.")
    if clock.flooding is not None:
        parts.append(f"{clock.flooding} sends too many messages.")
    if clock.load >= _BUSY:
        parts.append("Ticks may be late.")
        if clock.costliest is not None:
            parts.append(f"Sensors cast {clock.rays:,} rays per tick, most of them those of {clock.costliest}.")
    return parts


def _percent(share: float) -> str:
    return f"{100.0 * share:.0f} %"


def _pace(clock: Clock) -> str:
    if clock.pace == "realtime" and clock.speed != 1.0:
        return f"speed {number_format.factor(clock.speed)} \u00d7"
    return _PACES[clock.pace]


def speed_word(clock: Clock | None) -> str | None:
    """Return the speed of a run in real time as one of `SPEEDS`; it may be none of them."""
    return None if clock is None or clock.pace != "realtime" else number_format.factor(clock.speed)


class ClockPanel:
    """The clock, and pause, resume, step, reset and speed.

    Args:
        gui: Makes the elements, in the open container.
        on_pause: Requests a pause.
        on_resume: Requests to resume.
        on_step: Requests this many steps.
        on_reset: Requests a new run.
        on_speed: Requests a speed, simulated time over wall time.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        *,
        on_pause: Callable[[], None],
        on_resume: Callable[[], None],
        on_step: Callable[[int], None],
        on_reset: Callable[[], None],
        on_speed: Callable[[float], None],
    ) -> None:
        gui.add_html(STYLE_SHEET)
        self._clock = gui.add_html("")
        self._again = gui.add_button("Run again", icon=viser.Icon.REFRESH, visible=False)
        self._pause = gui.add_button("Pause", icon=viser.Icon.PLAYER_PAUSE, disabled=True)
        self._resume = gui.add_button("Resume", icon=viser.Icon.PLAYER_PLAY, visible=False)
        self._step = gui.add_button_group("Step, ticks", STEPS, disabled=True)
        self._speed = Segments(gui, "Speed, \u00d7", SPEEDS, lambda word: on_speed(float(word)))
        self._reset = gui.add_button_group("New run", ("Reset",), disabled=True)
        clicked(self._again, on_reset)
        clicked(self._pause, on_pause)
        clicked(self._resume, on_resume)
        chosen(self._reset, lambda _: on_reset())
        chosen(self._step, lambda word: on_step(int(word)))

    def show(self, snapshot: Snapshot, choices: Choices) -> None:
        """Show the clock, and disable buttons that have no effect now."""
        world, rights, clock = snapshot.world, choices.rights, snapshot.clock
        log = snapshot.last_tick is not None
        denied = "" if rights.looks_only else rights.why_not_any(world, LOG_VERBS if log else RUN_VERBS)
        self._clock.content = clock_html(snapshot) + (block("denied", note(denied, "wait")) if denied else "")

        def off(verb: Verb) -> bool:
            return snapshot.phase != "live" or clock is None or bool(rights.why_not(world, verb))

        halted = clock is not None and clock.state in {"paused", "ended"}
        # A playback has buttons of its own, beside its timeline.
        shown = not log and not rights.looks_only
        self._pause.visible, self._resume.visible = not halted and shown, halted and shown
        over = snapshot.is_over
        self._again.visible, self._again.disabled = over and shown, off("reset")
        self._resume.label = "Continue this run" if over else "Resume"
        self._reset.visible = shown
        self._step.visible = not rights.looks_only
        self._pause.disabled, self._resume.disabled = off("pause"), off("resume")
        disable(self._step, off("step"))
        disable(self._reset, off("reset"))
        self._speed.show(
            speed_word(clock),
            visible=shown,
            disabled=off("speed") or clock is None or clock.pace != "realtime",
        )
