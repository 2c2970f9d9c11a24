from __future__ import annotations

import contextlib
import datetime
import socket
import ssl
import threading
from pathlib import Path

import pytest
from cryptography import x509

from intellwheels_schemas.errors import WireError
from intellwheels_schemas.identity_file import IdentityFile, identity_text, write_secret
from intellwheels_schemas.router_probe import why_not
from intellwheels_server.service.lab_certificates import RENEW_DAYS, Authority, authority_of, ensure_router, issue_for
from intellwheels_server.service.lab_files import LabFiles, router_until

TODAY = datetime.datetime.now(datetime.UTC).date()


@pytest.fixture
def files(tmp_path: Path) -> LabFiles:
    return LabFiles(tmp_path / "room3.xml")


@pytest.fixture
def authority(files: LabFiles) -> Authority:
    return authority_of(files, "room3", TODAY)


def test_authority_is_made_once_and_its_key_is_a_secret(files: LabFiles, authority: Authority) -> None:
    assert authority_of(files, "room3", TODAY).pem == authority.pem
    assert files.authority_key.stat().st_mode & 0o777 == 0o600
    files.authority_key.write_text("secret")
    with pytest.raises(WireError) as caught:
        authority_of(files, "room3", TODAY)
    assert caught.value.text.endswith("room3.ca.key: expected the authority that iw-lab keys made, got something else")


def test_router_has_a_new_certificate_for_a_new_host_and_before_its_end(files: LabFiles, authority: Authority) -> None:
    assert router_until(files) is None
    assert ensure_router(files, authority, ("lab.org",), TODAY)
    assert not ensure_router(files, authority, (), TODAY), "older hosts stay"
    assert ensure_router(files, authority, ("10.0.0.5",), TODAY)
    assert not ensure_router(files, authority, ("lab.org", "10.0.0.5"), TODAY)
    until = router_until(files)
    assert until is not None
    late = until - datetime.timedelta(days=RENEW_DAYS)
    assert not ensure_router(files, authority, (), late - datetime.timedelta(days=1))
    assert ensure_router(files, authority, (), late)
    assert files.router_key.stat().st_mode & 0o777 == 0o600


def test_certificate_of_an_identity_names_it_and_counts_to_the_end_of_its_last_day(authority: Authority) -> None:
    issued = issue_for(authority, "student1", TODAY, TODAY)
    found = x509.load_pem_x509_certificate(issued.certificate.encode())
    found.verify_directly_issued_by(authority.certificate)
    assert found.subject.rfc4514_string() == "CN=student1"
    assert found.not_valid_after_utc.date() == TODAY + datetime.timedelta(days=1)


@pytest.mark.process
def test_router_is_known_by_its_certificate_and_a_wrong_one_is_put_in_words(files: LabFiles, tmp_path: Path) -> None:
    authority = authority_of(files, "room3", TODAY)
    ensure_router(files, authority, (), TODAY)
    other = authority_of(LabFiles(tmp_path / "other.xml"), "other", TODAY)
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(files.router, files.router_key)

    def asked(endpoint: str, by: Authority) -> str:
        """Return the words of a peer whose file has this authority."""
        own = IdentityFile(name="student1", password="correct-horse", lab="room3", authority=by.pem)
        write_secret(tmp_path / "student1.iwid", identity_text(own))
        server = threading.Thread(target=accept)
        server.start()
        try:
            return why_not(f"{endpoint}:{port}", tmp_path / "student1.iwid")
        finally:
            server.join()

    def accept() -> None:
        # First it looks whether anybody listens.
        listener.accept()[0].close()
        connection, _ = listener.accept()
        with contextlib.suppress(OSError):
            context.wrap_socket(connection, server_side=True).close()

    with socket.create_server(("127.0.0.1", 0)) as listener:
        listener.settimeout(30.0)
        port = listener.getsockname()[1]
        assert "refuses student1: " in asked("tls/127.0.0.1", authority)
        assert "is the router of another lab than room3" in asked("tls/127.0.0.1", other)
        assert asked("tcp/127.0.0.1", authority) == f"tcp/127.0.0.1:{port} encrypts: connect to tls/127.0.0.1:{port}"
    assert why_not(f"tcp/127.0.0.1:{port}", tmp_path / "student1.iwid") == ""
