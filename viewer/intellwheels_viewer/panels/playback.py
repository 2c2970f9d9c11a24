"""The time line of a world that plays a log. There is none where the world is simulated as one looks."""

from __future__ import annotations

import html
import math
import time
from collections.abc import Callable
from typing import Final

import viser

from intellwheels_viewer.panels import number_format
from intellwheels_viewer.panels.callbacks import assign, chosen, clicked, disable, updated
from intellwheels_viewer.panels.choices import Choices
from intellwheels_viewer.panels.clock import SPEEDS
from intellwheels_viewer.panels.style_sheet import STYLE_SHEET, block
from intellwheels_viewer.snapshot import Snapshot

HANDS_ON: Final = 1.0
"""Wall seconds after a page moved the time line in which the run does not move it: it would jump under the hand."""


def playback_html(seen: Snapshot) -> str:
    """Return how far the log is played; nothing without one."""
    if seen.last_tick is None:
        return ""
    times = f"{number_format.moment(seen.tick, seen)} of {number_format.moment(seen.last_tick, seen)} s"
    return block(
        "playback",
        f'<b>Playing a log</b><div class="iw-small">{times}, tick {seen.tick} of {seen.last_tick}</div>{_off(seen)}',
    )


def _off(seen: Snapshot) -> str:
    """Return how far real chairs were from where they said that they were: what the ghosts show, in words."""
    words = []
    for name, pose in sorted(seen.reported.items()):
        entity = seen.entity(name)
        if entity is not None:
            far = math.hypot(pose.x - entity.x, pose.y - entity.y)
            turned = abs(math.degrees(math.remainder(pose.heading - entity.heading, math.tau)))
            words.append(f"See-through: where {html.escape(name)} said it was, {far:.2f} m and {turned:.1f}\u00b0 off")
    return "".join(f'<div class="iw-small">{word}</div>' for word in words)


class PlaybackPanel:
    """Time line, pause and speed of a log; unseen without one.

    Args:
        gui: Where the elements are made, in the container that is open.
        on_seek: Gets a tick of the log, often while the time line is dragged: only the newest counts.
        on_pause: Asks for a pause.
        on_resume: Asks to go on.
        on_speed: Asks for a speed, time of the log over wall time.
        now: Returns wall seconds that never go back.
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
        self._speed = gui.add_button_group("Speed, \u00d7", SPEEDS, visible=False)
        self._now = now
        self._touched = -HANDS_ON
        self._last = 0
        self._on_seek = on_seek
        clicked(self._pause, on_pause)
        clicked(self._resume, on_resume)
        chosen(self._speed, lambda word: on_speed(float(word)))
        updated(self._line, self._moved)

    def show(self, seen: Snapshot, choices: Choices) -> None:
        """Show how far the log is; nothing when there is none."""
        playing = seen.last_tick is not None
        halted = seen.clock is not None and seen.clock.state in {"paused", "ended"}
        self._words.content = playback_html(seen)
        self._words.visible = self._line.visible = self._speed.visible = playing
        self._pause.visible, self._resume.visible = playing and not halted, playing and halted
        able = choices.allowed and seen.phase == "live"
        for one in (self._line, self._pause, self._resume):
            one.disabled = not able
        disable(self._speed, not able)
        if seen.last_tick is not None:
            self._last = seen.last_tick
            self._line.max = max(1, seen.last_tick)
            if self._now() - self._touched >= HANDS_ON:
                assign(self._line, min(seen.tick, seen.last_tick))

    def _moved(self, tick: int) -> None:
        self._touched = self._now()
        self._on_seek(min(max(tick, 0), self._last))
