"""Wishes from a file, for tests and demonstrations.

A line is: seconds, forward, turn, and perhaps buttons and a word; `-` is none, `#` begins a comment.

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

from intellwheels_agents.joystick.wish import NOTHING, Wish
from intellwheels_agents.joystick.words_source import is_word


class ScriptError(ValueError):
    """A line that is none; the sentence says which, what was expected and what came."""


class Script(NamedTuple):
    """Wishes by time, ascending."""

    times: tuple[float, ...]
    wishes: tuple[Wish, ...]

    def at(self, seconds: float) -> Wish | None:
        """Return what is wanted so long after the start, or None when the script is over."""
        if seconds >= self.times[-1]:
            return None
        index = bisect_right(self.times, seconds + 1e-9) - 1
        return self.wishes[index] if index >= 0 else NOTHING


def read(path: Path) -> Script:
    """Return the script in a file.

    Raises:
        ScriptError: It is no text, a line is none, or there is none.
        OSError: The file cannot be read.
    """
    try:
        return parse(path.read_text("utf-8"), str(path))
    except UnicodeDecodeError as error:
        raise ScriptError(f"{path}: expected a text in UTF-8, got byte 0x{error.object[error.start]:02x}") from None


def parse(text: str, where: str) -> Script:
    """Return the script that a text is.

    Args:
        text: The lines.
        where: Its name, for errors.

    Raises:
        ScriptError: A line is none, or there is none.
    """
    times: list[float] = []
    wishes: list[Wish] = []
    for number, raw in enumerate(text.splitlines(), 1):
        words = raw.partition("#")[0].split()
        if not words:
            continue
        try:
            time, wish = _line(words)
        except ValueError:
            raise ScriptError(
                f"{where}:{number}: expected seconds, forward and turn in [-1, 1], perhaps buttons (0,3) "
                f"and a word, got {raw.strip()!r}"
            ) from None
        if not math.isfinite(time) or time < 0.0 or (times and time <= times[-1]):
            raise ScriptError(f"{where}:{number}: expected seconds that grow from 0, got {words[0]!r}")
        times.append(time)
        wishes.append(wish)
    if not times:
        raise ScriptError(f"{where}: expected at least one line, got none")
    return Script(tuple(times), tuple(wishes))


def _line(words: list[str]) -> tuple[float, Wish]:
    time, forward, turn = (float(word) for word in words[:3])
    buttons, word = (*words[3:], "-", "-")[:2]
    held = () if buttons == "-" else tuple(sorted({int(button) for button in buttons.split(",")}))
    if len(words) > 5 or not (-1.0 <= forward <= 1.0 and -1.0 <= turn <= 1.0):
        raise ValueError
    if any(not 0 <= button <= 63 for button in held) or (word != "-" and not is_word(word)):
        raise ValueError
    return time, Wish(forward, turn, held, None if word == "-" else word)


class ScriptSource:
    """Plays a script.

    Args:
        script: What.
        simulated: Whether its seconds are the simulation's, from the first clock heard, or the wall's.
        stop: Ends a wait.
    """

    def __init__(self, script: Script, *, simulated: bool, stop: threading.Event) -> None:
        self._script = script
        self._simulated = simulated
        self._stop = stop
        self._start: float | None = None

    def wait(self, seconds: float) -> None:
        """Return after so long."""
        self._stop.wait(seconds)

    def wish(self, now: float, time: float | None) -> Wish | None:
        """Return what the script wants, or None at its end."""
        at = time if self._simulated else now
        if at is None:
            return NOTHING
        # A reset puts the clock back; the script then begins anew.
        if self._start is None or at < self._start:
            self._start = at
        return self._script.at(at - self._start)
