from __future__ import annotations

from pathlib import Path

import msgspec
import pytest

from intellwheels_schemas.errors import WireError
from intellwheels_schemas.identity_file import IdentityFile, identity_text, read_identity, write_secret
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
