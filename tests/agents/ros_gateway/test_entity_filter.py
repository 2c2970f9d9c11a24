"""Filters for bodies."""

from __future__ import annotations

from typing import Any

import msgspec
import pytest

from intellwheels_agents.ros_gateway.entity_filter import HUMAN, ROBOT, category_of, matching, tags_match, tags_of
from intellwheels_agents.ros_gateway.ros_messages import vector
from intellwheels_agents.ros_gateway.ros_types import blank, made_of
from intellwheels_maps import robot
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Entity
from tests.every_case import every_case

BODIES = [
    (Entity(name="chair1", x=0.0, y=0.0, heading=0.0), robot("intellwheels")),
    (Entity(name="chair2", x=5.0, y=0.0, heading=0.0), robot("mid-wheel")),
    (Entity(name="nurse", x=0.0, y=3.0, heading=0.0), robot("person")),
]


def filters(**values: Any) -> Any:
    found = blank("simulation_interfaces/msg/EntityFilters")
    for name, value in values.items():
        setattr(found, name, value)
    return found


def passed(**values: Any) -> list[str]:
    return [entity.name for entity in matching(filters(**values), BODIES)]


def sphere(x: float, y: float, radius: float, kind: int = 3) -> Any:
    return made_of("simulation_interfaces/msg/Bounds")(type=kind, points=[vector(x, y), vector(radius)])


def tags(*words: str, mode: int = 0) -> Any:
    return made_of("simulation_interfaces/msg/TagsFilter")(tags=list(words), filter_mode=mode)


def test_no_filter_passes_all() -> None:
    assert passed() == ["chair1", "chair2", "nurse"]


@pytest.mark.parametrize(("pattern", "wanted"), [
    ("chair", ["chair1", "chair2"]), ("^.*e$", ["nurse"]), ("(1|2)$", ["chair1", "chair2"]), ("x", []),
])  # fmt: skip
def test_names(pattern: str, wanted: list[str]) -> None:
    assert passed(filter=pattern) == wanted


def test_categories_and_tags() -> None:
    category = made_of("simulation_interfaces/msg/EntityCategory")
    assert passed(categories=[category(category=HUMAN)]) == ["nurse"]
    assert passed(categories=[category(category=HUMAN), category(category=ROBOT)]) == ["chair1", "chair2", "nurse"]
    assert passed(tags=tags("person", "door")) == ["nurse"]
    assert passed(tags=tags("person", "door", mode=1)) == []
    assert category_of("anything") == 0


def test_tags_of_a_body_and_of_a_place() -> None:
    assert tags_of(msgspec.structs.replace(robot("person"), type="real")) == ["person", "real"]
    assert tags_match(tags(), ())
    assert tags_match(tags("goal"), ("goal", "x"))
    assert not tags_match(tags("goal"), ())
    with pytest.raises(WireError, match="tags: expected at most 64, got 65"):
        tags_match(tags(*["x"] * 65), ())


def test_sphere_touches_the_outline() -> None:
    # The front of the chair is 0.696 m ahead.
    assert passed(bounds=sphere(1.0, 0.0, 0.31)) == ["chair1"]
    assert passed(bounds=sphere(1.0, 0.0, 0.30)) == []


@every_case("pattern", ["(a+)+$", "(a|aa)*b", "(", r"(a)\1", "a" * 300, ".*.*.*.*x", "(?=a)", "a{99999999999}"])
def test_pattern_that_could_take_forever_is_refused(pattern: str) -> None:
    with pytest.raises(WireError, match=r"filters\.filter: expected"):
        passed(filter=pattern)


def test_slowest_pattern_that_is_allowed_ends() -> None:
    name = "a" * 32
    bodies = [(Entity(name=name, x=0.0, y=0.0, heading=0.0), robot("crate"))]
    # It takes milliseconds. Without the limit it could take years.
    assert matching(filters(filter="a*a*a*b"), bodies) == []


@pytest.mark.parametrize("bounds", [sphere(0.0, 0.0, 1.0, kind=1), sphere(float("nan"), 0.0, 1.0)])
def test_other_bounds_are_refused(bounds: Any) -> None:
    with pytest.raises(WireError, match=r"filters\.bounds: expected"):
        passed(bounds=bounds)
