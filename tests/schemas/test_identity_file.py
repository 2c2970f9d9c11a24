from __future__ import annotations

import base64
import datetime
import os
import subprocess
import sys
from pathlib import Path

import msgspec
import pytest

from intellwheels_schemas.errors import WireError
from intellwheels_schemas.identity_file import (
    IdentityFile,
    check_identity,
    identity_text,
    read_identity,
    write_secret,
)
from intellwheels_schemas.messages import May

OWN = IdentityFile(name="student1", password="correct-horse", connect=("tcp/10.0.0.5:7447",))


def test_identity_is_read_as_it_was_written_and_belongs_to_its_owner(tmp_path: Path) -> None:
    path = tmp_path / "student1.iwid"
    path.write_text("old")
    path.chmod(0o644)
    write_secret(path, identity_text(OWN))
    assert read_identity(path) == OWN
    assert path.stat().st_mode & 0o777 == 0o600
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    "data",
    [b"", b"{", b"[]", b'{"Identity":"iw.v1","Name":"a"}', b'{"Identity":"iw.v2","Name":"a","Password":"12345678"}',
     b'{"Identity":"iw.v1","Name":"A!","Password":"12345678"}',
     b'{"Identity":"iw.v1","Name":"a","Password":"1:345678"}',
     b'{"Identity":"iw.v1","Name":"a","Password":"secret"}', b"\xff"],
)  # fmt: skip
def test_anything_else_is_refused_without_being_shown(tmp_path: Path, data: bytes) -> None:
    path = tmp_path / "x.iwid"
    path.write_bytes(data)
    with pytest.raises(WireError) as caught:
        read_identity(path)
    assert caught.value.text == f"{path}: expected an identity file as iw-lab invite writes it, got something else"
    assert caught.value.__suppress_context__


def test_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(WireError, match="expected an identity file, got No such file or directory"):
        read_identity(tmp_path / "none.iwid")


def test_what_may_be_done_is_kept_in_the_file() -> None:
    own = msgspec.structs.replace(OWN, may=(May(role="agent", agents=("st1-*",)), May(role="viewer")))
    assert msgspec.json.decode(identity_text(own), type=IdentityFile) == own


def test_password_is_not_in_its_repr() -> None:
    assert "horse" not in repr(OWN)


@pytest.mark.parametrize(
    ("today", "left", "warns"),
    [("2026-12-24", 7, True), ("2026-12-23", 8, False), ("2026-12-31", 0, True)],
)
def test_identity_warns_a_week_before_its_end(tmp_path: Path, today: str, left: int, warns: bool) -> None:
    path = tmp_path / "student1.iwid"
    own = msgspec.structs.replace(OWN, until="2026-12-31")
    write_secret(path, identity_text(own))
    day = datetime.date.fromisoformat(today)
    assert own.days_left(day) == left
    words = f"{path}: student1 expires after 2026-12-31; ask for another file, made with iw-lab renew student1"
    assert check_identity(path, day) == (words if warns else "")
    with pytest.raises(WireError, match="expired after 2026-12-31; ask for another file"):
        check_identity(path, datetime.date(2027, 1, 1))


def test_identity_that_ends_soon_still_warns_that_others_can_read_it(tmp_path: Path) -> None:
    path = tmp_path / "student1.iwid"
    write_secret(path, identity_text(msgspec.structs.replace(OWN, until="2026-12-31")))
    path.chmod(0o644)
    warning = check_identity(path, datetime.date(2026, 12, 31))
    assert "expires after 2026-12-31" in warning
    assert f"run chmod 600 {path}" in warning


def test_identity_without_an_end_counts_for_ever() -> None:
    assert OWN.days_left(datetime.date(2090, 1, 1)) is None


def test_settings_show_what_the_file_has() -> None:
    assert OWN.settings() == {"transport/auth/usrpwd": {"user": "student1", "password": "correct-horse"}}
    more = msgspec.structs.replace(OWN, authority="CA", certificate="CERT", private_key="KEY").settings()
    tls = "transport/link/tls"
    assert base64.b64decode(more[f"{tls}/root_ca_certificate_base64"]) == b"CA"
    assert base64.b64decode(more[f"{tls}/connect_certificate_base64"]) == b"CERT"
    assert base64.b64decode(more[f"{tls}/connect_private_key_base64"]) == b"KEY"
    assert more[f"{tls}/enable_mtls"] is True


@pytest.mark.process
@pytest.mark.parametrize("level", ["trace", "zenoh::api::session=trace"])
def test_log_of_zenoh_has_no_password(tmp_path: Path, level: str) -> None:
    path = tmp_path / "student1.iwid"
    write_secret(path, identity_text(OWN))
    program = (
        "import sys, threading, pathlib\n"
        "from intellwheels_schemas import link\n"
        "route = link.Link(connect=('tcp/127.0.0.1:1',), identity=pathlib.Path(sys.argv[1]))\n"
        "try: link.open_session(route, threading.Event(), timeout=0.0)\n"
        "except ConnectionError: print('tried')"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, str(path)], env={**os.environ, "RUST_LOG": level}, capture_output=True,
        text=True, timeout=60.0, check=True,
    )  # fmt: skip
    assert "tried" in done.stdout
    assert level != "trace" or "zenoh" in done.stdout + done.stderr
    assert OWN.password not in done.stdout + done.stderr
