"""The timeline of a playback. A live run has none."""

from __future__ import annotations

import html
import math
import time
from collections.abc import Callable
from typing import Final

import viser

from intellwheels_schemas.agent_colours import natural_key
from intellwheels_viewer.panels import number_format
from intellwheels_viewer.panels.callbacks import assign, clicked, updated
from intellwheels_viewer.panels.choices import Choices
from intellwheels_viewer.panels.clock import SPEEDS, speed_word
from intellwheels_viewer.panels.segments import Segments
from intellwheels_viewer.panels.style_sheet import STYLE_SHEET, block
from intellwheels_viewer.snapshot import Snapshot

HOLD_AFTER_DRAG: Final = 1.0
"""Seconds of wall time, after the user moved the timeline, during which the run does not move it."""


def playback_html(snapshot: Snapshot) -> str:
    """Return the position in the log; empty in a live run."""
    if snapshot.last_tick is None:
        return ""
    times = f"{number_format.moment(snapshot.tick, snapshot)} of {number_format.moment(snapshot.last_tick, snapshot)} s"
    return block(
        "playback",
        f'<b>Playing a log</b><div class="iw-small">{times}, tick {snapshot.tick} of {snapshot.last_tick}</div>',
        _report_errors(snapshot),
    )


def _report_errors(snapshot: Snapshot) -> str:
    """Return the error of each pose that a real chair reported, as the ghosts show it, in words."""
    words = []
    for name, pose in sorted(snapshot.reported.items(), key=lambda one: natural_key(one[0])):
        entity = snapshot.entity(name)
        if entity is not None:
            far = math.hypot(pose.x - entity.x, pose.y - entity.y)
            turned = abs(math.degrees(math.remainder(pose.heading - entity.heading, math.tau)))
            words.append(f"Ghost: pose reported by {html.escape(name)}, off by {far:.2f} m and {turned:.1f}\u00b0")
    return "".join(f'<div class="iw-small">{word}</div>' for word in words)


class PlaybackPanel:
    """Timeline, pause and speed of a playback; hidden in a live run.

    Args:
        gui: Makes the elements, in the open container.
        on_seek: Called with a tick of the log, often while the user drags the timeline.
        on_pause: Requests a pause.
        on_resume: Requests to resume.
        on_speed: Requests a speed, time in the log over wall time.
        now: A monotonic clock, in seconds.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        *,
        on_seek: Callable[[int], None],
        on_pause: Callable[[], None],
        on_resume: Callable[[], None],
        on_speed: Callable[[float], None],
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        gui.add_html(STYLE_SHEET)
        self._words = gui.add_html("", visible=False)
        self._line = gui.add_slider("Tick", 0, 1, 1, 0, marks=(), visible=False)
        self._pause = gui.add_button("Pause", icon=viser.Icon.PLAYER_PAUSE, visible=False)
        self._resume = gui.add_button("Play", icon=viser.Icon.PLAYER_PLAY, visible=False)
        self._speed = Segments(gui, "Speed, \u00d7", SPEEDS, lambda word: on_speed(float(word)))
        self._speed.show(None, visible=False)
        self._now = now
        self._touched = -HOLD_AFTER_DRAG
        self._last = 0
        self._on_seek = on_seek
        clicked(self._pause, on_pause)
        clicked(self._resume, on_resume)
        updated(self._line, self._moved)

    def show(self, snapshot: Snapshot, choices: Choices) -> None:
        """Show the position in the log; nothing in a live run."""
        playing = snapshot.last_tick is not None
        steers = not choices.rights.looks_only
        halted = snapshot.clock is not None and snapshot.clock.state in {"paused", "ended"}
        self._words.content = playback_html(snapshot)
        self._words.visible = playing
        self._line.visible = playing and steers
        self._pause.visible, self._resume.visible = playing and steers and not halted, playing and steers and halted
        live, why_not, world = snapshot.phase == "live", choices.rights.why_not, snapshot.world
        self._line.disabled = not live or bool(why_not(world, "seek"))
        self._pause.disabled = not live or bool(why_not(world, "pause"))
        self._resume.disabled = not live or bool(why_not(world, "resume"))
        denied = not live or bool(why_not(world, "speed"))
        self._speed.show(speed_word(snapshot.clock), visible=playing and steers, disabled=denied)
        if snapshot.last_tick is not None:
            self._last = snapshot.last_tick
            self._line.max = max(1, snapshot.last_tick)
            if self._now() - self._touched >= HOLD_AFTER_DRAG:
                assign(self._line, min(snapshot.tick, snapshot.last_tick))

    def _moved(self, tick: int) -> None:
        self._touched = self._now()
        self._on_seek(min(max(tick, 0), self._last))
