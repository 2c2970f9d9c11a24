from __future__ import annotations

import math

import pytest

from intellwheels_agents.bridge.luci_readings import GRAVITY
from intellwheels_agents.bridge.luci_schema import AUTONOMOUS_REMOTE, parsed
from intellwheels_agents.bridge.luci_stand_in import LuciChair, main
from intellwheels_schemas.errors import WireError

AUTO = AUTONOMOUS_REMOTE


def test_it_obeys_the_input_source_that_was_added_and_no_other() -> None:
    luci = LuciChair(0.4, 1.0)
    luci.override(150, 100, AUTO)
    assert luci.chair.stick == (0.0, 0.0)
    luci.add_source(AUTO)
    luci.override(150, 120, AUTO)
    assert luci.chair.stick == (0.5, -0.2)
    luci.override(200, 100, 5)
    assert luci.chair.stick == (0.5, -0.2)
    luci.remove_source(AUTO)
    assert luci.chair.stick == (0.0, 0.0)
    assert [line.split()[0] for line in luci.step(0.01)] == [
        "source", "powered", "moving", "stopped", "source",
    ]  # fmt: skip


def test_its_wheels_turn_by_degrees_and_it_reports_what_it_drives() -> None:
    luci = LuciChair(1.0 / math.pi, 1.0)  # a turn is a metre
    first = parsed("EncoderData", luci.report("EncoderStream")).left_angle
    luci.add_source(AUTO)
    for _ in range(100):
        luci.override(200, 100, AUTO)
        luci.step(0.01)
    turned = parsed("EncoderData", luci.report("EncoderStream")).left_angle - first
    assert turned % 360.0 == pytest.approx(360.0 * 0.9, abs=5.0)
    joystick = parsed("ActiveScaling", luci.report("ActiveScalingStream")).joystick
    assert (joystick.forward_back, joystick.left_right, joystick.source) == (100, 0, AUTO)
    assert parsed("ImuData", luci.report("ImuStream")).gravity_z == GRAVITY


def test_faults_are_commanded() -> None:
    luci = LuciChair(0.4, 1.0)
    luci.command("garbage 1")
    with pytest.raises(WireError):
        parsed("EncoderData", luci.report("EncoderStream"))
    luci.step(1.1)
    luci.command("huge 1")
    assert len(luci.report("RadarStream")) > 262_144
    luci.step(1.1)
    luci.command("wall 2.5")
    heard = parsed("UltrasonicDistances", luci.report("UltrasonicStream"))
    assert [point.y for point in heard.distances[0].arc_points] == [2.5]
    luci.command("stick 40 -10")
    stick = parsed("JoystickData", luci.report("UserJoystickStream"))
    assert (stick.forward_back, stick.left_right) == (40, 10)
    luci.command("radians 1")
    assert parsed("EncoderData", luci.report("EncoderStream")).left_angle < 7.0
    luci.command("magnet 1")
    assert parsed("EncoderData", luci.report("EncoderStream")).left_angle == 0.0
    before = parsed("EncoderData", luci.report("EncoderStream")).edge_timestamp
    luci.command("edge")
    assert parsed("EncoderData", luci.report("EncoderStream")).edge_timestamp < before


@pytest.mark.parametrize("line", ["", "jump", "vanish", "vanish x", "stick 1"])
def test_other_commands_are_refused(line: str) -> None:
    with pytest.raises(ValueError, match=r".*"):
        LuciChair(0.4, 1.0).command(line)


def test_wrong_usage_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["--wheel", "0"])
    assert ended.value.code == 2
    assert "--wheel: expected metres in [0.05, 2]" in capsys.readouterr().err
