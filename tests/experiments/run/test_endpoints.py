"""A free port can be listened at."""

from __future__ import annotations

import socket

from intellwheels_experiments.run.endpoints import free_endpoint, free_port


def test_free_port_can_be_bound() -> None:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", free_port()))


def test_endpoint_is_a_tcp_port_of_this_machine() -> None:
    protocol, address = free_endpoint().split("/")
    host, port = address.split(":")
    assert (protocol, host) == ("tcp", "127.0.0.1")
    assert 0 < int(port) <= 65535
