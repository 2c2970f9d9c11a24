"""The keyboard's window, without a display: SDL's dummy driver takes posted keys."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from intellwheels_agents.joystick import pygame_source
from intellwheels_agents.joystick.input_state import NEUTRAL, InputState, KeyReader
from intellwheels_agents.joystick.key_bindings import GENTLE, DrivingKeys
from intellwheels_agents.joystick.scan_keys import ScanKeys
from intellwheels_agents.joystick.sip_and_puff import DEFAULT_KEYS, SipAndPuff
from intellwheels_schemas.switch_scan import ScanSettings

pygame = pytest.importorskip("pygame", reason="keyboard and gamepad need the extra `joystick`")


@pytest.fixture
def keyboard(monkeypatch: pytest.MonkeyPatch) -> Iterator[pygame_source.KeyboardSource]:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    yield pygame_source.KeyboardSource("test", DrivingKeys(1.0, 0.5))
    pygame.quit()


def post(source: pygame_source.KeyboardSource, kind: int, **fields: int) -> InputState | None:
    pygame.event.post(pygame.event.Event(kind, **fields))
    source.wait(1.0)
    return source.state(0.0, None)


def test_a_key_counts_from_press_to_release(keyboard: pygame_source.KeyboardSource) -> None:
    assert keyboard.state(0.0, None) == NEUTRAL
    assert post(keyboard, pygame.KEYDOWN, key=pygame.K_UP) == InputState(GENTLE)
    assert post(keyboard, pygame.KEYDOWN, key=pygame.K_a) == InputState(GENTLE, GENTLE * 0.5)
    assert post(keyboard, pygame.KEYDOWN, key=pygame.K_LSHIFT) == InputState(1.0, 0.5)
    assert post(keyboard, pygame.KEYDOWN, key=pygame.K_KP3) == InputState(1.0, 0.5, (3,))
    assert post(keyboard, pygame.KEYUP, key=pygame.K_LSHIFT) == InputState(GENTLE, GENTLE * 0.5, (3,))
    assert post(keyboard, pygame.KEYUP, key=pygame.K_UP) == InputState(0.0, GENTLE * 0.5, (3,))


def test_the_window_shows_a_scan_and_its_switch_drives(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    reader = ScanKeys(ScanSettings(period=60.0), ("enter",), 0.8, 0.4)
    source = pygame_source.KeyboardSource("test", reader)
    assert source.state(0.0, None) == NEUTRAL
    assert source._shown == (NEUTRAL, reader.caption)
    assert post(source, pygame.KEYDOWN, key=pygame.K_RETURN) == InputState(0.8)
    assert source._shown == (InputState(0.8), reader.caption)
    assert ">FORWARD<" in reader.caption
    assert post(source, pygame.KEYUP, key=pygame.K_RETURN) == NEUTRAL
    pygame.quit()


def test_losing_the_focus_releases_all_keys(keyboard: pygame_source.KeyboardSource) -> None:
    assert post(keyboard, pygame.KEYDOWN, key=pygame.K_UP) == InputState(GENTLE)
    assert post(keyboard, pygame.WINDOWFOCUSLOST) == NEUTRAL


@pytest.mark.parametrize(
    "reader",
    [
        ScanKeys(ScanSettings(period=60.0, latch=True, hold=60.0), ("up",), 0.8, 0.4),
        ScanKeys(ScanSettings(method="dwell", dwell=0.2, hold=60.0), ("up",), 0.8, 0.4),
        SipAndPuff(DEFAULT_KEYS, 0.8, 0.4, latch=True, hold=60.0),
    ],
)
def test_losing_the_focus_ends_what_drives_without_a_key(monkeypatch: pytest.MonkeyPatch, reader: KeyReader) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    source = pygame_source.KeyboardSource("test", reader)
    source.state(0.0, None)
    post(source, pygame.KEYDOWN, key=pygame.K_UP)
    post(source, pygame.KEYUP, key=pygame.K_UP)
    assert source.state(0.25, None) != NEUTRAL
    pygame.event.post(pygame.event.Event(pygame.WINDOWFOCUSLOST))
    source.wait(1.0)
    # It ends at once, and a rest that was being counted does not drive either.
    assert [source.state(0.3 + 0.1 * number, None) for number in range(10)] == [NEUTRAL] * 10
    pygame.quit()


def test_a_press_counts_though_its_release_comes_with_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    reader = ScanKeys(ScanSettings(period=60.0, latch=True, hold=60.0), ("enter",), 0.8, 0.4)
    source = pygame_source.KeyboardSource("test", reader)
    source.state(0.0, None)
    for now, driven in ((0.1, InputState(0.8)), (0.3, NEUTRAL)):
        pygame.event.post(pygame.event.Event(pygame.KEYDOWN, key=pygame.K_RETURN))
        pygame.event.post(pygame.event.Event(pygame.KEYUP, key=pygame.K_RETURN))
        source.wait(1.0)
        assert source.state(now, None) == driven
        source.wait(0.0)
        assert source.state(now + 0.1, None) == driven
    pygame.quit()


@pytest.mark.parametrize("how", ["escape", "closed"])
def test_escape_or_closing_the_window_ends_it(keyboard: pygame_source.KeyboardSource, how: str) -> None:
    if how == "escape":
        assert post(keyboard, pygame.KEYDOWN, key=pygame.K_ESCAPE) is None
    else:
        assert post(keyboard, pygame.QUIT) is None


def test_a_missing_gamepad_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    if pygame_source.has_gamepad():
        pytest.skip("a gamepad is there")
    with pytest.raises(pygame_source.DeviceError, match="no gamepad found"):
        pygame_source.GamepadSource(1.0, 1.0)
    pygame.quit()


def test_without_pygame_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "pygame", None)
    with pytest.raises(pygame_source.DeviceError, match=r"pip install '\.\[joystick\]'"):
        pygame_source.has_gamepad()


class Stick:
    """A gamepad."""

    def get_numaxes(self) -> int:
        return 2

    def get_axis(self, number: int) -> float:
        return (0.0, -1.0)[number]

    def get_numbuttons(self) -> int:
        return 3

    def get_button(self, number: int) -> bool:
        return number == 1


def test_an_unplugged_gamepad_is_neutral_until_it_is_back(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    there = [1]
    monkeypatch.setattr(pygame.joystick, "get_count", lambda: there[0])
    monkeypatch.setattr(pygame.joystick, "Joystick", lambda _: Stick())
    source = pygame_source.GamepadSource(0.5, 0.5)
    assert source.state(0.0, None) == InputState(0.5, 0.0, (1,))
    there[0] = 0
    pygame.event.post(pygame.event.Event(pygame.JOYDEVICEREMOVED))
    source.wait(1.0)
    assert source.state(0.0, None) == NEUTRAL
    there[0] = 1
    pygame.event.post(pygame.event.Event(pygame.JOYDEVICEADDED))
    source.wait(1.0)
    assert source.state(0.0, None) == InputState(0.5, 0.0, (1,))
    pygame.quit()


def test_without_a_display_both_ways_are_named_and_no_library_prints(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    for name in ("SDL_VIDEODRIVER", "DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    with pytest.raises(pygame_source.DeviceError, match=r"expected a display .* a terminal on standard input"):
        pygame_source.KeyboardSource("test", DrivingKeys(1.0, 0.5))
    assert not pygame.display.get_init()
    assert capfd.readouterr() == ("", "")
