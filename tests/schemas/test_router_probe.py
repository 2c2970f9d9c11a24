from __future__ import annotations

import socket
from pathlib import Path

import pytest

from intellwheels_schemas.identity_file import IdentityFile, identity_text, write_secret
from intellwheels_schemas.router_probe import why_not

pytestmark = pytest.mark.process


def test_nothing_is_said_where_nobody_listens_or_the_address_has_no_port(tmp_path: Path) -> None:
    for endpoint in ("tcp/127.0.0.1:1", "unixsock-stream/x", "", "tcp/nowhere.invalid:7447"):
        assert why_not(endpoint, None) == ""


def test_tls_without_the_certificate_of_the_lab_is_told(tmp_path: Path) -> None:
    file = tmp_path / "a.iwid"
    write_secret(file, identity_text(IdentityFile(name="a", password="correct-horse")))
    with socket.create_server(("127.0.0.1", 0)) as listener:
        endpoint = f"tls/127.0.0.1:{listener.getsockname()[1]}"
        asking = "ask for another file, made with iw-lab invite a"
        assert why_not(endpoint, file) == f"{endpoint} shows a certificate, which {file} cannot check: {asking}"
        words = f"{endpoint} answers, but not to us: a router of a lab expects --identity FILE, from iw-lab invite"
        assert why_not(endpoint, None) == words
