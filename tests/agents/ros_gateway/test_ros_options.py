"""The options of `iw-ros`."""

from __future__ import annotations

import pytest

from intellwheels_agents.options import OptionError
from intellwheels_agents.ros_gateway.ros_options import check_together, domain_of, parser
from intellwheels_schemas.errors import WireError


@pytest.mark.parametrize("words", [
    [], ["--name", "c"], ["--name", "c", "--robot", "crate", "--option", "TopSpeed=1"],
    ["--name", "c", "--role", "mind"], ["--name", "c", "--role", "watch", "--no-world"], ["--resolution", "0.1"],
    ["--name", "c", "--await", "2"],
])  # fmt: skip
def test_options_that_go_together(words: list[str]) -> None:
    check_together(parser().parse_args(words))


@pytest.mark.parametrize(("words", "text"), [
    (["--robot", "crate"], "--robot: expected a chair with role both, got no --name"),
    (["--name", "c", "--role", "mind", "--place", "p"], "--place: expected a chair with role both, got --role mind"),
    (["--role", "mind"], "--role: expected with --name, got none"),
    (["--no-world"], "--no-world: expected with --name, got none"),
    (["--name", "c", "--role", "watch", "--await", "1"], "--await: expected a role with a mind, got --role watch"),
    (["--name", "c", "--no-world", "--resolution", "1"], "--resolution: expected without --no-world, got both"),
])  # fmt: skip
def test_options_that_do_not(words: list[str], text: str) -> None:
    with pytest.raises(OptionError) as caught:
        check_together(parser().parse_args(words))
    assert str(caught.value) == text


def test_domain_is_that_of_the_option_or_of_ros() -> None:
    assert domain_of(parser().parse_args(["--domain", "7"]), {"ROS_DOMAIN_ID": "3"}) == 7
    assert domain_of(parser().parse_args([]), {"ROS_DOMAIN_ID": "3"}) == 3
    assert domain_of(parser().parse_args([]), {}) == 0
    with pytest.raises(WireError, match=r"ROS_DOMAIN_ID: expected a whole number in \[0, 232\], got '300'"):
        domain_of(parser().parse_args([]), {"ROS_DOMAIN_ID": "300"})
