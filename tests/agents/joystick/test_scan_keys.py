"""Keys as switches: what they select, and what is shown. `test_switch_scan` tests the scan itself."""

from __future__ import annotations

from intellwheels_agents.joystick.input_state import NEUTRAL, InputState
from intellwheels_agents.joystick.scan_keys import DEFAULT_KEYS, ScanKeys
from intellwheels_schemas.switch_scan import ScanSettings


def test_a_key_is_a_switch_and_the_shares_count() -> None:
    scan = ScanKeys(ScanSettings(method="step"), DEFAULT_KEYS, 0.8, 0.4)
    assert set(scan.keys) == {"space", "enter"}
    assert scan.read((), 0.0) == NEUTRAL
    assert scan.caption.split() == ["[forward]", "left", "right", "back", "stop"]
    assert scan.read({"space"}, 0.1) == scan.read({"x"}, 0.2) == NEUTRAL
    assert scan.read({"enter"}, 0.3) == InputState(turn=0.4)
    assert scan.caption.split() == ["forward", ">LEFT<", "right", "back", "stop"]
    assert scan.read((), 0.4) == NEUTRAL


def test_one_key_is_enough_and_a_confirmation_is_shown() -> None:
    scan = ScanKeys(ScanSettings(confirm=True), ("f5",), 0.8, 0.4)
    assert "f5 selects the highlighted command, again to confirm" in scan.help
    scan.read((), 0.0)
    assert scan.read({"f5"}, 0.1) == NEUTRAL
    assert scan.caption.split()[0] == "?forward?"
    scan.read((), 0.2)
    assert scan.read({"f5"}, 0.3) == InputState(0.8)
