"""Keyboard and gamepad through pygame, which is loaded only when one of them is used. The only file that knows pygame.

The window gives the keyboard its focus. When it loses the focus all keys count as released, a latched command ends, and
a gamepad that is unplugged counts as released, because an unattended device must not drive.
"""

from __future__ import annotations

import os
import sys
from types import ModuleType
from typing import Any

from intellwheels_agents.joystick.input_state import NEUTRAL, InputState, KeyReader
from intellwheels_agents.joystick.key_bindings import from_stick
from intellwheels_schemas.extras import missing_extra

WINDOW_SIZE = (560, 150)
"""In pixels."""
_INVISIBLE = ("offscreen", "dummy")
_NO_DISPLAY = (
    "no display for the keyboard's window: expected a display (DISPLAY or WAYLAND_DISPLAY) or, with --source terminal, "
    "a terminal on standard input"
)


class DeviceError(RuntimeError):
    """An input device, or the software that reads it, is missing; the text says which."""


class MissingPygameError(DeviceError):
    """The extra `joystick` is not installed."""


def pygame_of(*, window: bool) -> ModuleType:
    """Return pygame, initialised.

    Args:
        window: Whether a window will be opened; otherwise no display is needed.

    Raises:
        MissingPygameError: pygame is not installed.
        DeviceError: There is no display.
    """
    os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
    # The command handles signals itself. A gamepad counts even if another window has the focus.
    os.environ.setdefault("SDL_NO_SIGNAL_HANDLERS", "1")
    os.environ.setdefault("SDL_JOYSTICK_ALLOW_BACKGROUND_EVENTS", "1")
    if not window:
        os.environ.setdefault("SDL_VIDEODRIVER", "dummy")
    lacking = missing_extra("joystick")
    if lacking is not None:
        raise MissingPygameError(f"keyboard and gamepad: {lacking}")
    if window and sys.platform == "linux" and not has_display():
        # Before SDL looks for a display: its libraries print lines of their own when there is none.
        raise DeviceError(_NO_DISPLAY)
    import pygame  # noqa: PLC0415

    try:
        pygame.display.init()
        pygame.joystick.init()
    except pygame.error as error:
        raise DeviceError(f"no display for the keyboard's window: {error}") from None
    return pygame


class KeyboardSource:
    """The keyboard, through a small window that also shows the state.

    Args:
        title: Title of the window.
        reader: The meaning of the keys.
    """

    def __init__(self, title: str, reader: KeyReader) -> None:
        self._pygame = pygame = pygame_of(window=True)
        try:
            self._screen = pygame.display.set_mode(WINDOW_SIZE)
        except pygame.error as error:
            raise DeviceError(f"no display for the keyboard's window: {error}") from None
        # Without a display SDL opens a window that cannot be seen or typed into.
        if pygame.display.get_driver() in _INVISIBLE and "SDL_VIDEODRIVER" not in os.environ:
            pygame.quit()
            raise DeviceError(_NO_DISPLAY)
        pygame.display.set_caption(title)
        pygame.font.init()
        self._font = pygame.font.Font(None, 24)
        self._reader = reader
        self._held: set[str] = set()
        # A press counts even if its release came with it: switch interfaces send both at once.
        self._tapped: set[str] = set()
        self._is_closed = False
        self._shown: tuple[InputState, str] | None = None

    def wait(self, seconds: float) -> None:
        """Wait for a key event, at most some seconds."""
        self._tapped.clear()
        first = self._pygame.event.wait(max(1, round(seconds * 1000.0)))
        for event in (first, *self._pygame.event.get()):
            self._on_event(event)

    def state(self, now: float, time: float | None) -> InputState | None:  # noqa: ARG002 - as `Source` has it
        """Return the state of the held keys, or None after the window was closed."""
        if self._is_closed:
            self._pygame.quit()
            return None
        state = self._reader.read(self._held | self._tapped, now)
        if (state, self._reader.caption) != self._shown:
            self._show(state)
        return state

    def _on_event(self, event: Any) -> None:
        pygame = self._pygame
        if event.type == pygame.QUIT or (event.type == pygame.KEYDOWN and event.key == pygame.K_ESCAPE):
            self._is_closed = True
        elif event.type == pygame.KEYDOWN:
            name = _name(pygame, event.key)
            self._held.add(name)
            self._tapped.add(name)
        elif event.type == pygame.KEYUP:
            self._held.discard(_name(pygame, event.key))
        elif event.type == pygame.WINDOWFOCUSLOST:
            self._held.clear()
            self._tapped.clear()
            self._reader.lost()

    def _show(self, state: InputState) -> None:
        self._shown = state, self._reader.caption
        self._screen.fill((24, 26, 30))
        numbers = f"forward {state.forward:+.2f}   turn {state.turn:+.2f}   buttons {state.buttons or '-'}"
        for row, line in enumerate((self._reader.caption or numbers, *self._reader.help)):
            self._screen.blit(self._font.render(line, True, (230, 230, 230)), (16, 20 + 40 * row))
        self._pygame.display.flip()


def _name(pygame: ModuleType, key: int) -> str:
    name = str(pygame.key.name(key))
    if name in ("left shift", "right shift"):
        return "shift"
    return "enter" if name == "return" else name.strip("[]")


class GamepadSource:
    """The first gamepad; one that was unplugged may come back.

    Args:
        forward: Share of full forward at full deflection, in [0, 1].
        turn: Share of full turn, in [0, 1].
    """

    def __init__(self, forward: float, turn: float) -> None:
        self._pygame = pygame_of(window=False)
        self._shares = forward, turn
        self._stick: Any = None
        self._connect()
        if self._stick is None:
            raise DeviceError("no gamepad found: connect one, or give --source keyboard")

    def wait(self, seconds: float) -> None:
        """Wait for an event of the stick or a button, at most some seconds."""
        first = self._pygame.event.wait(max(1, round(seconds * 1000.0)))
        for event in (first, *self._pygame.event.get()):
            if event.type == self._pygame.JOYDEVICEREMOVED:
                self._stick = None
            if self._stick is None:
                self._connect()

    def state(self, now: float, time: float | None) -> InputState | None:  # noqa: ARG002 - as `Source` has it
        """Return the gamepad's state; neutral while it is unplugged."""
        stick = self._stick
        if stick is None or stick.get_numaxes() < 2:
            return NEUTRAL
        held = [number for number in range(stick.get_numbuttons()) if stick.get_button(number)]
        return from_stick(stick.get_axis, held, *self._shares)

    def _connect(self) -> None:
        if self._pygame.joystick.get_count():
            self._stick = self._pygame.joystick.Joystick(0)


def has_display() -> bool:
    """Return whether a window can open: there is a display, or the user has chosen a driver of SDL's."""
    return any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER"))


def has_gamepad() -> bool:
    """Return whether a gamepad is connected.

    Raises:
        DeviceError: pygame is not installed.
    """
    driver = os.environ.get("SDL_VIDEODRIVER")
    pygame = pygame_of(window=False)
    found = bool(pygame.joystick.get_count())
    pygame.quit()
    # The keyboard's window needs a real display.
    if driver is None:
        os.environ.pop("SDL_VIDEODRIVER", None)
    return found
