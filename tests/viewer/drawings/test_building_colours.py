from __future__ import annotations

import itertools

import pytest

from intellwheels_viewer.drawings.building_colours import DAY, NIGHT, BuildingColours, colours_of, dimmed
from intellwheels_viewer.palette import RGB, linear
from intellwheels_viewer.stage import NIGHT as NIGHT_SKY
from intellwheels_viewer.stage import SKY


def contrast(one: RGB, other: RGB) -> float:
    """Return the contrast of WCAG 2, from 1 to 21."""
    low, high = sorted(float(linear(rgb) @ (0.2126, 0.7152, 0.0722)) for rgb in (one, other))
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize(("colours", "sky"), [(DAY, SKY), (NIGHT, NIGHT_SKY)])
def test_floors_caps_and_the_ground_outside_are_told_apart(colours: BuildingColours, sky: RGB) -> None:
    for floor in (colours.floors["tiles"], colours.floors["wood"]):
        assert contrast(floor, colours.cap) > 1.8
        assert contrast(floor, colours.outside) > 1.2
    assert contrast(colours.outside, sky) > 1.1
    assert contrast(colours.floors["asphalt"], colours.road_line) > 3.0
    assert contrast(colours.plate, colours.sign_letters) > 7.0


@pytest.mark.parametrize("material", DAY.floors)
def test_names_can_be_read_on_every_floor(material: str) -> None:
    for colours in (DAY, NIGHT):
        assert contrast(colours.floors[material], colours.letters) > 1.5  # type: ignore[index]


def test_the_building_is_dark_by_night() -> None:
    by_day, by_night = ([*each.floors.values(), each.wall, each.ceiling, each.outside] for each in (DAY, NIGHT))
    assert all(sum(dark) < sum(light) for light, dark in zip(by_day, by_night, strict=True))
    assert max(itertools.chain(*by_night)) < 140


def test_a_theme_has_its_colours() -> None:
    assert colours_of(dark=False) is DAY
    assert colours_of(dark=True) is NIGHT
    assert dimmed((200, 100, 50), 0.5) == (100, 50, 25)
