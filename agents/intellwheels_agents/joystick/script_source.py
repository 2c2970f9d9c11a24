"""Input states from a file, for tests and demonstrations.

A line has seconds, forward and turn, then optionally buttons and a word; `-` means none, `#` starts a comment.

    0.0   1    0           # from the start: full ahead
    2.0   0.5  0.5  0,3    # from 2 s on: a bend to the left, buttons 0 and 3 held
    3.0   0    0    -  stop
    3.5   0    0           # the script ends at the time of its last line
"""

from __future__ import annotations

import math
import threading
from bisect import bisect_right
from pathlib import Path
from typing import NamedTuple

from intellwheels_agents.joystick.input_state import NEUTRAL, InputState
from intellwheels_agents.joystick.words_source import is_word


class ScriptError(ValueError):
    """A wrong line in a script; the text says where, what was expected and what came."""


class Script(NamedTuple):
    """States by time, ascending."""

    times: tuple[float, ...]
    states: tuple[InputState, ...]

    def at(self, seconds: float) -> InputState | None:
        """Return the state at some seconds after the start, or None after the end of the script."""
        if seconds >= self.times[-1]:
            return None
        index = bisect_right(self.times, seconds + 1e-9) - 1
        return self.states[index] if index >= 0 else NEUTRAL


def read(path: Path) -> Script:
    """Return the script in a file.

    Raises:
        ScriptError: It is not text, a line is wrong, or it has no lines.
        OSError: The file cannot be read.
    """
    try:
        return parse(path.read_text("utf-8"), str(path))
    except UnicodeDecodeError as error:
        raise ScriptError(f"{path}: expected UTF-8 text, got byte 0x{error.object[error.start]:02x}") from None


def parse(text: str, where: str) -> Script:
    """Return the script in a text.

    Args:
        text: The lines.
        where: The name of the text, for errors.

    Raises:
        ScriptError: A line is wrong, or there is none.
    """
    times: list[float] = []
    states: list[InputState] = []
    for number, raw in enumerate(text.splitlines(), 1):
        words = raw.partition("#")[0].split()
        if not words:
            continue
        try:
            time, state = _line(words)
        except ValueError:
            raise ScriptError(
                f"{where}:{number}: expected seconds, forward and turn in [-1, 1], then optionally buttons (0,3) "
                f"and a word, got {raw.strip()!r}"
            ) from None
        if not math.isfinite(time) or time < 0.0 or (times and time <= times[-1]):
            raise ScriptError(f"{where}:{number}: expected increasing seconds from 0 on, got {words[0]!r}")
        times.append(time)
        states.append(state)
    if not times:
        raise ScriptError(f"{where}: expected at least one line, got none")
    return Script(tuple(times), tuple(states))


def _line(words: list[str]) -> tuple[float, InputState]:
    time, forward, turn = (float(word) for word in words[:3])
    buttons, word = (*words[3:], "-", "-")[:2]
    held = () if buttons == "-" else tuple(sorted({int(button) for button in buttons.split(",")}))
    if len(words) > 5 or not (-1.0 <= forward <= 1.0 and -1.0 <= turn <= 1.0):
        raise ValueError
    if any(not 0 <= button <= 63 for button in held) or (word != "-" and not is_word(word)):
        raise ValueError
    return time, InputState(forward, turn, held, None if word == "-" else word)


class ScriptSource:
    """Plays a script.

    Args:
        script: The script.
        simulated: Whether its seconds are simulated ones, from the first clock message on, or real ones.
        stop: Ends a wait.
    """

    def __init__(self, script: Script, *, simulated: bool, stop: threading.Event) -> None:
        self._script = script
        self._simulated = simulated
        self._stop = stop
        self._start: float | None = None

    def wait(self, seconds: float) -> None:
        """Wait some seconds."""
        self._stop.wait(seconds)

    def state(self, now: float, time: float | None) -> InputState | None:
        """Return the script's state now, or None after its end."""
        at = time if self._simulated else now
        if at is None:
            return NEUTRAL
        # A reset sets the clock back; the script then starts again.
        if self._start is None or at < self._start:
            self._start = at
        return self._script.at(at - self._start)
