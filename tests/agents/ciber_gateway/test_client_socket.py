"""Datagrams of one client, of strangers, and reports."""

from __future__ import annotations

import socket

import pytest

from intellwheels_agents.ciber_gateway.client_socket import ClientSocket, Reports

pytestmark = pytest.mark.process


def test_only_datagrams_of_the_client_are_received_and_strangers_are_reported() -> None:
    lines: list[str] = []
    with (
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger,
    ):
        for one in (client, stranger):
            one.bind(("127.0.0.1", 0))
            one.settimeout(25.0)
        server = ClientSocket("127.0.0.1", client.getsockname(), Reports(lines.append))
        server.send(b"hello")
        data, address = client.recvfrom(100)
        assert data == b"hello"
        assert server.receive() is None
        for _ in range(12):
            stranger.sendto(b"x" * 60_000, address)
        client.sendto(b"", address)
        client.sendto(b"mine", address)
        assert server.wait(25.0)
        assert [server.receive(), server.receive(), server.receive()] == [b"", b"mine", None]
        server.close()
    # The kernel may have kept fewer of the large ones.
    assert lines[0].startswith("dropped what='datagram of a stranger' count=1 from=127.0.0.1:")
    assert "got 60000 bytes" in lines[0]
    assert len(lines) <= 2


def test_a_closed_client_is_no_error() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
        client.bind(("127.0.0.1", 0))
        address = client.getsockname()
    server = ClientSocket("127.0.0.1", address, Reports(lambda _line: None))
    for _ in range(3):
        server.send(b"anybody?")
        assert server.receive() is None
    server.close()


def test_an_address_of_another_machine_is_an_error() -> None:
    with pytest.raises(OSError, match=r".+"):
        ClientSocket("192.0.2.1", ("127.0.0.1", 1), Reports(lambda _line: None))


def test_every_tenth_power_is_reported() -> None:
    lines: list[str] = []
    reports = Reports(lines.append)
    for _ in range(1000):
        reports.tell("actions", "127.0.0.1:1", "bad")
    assert [line.split()[2] for line in lines] == ["count=1", "count=10", "count=100", "count=1000"]
    assert reports.total == 1000
