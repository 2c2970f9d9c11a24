from __future__ import annotations

import argparse

import pytest

from intellwheels_agents.bridge.luci_options import add_luci_options, listen_address, luci_address
from intellwheels_schemas.errors import WireError
from tests.every_case import every_case


@pytest.mark.parametrize(
    ("text", "address"),
    [
        ("192.168.1.50", "192.168.1.50:50051"),
        ("chair.local:4000", "chair.local:4000"),
        ("[fe80::1]:50051", "[fe80::1]:50051"),
    ],
)
def test_an_address_has_a_port(text: str, address: str) -> None:
    assert luci_address(text) == address


@every_case("text", ["", ":1", "host:0", "host:65536", "host:x", "http://host", "unix:/tmp/x", "a b", "::1"])
def test_anything_else_is_refused(text: str) -> None:
    with pytest.raises(WireError, match="--address: expected HOST or HOST:PORT, got"):
        luci_address(text)


def test_a_stand_in_listens_at_a_port() -> None:
    assert listen_address("127.0.0.1:0") == "127.0.0.1:0"
    for text in ("127.0.0.1", "h:70000", ""):
        with pytest.raises(argparse.ArgumentTypeError, match="expected HOST:PORT, got"):
            listen_address(text)


def test_the_centre_is_that_of_the_maker_s_client_unless_said_otherwise() -> None:
    parser = argparse.ArgumentParser()
    add_luci_options(parser)
    given = parser.parse_args([])
    assert (given.joystick_centre, given.reversed_encoder) == (100, [])
    assert parser.parse_args(["--joystick-centre", "0"]).joystick_centre == 0
