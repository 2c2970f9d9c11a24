from __future__ import annotations

import threading
from contextlib import nullcontext
from pathlib import Path
from unittest.mock import Mock

import msgspec
import pytest

from intellwheels_schemas.files import write_file
from intellwheels_schemas.identity_file import read_identity
from intellwheels_server.service import router
from intellwheels_server.service.lab_certificates import router_hosts
from intellwheels_server.service.lab_files import LabFiles, read_users
from intellwheels_server.service.lab_keys import RESTART, main
from tests.server.service.test_lab_router import LAB


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "LAB.xml").write_text(write_file(LAB))
    return tmp_path


def test_keys_gives_each_identity_a_password_of_its_own_once(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["keys"]) == 0
    users = read_users(folder / "LAB.users")
    assert list(users) == ["sim", "student1", "idle"]
    assert len(set(users.values())) == 3
    assert min(map(len, users.values())) >= 32
    assert (folder / "LAB.users").stat().st_mode & 0o777 == 0o600
    assert capsys.readouterr().err == f"iw-lab: {RESTART}\n"
    assert main(["keys"]) == 0
    assert read_users(folder / "LAB.users") == users
    assert capsys.readouterr() == ("", "")


def test_passwords_that_others_can_read_are_warned_of_by_lab_and_router(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert main(["keys"]) == 0
    users = folder / "LAB.users"
    users.chmod(0o644)
    capsys.readouterr()
    words = f"{users}: others can read this secret; run chmod 600 {users}\n"
    assert main(["keys"]) == 0
    assert capsys.readouterr().err == f"iw-lab: warning: {words}"
    monkeypatch.setattr(router, "open_router", lambda *_: nullcontext())
    monkeypatch.setattr(router, "PanicWatch", Mock())
    monkeypatch.setattr(router, "answer_rights", lambda *_: [])
    monkeypatch.setattr(router, "guard_sessions", lambda *_: Mock())
    stopped = threading.Event()
    monkeypatch.setattr(router, "stop_on_signals", lambda _: stopped)
    monkeypatch.setattr(stopped, "wait", lambda _: True)
    assert router.main(["--lab", "LAB.xml", "--no-denials"]) == 0
    assert f"iw-router: warning: {words}" in capsys.readouterr().err


def test_invite_writes_a_file_that_any_command_takes(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["invite", "student1", "--connect", "tcp/10.0.0.5:7447"]) == 0
    own = read_identity(folder / "student1.iwid")
    assert (own.name, own.connect) == ("student1", ("tcp/10.0.0.5:7447",))
    assert own.password == read_users(folder / "LAB.users")["student1"]
    assert own.password not in "".join(capsys.readouterr())
    main(["invite", "student1", "--out", "again.iwid"])
    assert read_identity(folder / "again.iwid").password == own.password


def test_invite_to_an_encrypted_endpoint_makes_the_certificates(folder: Path) -> None:
    assert main(["invite", "student1", "--connect", "tls/10.0.0.5:7447"]) == 0
    own = read_identity(folder / "student1.iwid")
    assert own.authority
    assert "10.0.0.5" in router_hosts(LabFiles(Path("LAB.xml")))


def test_revoked_file_is_void_and_the_others_stay(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    main(["keys"])
    before = read_users(folder / "LAB.users")
    assert main(["revoke", "student1"]) == 0
    after = read_users(folder / "LAB.users")
    assert {name for name in before if before[name] != after[name]} == {"student1"}
    told = capsys.readouterr()
    assert told.out.endswith("revoked identity=student1\n")
    assert RESTART in told.err
    assert told.err.endswith("iw-lab: write a new file with iw-lab invite student1\n")


def test_certificates_come_with_a_host_and_the_file_has_the_authority(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["keys", "--host", "lab.org"]) == 0
    assert "hosts=127.0.0.1,::1,lab.org,localhost" in capsys.readouterr().out
    assert main(["invite", "student1", "--connect", "tls/lab.org:7447"]) == 0
    own = read_identity(folder / "student1.iwid")
    assert own.authority.startswith("-----BEGIN CERTIFICATE")
    assert own.certificate == "", "a password is enough here"
    assert main(["invite", "student1", "--connect", "tls/10.0.0.9:7447"]) == 2
    assert "got 10.0.0.9; run iw-lab keys --host 10.0.0.9 first" in capsys.readouterr().err


def test_renewed_file_keeps_its_password_and_endpoint_and_ends_later(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    needed = (msgspec.structs.replace(LAB.identity[0], certificate=True), *LAB.identity[1:])
    (folder / "LAB.xml").write_text(write_file(msgspec.structs.replace(LAB, identity=needed)))
    # The first invitation makes the certificate of the router, for the hosts at which it is reached.
    assert main(["invite", "student1", "--connect", "tls/lab.org:7447", "--days", "10"]) == 0
    assert "wrote certificate=router hosts=127.0.0.1,::1,lab.org,localhost" in capsys.readouterr().out
    before = read_identity(folder / "student1.iwid")
    assert main(["renew", "student1"]) == 0
    after = read_identity(folder / "student1.iwid")
    assert (after.password, after.connect) == (before.password, before.connect)
    assert (after.until or "") > (before.until or "")
    assert after.certificate != before.certificate
    assert before.private_key not in "".join(capsys.readouterr())


def test_identity_past_its_last_day_has_no_password_and_no_invitation(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    main(["keys"])
    ended = (*LAB.identity[:2], msgspec.structs.replace(LAB.identity[2], until="2020-01-31"))
    (folder / "LAB.xml").write_text(write_file(msgspec.structs.replace(LAB, identity=ended)))
    assert main(["invite", "idle"]) == 2
    assert "Lab.Identity[2].Until: expected today or later to invite idle, got 2020-01-31" in capsys.readouterr().err
    assert main(["keys"]) == 0
    assert list(read_users(folder / "LAB.users")) == ["sim", "student1"]


def test_new_lab_and_files_for_everybody(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["new", "--students", "2", "--chair", "real1"]) == 0
    assert main(["new"]) == 2
    assert main(["keys"]) == 0
    assert main(["invite"]) == 0
    names = {"simulator", "teacher", "recorder", "student1", "student2", "bridge-real1"}
    assert {file.stem for file in tmp_path.glob("*.iwid")} == names
    assert main(["invite", "--out", "x.iwid"]) == 2
    assert main(["new", "--chair", "Real!", "--lab", "b.xml"]) == 2


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["--lab", "Room 3.xml"], "--lab: expected a word of letters"),
        (["--lab", "b.xml", "--chair", "a" * 32], "--chair: the name of its bridge: expected a name of a-z"),
        (
            ["--lab", "b.xml", "--chair", "st1-real"],
            "does not begin with st1-, got st1-real, which a student could drive",
        ),
    ],
)
def test_new_lab_that_no_command_would_take_or_that_opens_a_chair_is_refused(
    folder: Path, words: list[str], text: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["new", *words]) == 2
    assert text in capsys.readouterr().err
    assert [file.name for file in folder.iterdir()] == ["LAB.xml"]


@pytest.mark.parametrize("host", ["", "a b", "café", "10.0.0.5:7447", "*", "lab.org:7447", "fe80::1]"])
def test_host_that_no_endpoint_can_have_is_refused(folder: Path, host: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as caught:
        main(["keys", "--host", host])
    assert caught.value.code == 2
    assert f"--host: expected a host name or an address without a port, got {host!r}" in capsys.readouterr().err
    assert [file.name for file in folder.iterdir()] == ["LAB.xml"]


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["invite", "mallory"], "NAME: expected an identity of LAB.xml, got 'mallory'"),
        (["revoke", "mallory"], "NAME: expected an identity of LAB.xml, got 'mallory'"),
        (["invite", "sim", "--connect", "nowhere"], "--connect"),
    ],
)
def test_wrong_use_is_told(folder: Path, words: list[str], text: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(words) == 2
    assert text in capsys.readouterr().err
    assert not (folder / "LAB.users").exists()


def test_router_refuses_a_lab_without_passwords_and_prints_its_rules(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert router.main(["--lab", "LAB.xml", "--listen", "tcp/127.0.0.1:1"]) == 2
    assert "expected the users that iw-lab keys writes" in capsys.readouterr().err
    (folder / "LAB.users").write_text("sim:12345678\n")
    assert router.main(["--lab", "LAB.xml", "--listen", "tcp/127.0.0.1:1"]) == 2
    assert "expected a password for student1, idle, got none; run iw-lab keys" in capsys.readouterr().err
    assert router.main(["--lab", "LAB.xml", "--print"]) == 0
    printed = capsys.readouterr().out
    assert '"default_permission": "deny"' in printed
    assert "12345678" not in printed
