from __future__ import annotations

from typing import get_args

import pytest

from intellwheels_agents.bridge.resume_gate import Reason, ResumeGate
from intellwheels_agents.bridge.timeouts import INTERRUPTION, POWER_TIMEOUT


class GateRig:
    """A gate with a clock of its own."""

    def __init__(self, *, confirm: bool = True) -> None:
        self.now = 0.0
        self.lines: list[str] = []
        self.prompts: list[str] = []
        self.gate = ResumeGate(
            "chair1", confirm=confirm, tell=self.lines.append, prompt=self.prompts.append, clock=lambda: self.now
        )

    def drive(self, seconds: float = 1.0) -> None:
        """Receive powers, twenty a second."""
        for _ in range(round(seconds / 0.05)):
            self.now += 0.05
            self.gate.power_received()


def test_the_first_start_needs_no_confirmation() -> None:
    rig = GateRig()
    assert rig.gate.is_open
    rig.gate.joined()
    rig.drive(3.0)
    assert rig.gate.is_open
    assert rig.lines == []


def interrupt(rig: GateRig, reason: Reason) -> None:
    if reason == "silence":
        rig.now += INTERRUPTION + 0.1
    elif reason == "joined-again":
        rig.gate.joined()
    else:
        rig.gate.interrupted(reason)


@pytest.mark.parametrize("reason", ["simulator-gone", "silence", "joined-again"])
def test_after_an_interruption_a_person_says_go(reason: Reason) -> None:
    rig = GateRig()
    rig.gate.joined()
    rig.drive()
    interrupt(rig, reason)
    rig.drive()
    assert not rig.gate.is_open
    rig.gate.confirmed()
    assert rig.gate.is_open
    assert rig.lines == [f"held agent=chair1 reason={reason}", "ready agent=chair1", "resumed agent=chair1"]
    assert rig.prompts[-1] == "chair1: contact is back. Press Enter to let the chair drive on"


def test_a_short_silence_needs_no_confirmation() -> None:
    rig = GateRig()
    rig.gate.joined()
    rig.drive()
    rig.now += INTERRUPTION - 0.1
    rig.drive()
    assert rig.gate.is_open


def test_enter_before_the_contact_is_back_does_not_count() -> None:
    rig = GateRig()
    rig.gate.joined()
    rig.drive()
    rig.gate.interrupted("simulator-gone")
    rig.gate.confirmed()
    assert rig.prompts[-1] == "chair1: not yet, because no power comes from the simulator"
    rig.drive()
    assert not rig.gate.is_open
    # Nor after it was lost again.
    rig.now += POWER_TIMEOUT + 0.1
    rig.gate.confirmed()
    assert not rig.gate.is_open


def test_enter_without_an_interruption_is_ignored() -> None:
    rig = GateRig()
    rig.gate.joined()
    rig.drive()
    rig.gate.confirmed()
    rig.gate.interrupted("simulator-gone")
    rig.drive()
    assert not rig.gate.is_open


def test_a_second_interruption_before_enter_holds_the_chair_again() -> None:
    rig = GateRig()
    rig.gate.joined()
    rig.drive()
    rig.gate.interrupted("simulator-gone")
    rig.drive(INTERRUPTION + 0.5)
    rig.gate.joined()
    rig.gate.confirmed()
    assert not rig.gate.is_open
    rig.drive()
    rig.gate.confirmed()
    assert rig.gate.is_open
    assert rig.lines == [
        "held agent=chair1 reason=simulator-gone", "ready agent=chair1", "held agent=chair1 reason=joined-again",
        "ready agent=chair1", "resumed agent=chair1",
    ]  # fmt: skip
    # Each time a person is asked to press Enter, what happened since is said before.
    assert [text.partition(": ")[2] for text in rig.prompts] == [
        "contact with the simulator was interrupted (simulator-gone); the motors stay off",
        "contact is back. Press Enter to let the chair drive on",
        "contact with the simulator was interrupted again (joined-again); the motors stay off. "
        "Wait until contact is back, then press Enter",
        "not yet, because no power comes from the simulator",
        "contact is back. Press Enter to let the chair drive on",
    ]


def test_with_auto_the_gate_never_closes() -> None:
    rig = GateRig(confirm=False)
    rig.gate.joined()
    rig.drive()
    for reason in get_args(Reason):
        interrupt(rig, reason)
        rig.drive()
        assert rig.gate.is_open
    assert rig.lines == []


@pytest.mark.parametrize("pressed_first", [True, False])
def test_a_join_whose_power_came_before_its_answer_asks_a_person_once(pressed_first: bool) -> None:
    rig = GateRig()
    rig.gate.joined()
    rig.drive()
    rig.gate.interrupted("simulator-gone")
    rig.now += 20.0
    rig.drive(0.1)
    if pressed_first:
        rig.gate.confirmed()
    rig.gate.joined()
    rig.drive()
    rig.gate.confirmed()
    assert rig.gate.is_open
    assert rig.lines == [
        "held agent=chair1 reason=simulator-gone", "ready agent=chair1", "resumed agent=chair1"
    ]  # fmt: skip
    assert sum("Press Enter" in text for text in rig.prompts) == 1
