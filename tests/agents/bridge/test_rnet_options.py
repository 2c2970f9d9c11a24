from __future__ import annotations

import argparse

import pytest

from intellwheels_agents.bridge.rnet_options import add_bus_options, bus_options, check_bus
from intellwheels_schemas.errors import WireError


def test_numbers_are_numbers_and_all_else_is_text() -> None:
    assert bus_options(["port=43113", "app_name=iw", "x="]) == {"port": 43113, "app_name": "iw", "x": ""}


@pytest.mark.parametrize(
    "given", [["port"], ["=1"], ["a b=1"], ["port=1", "port=2"], ["bitrate=500000"], ["receive_own_messages=1"]]
)
def test_what_the_driver_sets_itself_cannot_be_changed(given: list[str]) -> None:
    with pytest.raises(WireError, match="--can-option: expected KEY=VALUE, each key once and none of"):
        bus_options(given)


def test_an_adapter_that_python_can_does_not_know_and_a_bus_without_a_name_are_refused() -> None:
    check_bus("socketcan", "can0")
    with pytest.raises(WireError, match=r"--interface: expected one of .*socketcan.*, got 'nothing'"):
        check_bus("nothing", "can0")
    with pytest.raises(WireError, match="--channel: expected a CAN bus such as can0, got ''"):
        check_bus("virtual", "")


def test_socketcan_is_the_default() -> None:
    parser = argparse.ArgumentParser()
    add_bus_options(parser)
    assert parser.parse_args(["--channel", "can0"]).interface == "socketcan"
