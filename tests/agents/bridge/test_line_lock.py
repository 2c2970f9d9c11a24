from __future__ import annotations

import socket

import pytest

from intellwheels_agents.bridge.line_lock import LineLock, names_of
from intellwheels_schemas.names import new_hex


def test_one_at_a_time_has_a_line() -> None:
    name = f"test/{new_hex()}"
    first, second, other = LineLock(name), LineLock(name), LineLock(f"{name}2")
    assert first.take()
    assert not second.take()
    assert other.take()
    first.release()
    first.release()
    assert second.take()
    second.release()
    other.release()


def test_long_names_differ_by_their_ends() -> None:
    name = f"test/{new_hex()}/" + "x" * 500
    lock, other = LineLock(f"{name}1"), LineLock(f"{name}2")
    assert lock.take()
    assert other.take()
    lock.release()
    other.release()


def test_a_host_name_and_its_address_share_a_name(monkeypatch: pytest.MonkeyPatch) -> None:
    v4 = (socket.AF_INET, socket.SOCK_STREAM, 6, "", ("192.168.1.50", 50051))
    v6 = (socket.AF_INET6, socket.SOCK_STREAM, 6, "", ("fe80::1", 50051, 0, 0))
    monkeypatch.setattr(socket, "getaddrinfo", lambda *_, **__: [v4, v6])
    assert names_of("Luci.local:50051") == ["192.168.1.50:50051", "[fe80::1]:50051", "luci.local:50051"]


@pytest.mark.parametrize("error", [socket.gaierror("no such name"), UnicodeError("label too long")])
def test_a_host_that_nobody_knows_has_its_own_name(error: Exception, monkeypatch: pytest.MonkeyPatch) -> None:
    def unknown(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr(socket, "getaddrinfo", unknown)
    assert names_of("nowhere:1") == ["nowhere:1"]
