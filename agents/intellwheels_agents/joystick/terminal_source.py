"""The keyboard of a terminal, for machines without a display. Needs nothing but the standard library.

A terminal reports characters, not presses and releases: a held key arrives again and again. So a key counts as held for
0.3 s after its last character, and no longer, because its release cannot be seen. Two things follow:

- The repetition of a held key starts after a delay, often 0.25 to 0.66 s. If it is longer than 0.3 s, the chair stops
  once between the first character and the repetition. `kbdrate -d 250` or `xset r rate 250 30` shortens it.
- Of several held keys only the last repeats. For a bend there are keys of their own: Q and E, or U and O.

The terminal echoes nothing meanwhile. Ctrl-C still interrupts, Escape and Ctrl-D end the source.
"""

from __future__ import annotations

import os
import re
import select
import sys
import termios
import time
import tty
from collections.abc import Collection
from contextlib import suppress
from dataclasses import replace
from types import TracebackType
from typing import Any, Final, Self

from intellwheels_agents.joystick.input_state import STALE_AFTER, InputState, KeyReader
from intellwheels_agents.joystick.key_bindings import DrivingKeys
from intellwheels_agents.joystick.pygame_source import DeviceError

KEY_TIMEOUT: Final = STALE_AFTER
"""Seconds that a key counts as held after its last character."""
REPEAT_PAUSE: Final = 0.5
"""Seconds for which a held key may seem released: repetition starts 0.66 s after the press, or earlier."""
ESCAPE_TIMEOUT: Final = 0.1
"""Seconds after which an Escape that nothing follows is the key, not the start of a sequence."""
_END: Final = ("\x04", "escape")
_NAMES: Final = {" ": "space", "\r": "enter", "\n": "enter", "\t": "tab"}
_ARROWS: Final = {"A": "up", "B": "down", "C": "right", "D": "left"}
# The sequences of xterm and the Linux console: ESC [ A, ESC O A, and ESC [ 1 ; 2 A with shift.
_SEQUENCE: Final = re.compile(r"\x1b(?:\[|O)(?:\d{0,4};(?P<modifier>\d{1,4})|[\d;]{0,8})(?P<final>[@-~])")
_UNFINISHED: Final = re.compile(r"\x1b(?:(?:\[|O)[\d;]{0,8})?\Z")


class TerminalKeys:
    """Turns the characters of a terminal into held keys. Pure: the time is an argument.

    Args:
        keys: The names of the keys that count, beside the digits.

    Attributes:
        passed: After `held`, the keys that were pressed since the call before, and that another key has replaced.
    """

    def __init__(self, keys: Collection[str] = DrivingKeys.keys) -> None:
        self._keys = keys
        self.has_ended = False
        self.passed: list[str] = []
        self._pressed: list[str] = []
        self._until: dict[str, float] = {}
        self._rest = ""
        self._rest_at = 0.0

    def feed(self, text: str, now: float) -> None:
        """Add characters that have arrived."""
        text = self._rest + text
        self._rest = ""
        while text:
            if unfinished := _UNFINISHED.match(text):
                self._rest, self._rest_at = unfinished[0], now
                return
            if sequence := _SEQUENCE.match(text):
                name, text = _ARROWS.get(sequence["final"], ""), text[sequence.end() :]
                # Modifiers are counted from 1, and shift is the lowest bit.
                self._press(name, bool((int(sequence["modifier"] or 1) - 1) & 1), now)
            elif text[0] == "\x1b":
                name, text = "escape", text[1:]
                self._press(name, False, now)
            else:
                name, text = text[0], text[1:]
                self._press(_NAMES.get(name, name.lower()), name.isupper(), now)

    def held(self, now: float) -> set[str]:
        """Return the names of the keys that count as held at a time in seconds, as in `key_bindings`."""
        if self._rest and now - self._rest_at > ESCAPE_TIMEOUT:
            self.has_ended |= self._rest == "\x1b"
            self._rest = ""
        self.passed, self._pressed = self._pressed[:-1], []
        return {name for name, until in self._until.items() if now < until}

    def _press(self, name: str, shift: bool, now: float) -> None:
        self.has_ended |= name in _END
        if name not in self._keys and not name.isdigit():
            return
        if name in self._keys:
            # A second direction replaces the first, which no longer repeats: its release could not be seen.
            self._until = {other: until for other, until in self._until.items() if other not in self._keys}
            self._until["shift"] = now + KEY_TIMEOUT if shift else now
            if self._pressed[-1:] != [name]:
                self._pressed.append(name)
        self._until[name] = now + KEY_TIMEOUT


class TerminalSource:
    """The keys of a terminal. Leaving the `with` restores the terminal.

    Args:
        reader: The meaning of the keys.
        descriptor: The terminal.

    Raises:
        DeviceError: The descriptor is no terminal, or the process is in its background.
    """

    def __init__(self, reader: KeyReader, descriptor: int) -> None:
        if not os.isatty(descriptor):
            raise DeviceError("keys of the terminal: expected a terminal on standard input, got a pipe or a file")
        try:
            if os.tcgetpgrp(descriptor) != os.getpgrp():
                raise DeviceError("keys of the terminal: expected to run in the foreground, got the background (no &)")
        except OSError:
            pass  # not the controlling terminal: no job control
        self._reader = reader
        self._descriptor = descriptor
        self._keys = TerminalKeys(reader.keys)
        self._at: float | None = None
        self._caption = ""
        self._saved: list[Any] | None = None

    def __enter__(self) -> Self:
        self._saved = termios.tcgetattr(self._descriptor)
        # Characters at once and without echo; Ctrl-C still sends its signal.
        tty.setcbreak(self._descriptor)
        self._tell(f"iw-joystick: {', '.join(self._reader.help)}; a key counts for {KEY_TIMEOUT:g} s\n")
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.leave_caption()
        if self._saved is not None:
            # Keys that were typed while the chair was driven must not reach the shell.
            with suppress(termios.error):  # the terminal has hung up
                termios.tcsetattr(self._descriptor, termios.TCSAFLUSH, self._saved)

    def wait(self, seconds: float) -> None:
        """Wait for a character, at most some seconds."""
        self._at = None
        if self._keys.has_ended or not select.select([self._descriptor], [], [], seconds)[0]:
            return
        try:
            data = os.read(self._descriptor, 1024)
        except OSError:  # the terminal has hung up
            data = b""
        if data:
            self._at = time.monotonic()
            self._keys.feed(data.decode("ascii", "replace"), self._at)
        else:
            self._keys.has_ended = True

    def state(self, now: float, time: float | None) -> InputState | None:  # noqa: ARG002 - as `Source` has it
        """Return the state of the held keys, or None after Escape, Ctrl-D or the end of the terminal."""
        held = self._keys.held(now)
        if self._keys.has_ended:
            return None
        for key in self._keys.passed:
            # The first of two quick presses must not be lost: the second switch would select another command.
            self._reader.read({key}, now)
        state = replace(self._reader.read(held, now), at=self._at)
        if self._reader.caption != self._caption:
            self._caption = self._reader.caption
            # On the same line, which it replaces.
            self._tell(f"\r\x1b[K{self._caption}")
        return state

    def leave_caption(self) -> None:
        """Begin a new line after the caption, as something else is printed next. The caption is then shown again."""
        if self._caption:
            self._caption = ""
            self._tell("\n")

    def _tell(self, text: str) -> None:
        """Write for the person at the terminal."""
        sys.stderr.write(text)
        sys.stderr.flush()
