from __future__ import annotations

import socket

import pytest

from intellwheels_schemas.endpoint_form import (
    cannot_listen,
    check_endpoint,
    check_free,
    config_reason,
    host_of,
    is_free,
    is_loopback,
    zenoh_reason,
)
from intellwheels_schemas.errors import WireError
from tests.every_case import every_case


@pytest.mark.parametrize(
    "text",
    [
        "tcp/127.0.0.1:7447", "tcp/[::1]:7447", "tcp/host.docker.internal:1?rel=1", "tls/lab-pc:7447#a=b", "udp/h:9",
        "serial//dev/ttyUSB0#baudrate=9600", "unixsock-stream//run/iw.sock",
    ],
)  # fmt: skip
def test_endpoints_are_accepted(text: str) -> None:
    check_endpoint(text, "--connect")


@every_case(
    ("text", "hint"),
    [
        ("127.0.0.1:7447", "; did you mean tcp/127.0.0.1:7447?"),
        ("10.0.0.5", "; did you mean tcp/10.0.0.5:7447?"),
        ("localhost", "; did you mean tcp/localhost:7447?"),
        ("[::1]:7447", "; did you mean tcp/[::1]:7447?"),
        ("http://10.0.0.5:8000/", "; did you mean tcp/10.0.0.5:8000?"),
        ("tcp://lab:7447", "; did you mean tcp/lab:7447?"),
        ("tls/lab", "; did you mean tls/lab:7447?"),
        ("mqtt/lab:1883", "; did you mean tcp/lab:1883?"),
        ("tcp/lab:70000", "; a port is 1 to 65535"),
        ("tcp/lab:0", "; a port is 1 to 65535"),
        ("tcp/a:1,tcp/b:2", ""),
        ("tcp/a b:1", ""),
        ("tcp/", ""),
        ("lab", ""),
        ("", ""),
    ],
)
def test_the_endpoint_that_was_meant_is_shown(text: str, hint: str) -> None:
    with pytest.raises(WireError) as caught:
        check_endpoint(text, "--connect")
    assert caught.value.text == f"--connect: expected an endpoint such as tcp/127.0.0.1:7447, got {text!r}{hint}"


def test_what_was_meant_is_an_endpoint() -> None:
    for text in ("http://10.0.0.5", "localhost", "lab:99999", "ws:/lab"):
        with pytest.raises(WireError) as caught:
            check_endpoint(text, "--connect")
        check_endpoint(caught.value.text.rpartition("did you mean ")[2].rstrip("?"), "--connect")


def test_a_port_in_use_is_told_before_anything_starts() -> None:
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        assert not is_free("127.0.0.1", port)
        with pytest.raises(
            ConnectionError, match=f"^cannot listen at tcp/127.0.0.1:{port}: the port is in use.*--listen"
        ):
            check_free([f"tcp/127.0.0.1:{port}"])
    check_free([f"tcp/127.0.0.1:{port}", "tcp/127.0.0.1:0", "unixsock-stream//run/x", f"udp/127.0.0.1:{port}"])
    assert is_free("127.0.0.1", port)


def test_an_address_of_another_machine_is_told() -> None:
    with pytest.raises(ConnectionError, match=r"^cannot listen at tcp/192\.0\.2\.1:7447: cannot assign"):
        check_free(["tcp/192.0.2.1:7447"])
    assert cannot_listen("tcp/a:1", "no route") == "cannot listen at tcp/a:1: no route"


def test_zenohs_own_places_are_left_out() -> None:
    assert zenoh_reason("Is a directory (os error 21) at /src/lib.rs:1472.") == "Is a directory (os error 21)"
    pest = " --> 3:16\n  |\n3 | {mode: \n  |   ^---\n  |\n  = expected array or string at /src/lib.rs:1486."
    assert config_reason(pest) == "in line 3: expected array or string"
    serde = (
        'JSON error: Message { msg: "unknown `x`", location: Some(Location { line: 1, column: 8 }) } at /src/lib.rs:9.'
    )
    assert config_reason(serde) == "in line 1: unknown `x`"
    assert config_reason("odd at /src/lib.rs:9.") == "odd"


@every_case(
    ("endpoint", "loopback"),
    [
        ("tcp/127.0.0.1:7447", True), ("tcp/127.1.2.3:7447", True), ("tcp/[::1]:7447", True),
        ("tls/LocalHost:7447", True), ("unixsock-stream//run/iw.sock", True),
        ("serial//dev/ttyUSB0#baudrate=9600", True),
        ("tcp/0.0.0.0:7447", False),
        ("tcp/[::]:7447", False), ("tcp/10.0.0.5:7447", False), ("tcp/lab-pc:7447", False), ("vsock/1:2", False),
    ],
)  # fmt: skip
def test_loopback_is_told_from_what_other_machines_reach(endpoint: str, loopback: bool) -> None:
    assert is_loopback(endpoint) is loopback


def test_host_of_an_endpoint() -> None:
    assert [host_of(text) for text in ("tls/lab.org:7447", "tcp/[::1]:7447#x=1", "unixsock-stream/x")] == [
        "lab.org", "::1", "",
    ]  # fmt: skip
