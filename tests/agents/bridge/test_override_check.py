from __future__ import annotations

from intellwheels_agents.bridge.override_check import MEMORY, PERSISTENCE, OverrideCheck


def explained(check: OverrideCheck, forward: float, turn: float, at: float) -> list[bool]:
    """Report the same for longer than a difference must last."""
    return [check.is_explained(forward, turn, at + step * PERSISTENCE / 4.0) for step in range(6)]


def test_what_was_sent_or_scaled_down_is_explained() -> None:
    check = OverrideCheck()
    check.sent(0.8, -0.4, 0.0)
    assert all(explained(check, 0.8, -0.4, 0.1))
    assert all(explained(check, 0.2, 0.0, 0.2))
    assert all(explained(check, 0.0, 0.0, 0.3))


def test_a_chair_that_drives_otherwise_is_found_after_a_moment() -> None:
    check = OverrideCheck()
    check.sent(0.0, 0.0, 0.0)
    found = explained(check, 1.0, 0.0, 0.1)
    assert found[0]
    assert not found[-1]
    assert not explained(check, -0.5, 0.0, 1.0)[-1]
    # One report that fits starts the moment again.
    assert check.is_explained(0.05, 0.0, 2.0)
    assert check.is_explained(1.0, 0.0, 2.1)


def test_an_old_override_explains_nothing_once_another_is_in_force() -> None:
    check = OverrideCheck()
    check.sent(0.8, 0.0, 0.0)
    check.sent(0.0, 0.0, 0.1)
    assert all(explained(check, 0.8, 0.0, 0.2))
    assert not explained(check, 0.8, 0.0, 0.2 + MEMORY)[-1]


def test_the_last_override_stays_in_force() -> None:
    check = OverrideCheck()
    check.sent(0.8, 0.0, 0.0)
    assert all(explained(check, 0.8, 0.0, 100.0))
