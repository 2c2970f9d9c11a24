from __future__ import annotations

import argparse
from pathlib import Path

import pytest

from intellwheels_schemas.errors import WireError
from intellwheels_schemas.identity_file import IdentityFile, identity_text, write_secret
from intellwheels_schemas.identity_option import add_identity_option, check_option, router_of


def written(folder: Path, **fields: object) -> Path:
    path = folder / "student1.iwid"
    own = IdentityFile(name="student1", password="correct-horse", connect=("tls/10.0.0.5:7447",), **fields)  # type: ignore[arg-type]
    write_secret(path, identity_text(own))
    return path


def test_option_takes_a_file_that_names_its_router(tmp_path: Path) -> None:
    parser = argparse.ArgumentParser()
    add_identity_option(parser)
    path = written(tmp_path)
    assert router_of(parser.parse_args(["--identity", str(path)]).identity) == ("tls/10.0.0.5:7447",)
    assert router_of(parser.parse_args([]).identity) == ()


def test_expired_identity_is_refused_with_the_option_and_what_to_do(tmp_path: Path) -> None:
    path = written(tmp_path, until="2020-01-31")
    with pytest.raises(WireError) as caught:
        check_option(path)
    assert caught.value.text == (
        f"--identity: {path}: student1 expired after 2020-01-31; ask for another file, made with iw-lab renew student1"
    )


def test_what_others_can_read_is_warned_of(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = written(tmp_path, until="2090-01-31")
    check_option(path)
    assert capsys.readouterr().err == ""
    path.chmod(0o644)
    check_option(path)
    assert capsys.readouterr().err == f"warning: {path}: others can read this secret; run chmod 600 {path}\n"
