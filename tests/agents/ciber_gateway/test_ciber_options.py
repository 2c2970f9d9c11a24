"""The options of `iw-ciber`."""

from __future__ import annotations

import pytest

from intellwheels_agents.ciber_gateway.ciber_options import check_fields, check_together, parser
from intellwheels_agents.options import OptionError


@pytest.mark.parametrize("words", [
    [], ["--gps", "--requestable", "gps", "--requestable", "beacon"], ["--sim-time", "5", "--key-time", "5"],
    ["--host", "localhost"],
])  # fmt: skip
def test_options_that_go_together(words: list[str]) -> None:
    check_together(parser().parse_args(words))


@pytest.mark.parametrize(("words", "text"), [
    (["--sim-time", "5", "--key-time", "6"], "--key-time: expected at most --sim-time 5, got 6"),
    (["--no-beacon", "--requestable", "beacon"], "--requestable: expected no beacon with --no-beacon, got both"),
    (["--requestable", "gps"], "--requestable: expected gps with --gps only, got no --gps"),
    (["--host", "::1"], "--host: expected an IPv4 address of this machine, .*, got '::1'"),
])  # fmt: skip
def test_options_that_do_not(words: list[str], text: str) -> None:
    with pytest.raises(OptionError, match=text):
        check_together(parser().parse_args(words))


def test_fields_of_robots_are_checked_before_there_is_a_world() -> None:
    given = parser().parse_args([])
    check_fields(given, {"MotorNoise": "0", "Beacon.ConeDeg": "120", "Compass.Latency": "4"})
    for changes in ({"GPS.Noise": "0"}, {"MotorNoise": "x"}, {"Nosuch": "1"}):
        with pytest.raises(OptionError, match="--option: option"):
            check_fields(given, changes)
