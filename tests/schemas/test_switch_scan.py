"""Scanning with switches and by dwell, at times that the test chooses."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import pytest

from intellwheels_schemas.switch_scan import COMMANDS, ScanSettings, SwitchScan

STOPPED = (0.0, 0.0)
STEP = 0.05


class Person:
    """Somebody who presses and waits; the scan is updated 20 times a second meanwhile."""

    def __init__(self, **settings: Any) -> None:
        self.scan = SwitchScan(ScanSettings(**settings))
        self.now = 100.0
        self.drive = self.scan.update(self.now)

    def does(self, seconds: float, pressed: Collection[int] = (), over: str | None = None) -> tuple[float, float]:
        for _ in range(round(seconds / STEP)):
            self.now += STEP
            self.drive = self.scan.update(self.now, pressed, over)
        return self.drive

    @property
    def lit(self) -> str:
        return self.scan.view.lit


def test_commands_are_highlighted_in_turn_and_nothing_drives_by_itself() -> None:
    person = Person(period=1.0)
    seen = [person.lit]
    for _ in range(200):
        assert person.does(STEP) == STOPPED
        seen += [person.lit] if person.lit != seen[-1] else []
    assert seen[:6] == [*COMMANDS, "forward"]
    assert 9 <= len(seen) <= 11


@pytest.mark.parametrize("command", [name for name in COMMANDS if name != "stop"])
def test_one_switch_drives_while_it_is_held(command: str) -> None:
    person = Person(period=1.0)
    while person.lit != command:
        person.does(STEP)
    assert person.does(5.0, [1]) == COMMANDS[command]
    assert person.scan.view.driving == command
    assert person.does(STEP) == STOPPED
    # The highlight stays for a period: the next press drives the same way.
    assert person.does(STEP, [1]) == COMMANDS[command]


def test_selecting_stop_drives_nothing() -> None:
    person = Person(period=1.0)
    while person.lit != "stop":
        person.does(STEP)
    assert person.does(1.0, [1]) == STOPPED


def test_two_switches_move_and_select() -> None:
    person = Person(method="step")
    assert person.does(60.0) == STOPPED
    assert person.lit == "forward"
    for _ in range(2):
        person.does(0.1, [1])
        person.does(0.1)
    assert person.lit == "right"
    assert person.does(1.0, [2]) == COMMANDS["right"]
    assert person.does(STEP) == STOPPED


def test_latched_drives_until_the_next_press_but_never_longer_than_its_time() -> None:
    person = Person(latch=True, hold=2.0)
    person.does(0.1, [1])
    assert person.does(1.5) == COMMANDS["forward"]
    # The press that stops does not select.
    assert person.does(0.5, [1]) == STOPPED
    person.does(0.1)
    person.does(0.1, [1])
    assert person.does(1.8) == COMMANDS["forward"]
    assert person.does(0.2) == STOPPED


def test_resting_a_pointer_selects_and_leaving_stops() -> None:
    person = Person(method="dwell", dwell=0.8, hold=3.0)
    assert person.does(0.7, over="left") == STOPPED
    assert person.scan.view.resting
    assert person.does(0.2, over="left") == COMMANDS["left"]
    assert person.does(STEP, over="right") == STOPPED
    assert person.does(0.7, over="right") == STOPPED
    assert person.does(0.2, over="right") == COMMANDS["right"]
    assert person.does(STEP) == STOPPED
    assert person.does(5.0) == STOPPED


def test_a_pointer_that_stays_where_it_was_forgotten_stops_driving() -> None:
    person = Person(method="dwell", dwell=0.5, hold=2.0)
    assert person.does(1.0, over="forward") == COMMANDS["forward"]
    assert person.does(1.7, over="forward") == STOPPED
    assert person.does(60.0, over="forward") == STOPPED
    person.does(0.1)
    assert person.does(0.7, over="forward") == COMMANDS["forward"]


def test_dwell_with_one_switch_begins_with_a_press() -> None:
    person = Person(method="dwell", dwell=0.5, hold=2.0)
    assert person.does(10.0) == STOPPED
    person.does(0.1, [1])
    assert person.lit == "left"
    assert person.does(0.6) == COMMANDS["left"]
    assert person.does(2.0) == STOPPED
    assert person.does(10.0) == STOPPED


@pytest.mark.parametrize(("method", "switch"), [("auto", 1), ("step", 2)])
def test_a_confirmed_command_is_selected_twice(method: str, switch: int) -> None:
    person = Person(method=method, confirm=True, period=1.0)
    assert person.does(0.2, [switch]) == STOPPED
    assert person.scan.view.armed
    person.does(0.2)
    assert person.does(0.5, [switch]) == COMMANDS["forward"]


@pytest.mark.parametrize(("method", "switch"), [("auto", 1), ("step", 2)])
def test_a_press_that_a_terminal_shows_as_two_does_not_confirm_itself(method: str, switch: int) -> None:
    person = Person(method=method, confirm=True, period=5.0, pause=0.5)
    person.does(0.3, [switch])
    person.does(0.3)
    assert person.does(2.0, [switch]) == STOPPED
    assert person.scan.view.armed
    person.does(0.6)
    assert person.does(0.2, [switch]) == COMMANDS["forward"]


def test_an_unconfirmed_command_is_dropped() -> None:
    person = Person(confirm=True, period=1.0)
    person.does(0.2, [1])
    person.does(2.1)
    assert not person.scan.view.armed
    assert person.lit == "left"
    person = Person(method="step", confirm=True)
    person.does(0.2, [2])
    person.does(0.2, [1])
    assert not person.scan.view.armed


def test_a_dwell_is_confirmed_by_a_second_one_and_dropped_by_leaving() -> None:
    person = Person(method="dwell", dwell=0.5, confirm=True)
    assert person.does(0.7, over="back") == STOPPED
    assert person.scan.view.armed
    assert person.does(0.6, over="back") == COMMANDS["back"]
    person = Person(method="dwell", dwell=0.5, confirm=True)
    person.does(0.7, over="back")
    person.does(0.1)
    assert not person.scan.view.armed
    assert person.does(0.7, over="back") == STOPPED


@pytest.mark.parametrize("settings", [{}, {"latch": True, "hold": 60.0}])
def test_silence_stops_and_a_switch_that_is_still_held_selects_nothing(settings: dict[str, Any]) -> None:
    person = Person(**settings)
    held = [] if settings else [1]
    person.does(0.1, [1])
    assert person.does(1.0, held) == COMMANDS["forward"]
    person.now += 0.5
    assert person.does(STEP, [1]) == STOPPED
    assert person.does(5.0, [1]) == STOPPED
    person.does(0.1)
    assert person.does(0.1, [1]) != STOPPED


def test_a_switch_that_is_held_from_the_start_selects_nothing() -> None:
    scan = SwitchScan(ScanSettings())
    assert [scan.update(k * STEP, [1]) for k in range(100)] == [STOPPED] * 100


def test_what_is_no_command_is_nowhere() -> None:
    person = Person(method="dwell", dwell=0.5)
    assert person.does(5.0, [7], over="<script>") == STOPPED
