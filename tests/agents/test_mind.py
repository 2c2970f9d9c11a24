"""The route that the options of a mind describe."""

from __future__ import annotations

import dataclasses

import msgspec
import pytest

from intellwheels_agents.mind import Context
from intellwheels_agents.options import OptionError, Options
from intellwheels_agents.pure_pursuit import path_of
from intellwheels_maps import floor, robot
from intellwheels_schemas.messages import Parameters, Position, SiteOffset


def context(**options: str) -> Context:
    return Context(
        agent="one",
        robot=robot("person"),
        position=Position(x=1.0, y=1.0, heading=0.0),
        parameters=Parameters(
            world="w", period=0.05, pace="lockstep", say_limit=100, say_range=8.0, command_timeout=0.5, grace=3.0
        ),
        options=Options(options),
        fetch_map=lambda: floor("crossing"),
    )


def test_route_is_points_then_via_then_to() -> None:
    found = context(to="north-side", via="south-side south-corner", points="1 2 3 4").route()
    assert found == [(1.0, 2.0), (3.0, 4.0), (-0.6, -5.2), (2.4, -5.2), (0.0, 4.4)]


def test_place_missing_from_the_map_is_refused() -> None:
    with pytest.raises(OptionError, match="option to: expected a place of the map"):
        context(to="nowhere").route()


def test_path_begins_at_the_body() -> None:
    path = path_of(context(points="1 4"))
    assert path is not None
    assert path.length == 3.0


def test_path_to_the_start_is_none_and_no_points_are_refused() -> None:
    assert path_of(context(points="1 1")) is None
    with pytest.raises(OptionError, match="options: expected at least one of points, via and to, got none"):
        path_of(context())


def test_points_are_in_the_coordinates_of_the_site() -> None:
    moved = msgspec.structs.replace(floor("crossing"), offset=SiteOffset(x=489000.0, y=4412000.0))
    there = dataclasses.replace(context(points="489001 4412002 489003 4412004"), fetch_map=lambda: moved)
    assert there.route() == [(1.0, 2.0), (3.0, 4.0)]
