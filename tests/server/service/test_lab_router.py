from __future__ import annotations

import datetime
import json
from pathlib import Path

import pytest
import zenoh

from intellwheels_schemas.errors import WireError
from intellwheels_schemas.files import write_file
from intellwheels_schemas.messages import Identity, Lab, May
from intellwheels_schemas.router_link import router_settings
from intellwheels_server.service.lab_files import LabFiles, read_lab, read_users
from intellwheels_server.service.lab_router import lab_settings

TODAY = datetime.date(2026, 11, 1)
LAB = Lab(
    format="iw.v1",
    name="room3",
    identity=(
        Identity(name="sim", may=(May(role="simulator"),)),
        Identity(name="student1", may=(May(role="agent", agents=("st1-*",)), May(role="viewer", agents=("st1-*",)))),
        Identity(name="idle"),
    ),
)


def test_zenoh_accepts_the_settings_and_default_is_deny() -> None:
    text = router_settings(["tcp/127.0.0.1:7000"], lab_settings(LAB, LabFiles(Path("/x/room3.xml")), TODAY))
    rules = json.loads(zenoh.Config.from_json5(text).get_json("access_control"))
    assert (rules["enabled"], rules["default_permission"]) == (True, "deny")
    assert {rule["permission"] for rule in rules["rules"]} == {"allow"}
    assert [policy["subjects"] for policy in rules["policies"]] == [["sim"], ["student1"]]
    assert len({rule["id"] for rule in rules["rules"]}) == len(rules["rules"])
    assert json.loads(text)["transport"]["auth"]["usrpwd"] == {"dictionary_file": "/x/room3.users"}


def test_lab_is_read_with_file_and_line_in_its_errors(tmp_path: Path) -> None:
    path = tmp_path / "room3.xml"
    path.write_text(write_file(LAB))
    assert read_lab(path) == LAB
    assert LabFiles(path).users == tmp_path / "room3.users"
    path.write_text(write_file(LAB).replace('Name="idle"', 'Name="sim"'))
    with pytest.raises(WireError) as caught:
        read_lab(path)
    assert caught.value.text == f"{path}:9: Lab.Identity[2].Name: expected each name once, got 'sim' twice"


def test_users_are_read_and_a_wrong_line_is_not_shown(tmp_path: Path) -> None:
    path = tmp_path / "room3.users"
    path.write_text("sim:secret12\nidle:secret34\n")
    assert read_users(path) == {"sim": "secret12", "idle": "secret34"}
    path.write_text("sim:secret12\nsecret34\n")
    with pytest.raises(WireError) as caught:
        read_users(path)
    assert caught.value.text == f"{path}:2: expected name:password, got another line"
    with pytest.raises(WireError, match="expected the users that iw-lab keys writes, got No such file"):
        read_users(tmp_path / "none")
