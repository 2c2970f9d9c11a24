"""Options are converted and checked, or refused with a reason."""

from __future__ import annotations

import pytest

from intellwheels_agents.options import OptionError, Options


def test_absent_option_has_its_default() -> None:
    options = Options()
    assert options.number("speed", 0.5) == 0.5
    assert options.flag("truth") is False
    assert options.points("points") == ()
    assert options.words("via") == ()
    assert options.text("say") == ""


def test_points_come_in_pairs() -> None:
    assert Options({"points": "2 3, 4 5"}).points("points") == ((2.0, 3.0), (4.0, 5.0))


@pytest.mark.parametrize("text", ["2", "2 3 4", "2 x", "nan 1", "inf 1"])
def test_malformed_points_are_refused(text: str) -> None:
    with pytest.raises(OptionError, match="option points: expected numbers in pairs"):
        Options({"points": text}).points("points")


@pytest.mark.parametrize("text", ["fast", "nan", "2.5", ""])
def test_number_out_of_range_is_refused_with_range_and_value(text: str) -> None:
    with pytest.raises(OptionError, match=r"option speed: expected a number in \[0, 2\], got"):
        Options({"speed": text}).number("speed", 0.5, 0.0, 2.0)


def test_wrong_choice_is_refused_with_the_choices() -> None:
    with pytest.raises(OptionError, match="option swing: expected one of left, right, got 'up'"):
        Options({"swing": "up"}).choice("swing", ("left", "right"), "left")


def test_unread_option_is_refused_with_the_known_ones() -> None:
    options = Options({"sped": "1"})
    options.number("speed", 0.5)
    with pytest.raises(OptionError, match=r"option sped: expected an option of this mind \(speed\), got 'sped'"):
        options.check_all_read()
