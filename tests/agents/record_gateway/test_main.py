"""The command `iw-record`, without a network."""

from __future__ import annotations

import json
import re

import pytest

from intellwheels_agents.record_gateway import main


def test_the_layout_is_json_and_each_panel_of_it_is_configured(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--layout"]) == 0
    layout = json.loads(capsys.readouterr().out)
    panels = set(re.findall(r'"(\w+!\w+)"', json.dumps(layout["layout"])))
    assert panels == layout["configById"].keys()
    assert layout["configById"]["Publish!drive"]["topicName"] == "/user/chair1"
    assert json.loads(layout["configById"]["Publish!drive"]["value"]) == {"Forward": 0.5, "Turn": 0}


def test_neither_file_nor_live_view_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([]) == 2
    assert capsys.readouterr().err == "iw-record: FILE.mcap: expected a file, --ros2 or --live, got none of them\n"
