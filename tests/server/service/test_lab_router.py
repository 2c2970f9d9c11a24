from __future__ import annotations

import datetime
import json
from pathlib import Path

import msgspec
import pytest
import zenoh

from intellwheels_schemas.errors import WireError
from intellwheels_schemas.files import write_file
from intellwheels_schemas.messages import Identity, Lab, May
from intellwheels_schemas.router_link import router_settings
from intellwheels_server.service.lab_certificates import authority_of, ensure_router
from intellwheels_server.service.lab_files import LabFiles, read_lab, read_users
from intellwheels_server.service.lab_router import checked_settings, lab_settings

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
    assert [policy["subjects"] for policy in rules["policies"]] == [["sim"], ["student1"], ["idle"]]
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


def test_expired_identity_has_no_rules_and_a_certificate_is_asked_for_beside_the_password(tmp_path: Path) -> None:
    files = LabFiles(tmp_path / "room3.xml")
    identities = (
        msgspec.structs.replace(LAB.identity[0], certificate=True),
        msgspec.structs.replace(LAB.identity[1], until="2026-10-31"),
    )
    lab = msgspec.structs.replace(LAB, identity=identities)
    settings = lab_settings(lab, files, TODAY)
    assert settings["access_control"]["subjects"] == [{"id": "sim", "usernames": ["sim"], "cert_common_names": ["sim"]}]
    assert "transport/link/tls" not in settings
    files.lab.write_text(write_file(lab))
    with pytest.raises(WireError, match="expected the router's certificate, got none; run iw-lab keys"):
        checked_settings(files, TODAY, printed=True)
    files.router.write_text("Until: 2026-10-31\n")
    with pytest.raises(WireError, match="the router's certificate expired after 2026-10-31; run iw-lab keys"):
        checked_settings(files, TODAY, printed=True)


def test_printed_configuration_is_a_file_that_zenoh_takes(tmp_path: Path) -> None:
    files = LabFiles(tmp_path / "room3.xml")
    ensure_router(files, authority_of(files, "room3", TODAY), (), TODAY)
    lab = msgspec.structs.replace(LAB, identity=(msgspec.structs.replace(LAB.identity[0], certificate=True),))
    printed = tmp_path / "router.json5"
    printed.write_text(router_settings(["tls/127.0.0.1:7000"], lab_settings(lab, files, TODAY)))
    config = zenoh.Config.from_file(str(printed))
    tls = json.loads(config.get_json("transport/link/tls"))
    assert tls["enable_mtls"] is True
    assert tls["listen_private_key"] == str(files.router_key)
    assert "PRIVATE" not in printed.read_text()
    assert json.loads(config.get_json("low_pass_filter"))
    assert json.loads(config.get_json("adminspace"))["enabled"] is False
    assert json.loads(config.get_json("scouting/gossip"))["enabled"] is False
