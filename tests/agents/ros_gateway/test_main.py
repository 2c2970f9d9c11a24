"""The command `iw-ros`, without a network."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import pytest

from intellwheels_agents.ros_gateway import main


def test_urdf_is_printed(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert main(["--urdf", "intellwheels"]) == 0
    printed = capsys.readouterr().out
    assert ElementTree.fromstring(printed).get("name") == "intellwheels"
    file = tmp_path / "my-chair.xml"
    file.write_text('<Robot Format="iw.v1" Length="1.0" Width="0.6"/>')
    assert main(["--urdf", str(file)]) == 0
    assert ElementTree.fromstring(capsys.readouterr().out).get("name") == "my_chair"


@pytest.mark.parametrize(("words", "text"), [
    (["--urdf", "nosuch"], "iw-ros: --urdf: expected one of the robots"),
    (["--name", "c", "--robot", "nosuch"], "iw-ros: --robot: expected one of the robots"),
    (["--name", "c", "--robot", ""], "iw-ros: --robot: expected one of the robots"),
    (["--name", "C"], "iw-ros: --name: expected a name"),
    (["--name", "c", "--option", "TopSpeed=fast"], "iw-ros: --option: option TopSpeed: expected"),
    (["--ros-connect", "here"], "iw-ros: --ros-connect: expected"),
])  # fmt: skip
def test_wrong_usage_is_one_line(words: list[str], text: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(words) == 2
    printed = capsys.readouterr().err
    assert printed.startswith(text)
    assert printed.count("\n") == 1


def test_sensors_that_would_have_one_name_are_refused_before_anything_starts(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    sensor = '<Proximity Id="{}" X="0" Y="0" Z="0.4" DirectionDeg="0" ConeDeg="30" MaxRange="4"/>'
    file = tmp_path / "twins.xml"
    sensors = "".join(sensor.format(name) for name in ("a-b", "a_b"))
    file.write_text(f'<Robot Format="iw.v1" Length="1.0" Width="0.6">{sensors}</Robot>')
    assert main(["--name", "c", "--robot", str(file)]) == 2
    assert "sensor 'a_b': expected an id whose name in ROS is not 'a_b'" in capsys.readouterr().err
