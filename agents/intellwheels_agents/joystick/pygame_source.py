"""Keyboard and gamepad by pygame, which is loaded when one of them is asked for. The only file that knows it.

The window is for the keyboard's focus and for eyes. Keys are let go when it loses the focus, a stick when it is pulled
out: what nobody holds must not drive.
"""

from __future__ import annotations

import os
from types import ModuleType
from typing import Any

from intellwheels_agents.joystick.key_bindings import of_keys, of_stick
from intellwheels_agents.joystick.wish import NOTHING, Wish

SIZE = (460, 150)
"""Pixels of the window."""
_LINES = ("arrows or w a s d drive, shift halves, space stops", "0-9 buttons, escape ends")
_UNSEEN = ("offscreen", "dummy")


class DeviceError(RuntimeError):
    """A device, or what reads it, is not there; the sentence says which."""


def pygame_of(*, window: bool) -> ModuleType:
    """Return pygame, started.

    Args:
        window: Whether there will be one; without, none is needed, nor a display.

    Raises:
        DeviceError: It is not installed, or there is no display.
    """
    os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
    # Signals are the command's own business; a stick counts whatever window is in front.
    os.environ.setdefault("SDL_NO_SIGNAL_HANDLERS", "1")
    os.environ.setdefault("SDL_JOYSTICK_ALLOW_BACKGROUND_EVENTS", "1")
    if not window:
        os.environ.setdefault("SDL_VIDEODRIVER", "dummy")
    try:
        import pygame  # noqa: PLC0415
    except ImportError:
        raise DeviceError("keyboard and gamepad need pygame-ce: pip install 'intellwheels[joystick]'") from None
    try:
        pygame.display.init()
        pygame.joystick.init()
    except pygame.error as error:
        raise DeviceError(f"no display for the keyboard's window: {error}") from None
    return pygame


class KeyboardSource:
    """A small window; its keys are the wish, which it shows.

    Args:
        title: Of the window.
        forward: Share of full forward that a key asks for, in [0, 1].
        turn: Share of full turn, in [0, 1].
    """

    def __init__(self, title: str, forward: float, turn: float) -> None:
        self._pygame = pygame = pygame_of(window=True)
        try:
            self._screen = pygame.display.set_mode(SIZE)
        except pygame.error as error:
            raise DeviceError(f"no display for the keyboard's window: {error}") from None
        # Where there is no display SDL makes do with a window that nobody can see or type into.
        if pygame.display.get_driver() in _UNSEEN and "SDL_VIDEODRIVER" not in os.environ:
            pygame.quit()
            raise DeviceError(
                "no display for the keyboard's window: expected DISPLAY or WAYLAND_DISPLAY; or give another --source"
            )
        pygame.display.set_caption(title)
        pygame.font.init()
        self._font = pygame.font.Font(None, 24)
        self._shares = forward, turn
        self._held: set[str] = set()
        self._over = False
        self._shown: Wish | None = None

    def wait(self, seconds: float) -> None:
        """Return when a key went, at the latest after so long."""
        first = self._pygame.event.wait(max(1, round(seconds * 1000.0)))
        for event in (first, *self._pygame.event.get()):
            self._take(event)

    def wish(self, now: float, time: float | None) -> Wish | None:  # noqa: ARG002 - as `Source` has it
        """Return what the held keys want, or None once the window was closed."""
        if self._over:
            self._pygame.quit()
            return None
        wish = of_keys(self._held, *self._shares)
        if wish != self._shown:
            self._show(wish)
        return wish

    def _take(self, event: Any) -> None:
        pygame = self._pygame
        if event.type == pygame.QUIT or (event.type == pygame.KEYDOWN and event.key == pygame.K_ESCAPE):
            self._over = True
        elif event.type == pygame.KEYDOWN:
            self._held.add(_name(pygame, event.key))
        elif event.type == pygame.KEYUP:
            self._held.discard(_name(pygame, event.key))
        elif event.type == pygame.WINDOWFOCUSLOST:
            self._held.clear()

    def _show(self, wish: Wish) -> None:
        self._shown = wish
        self._screen.fill((24, 26, 30))
        said = f"forward {wish.forward:+.2f}   turn {wish.turn:+.2f}   buttons {wish.buttons or '-'}"
        for row, text in enumerate((said, *_LINES)):
            self._screen.blit(self._font.render(text, True, (230, 230, 230)), (16, 20 + 40 * row))
        self._pygame.display.flip()


def _name(pygame: ModuleType, key: int) -> str:
    name = str(pygame.key.name(key))
    return "shift" if name in ("left shift", "right shift") else name.strip("[]")


class GamepadSource:
    """The first gamepad there is; one that was pulled out may come back.

    Args:
        forward: Share of full forward that the stick asks for, in [0, 1].
        turn: Share of full turn, in [0, 1].
    """

    def __init__(self, forward: float, turn: float) -> None:
        self._pygame = pygame_of(window=False)
        self._shares = forward, turn
        self._stick: Any = None
        self._plug()
        if self._stick is None:
            raise DeviceError("no gamepad is there; give --source keyboard, or connect one")

    def wait(self, seconds: float) -> None:
        """Return when the stick or a button went, at the latest after so long."""
        first = self._pygame.event.wait(max(1, round(seconds * 1000.0)))
        for event in (first, *self._pygame.event.get()):
            if event.type == self._pygame.JOYDEVICEREMOVED:
                self._stick = None
            if self._stick is None:
                self._plug()

    def wish(self, now: float, time: float | None) -> Wish | None:  # noqa: ARG002 - as `Source` has it
        """Return what the stick wants; nothing while there is none."""
        stick = self._stick
        if stick is None or stick.get_numaxes() < 2:
            return NOTHING
        held = [number for number in range(stick.get_numbuttons()) if stick.get_button(number)]
        return of_stick(stick.get_axis, held, *self._shares)

    def _plug(self) -> None:
        if self._pygame.joystick.get_count():
            self._stick = self._pygame.joystick.Joystick(0)


def is_gamepad_there() -> bool:
    """Return whether a gamepad is connected.

    Raises:
        DeviceError: pygame is not installed.
    """
    had = os.environ.get("SDL_VIDEODRIVER")
    pygame = pygame_of(window=False)
    there = bool(pygame.joystick.get_count())
    pygame.quit()
    # The keyboard's window wants a true display.
    if had is None:
        os.environ.pop("SDL_VIDEODRIVER", None)
    return there
