"""Paths and turns are summed over every tick, also over those of which no state is published."""

from __future__ import annotations

import itertools
import math

import pytest

from intellwheels_schemas.messages import Delete, Entity, Position, Reset, Teleport
from tests.server.stage import Stage


def driving(left: float, right: float) -> tuple[Stage, list[tuple[float, float, float]]]:
    """Let a chair drive for 40 ticks; return its stage and its poses at each tick."""
    stage = Stage(pace="realtime")
    stage.join("chair1")
    poses = [pose(stage)]
    for _ in range(40):
        stage.act("chair1", left, right)
        stage.work(0.05)
        poses.append(pose(stage))
    return stage, poses


def pose(stage: Stage) -> tuple[float, float, float]:
    (shown,) = stage.ask("state", "")[0][0].entity  # type: ignore[attr-defined]
    return shown.x, shown.y, shown.heading


def shown(stage: Stage) -> Entity:
    found: Entity = stage.ask("state", "")[0][0].entity[0]  # type: ignore[attr-defined]
    return found


def test_path_is_the_sum_over_all_ticks_and_turn_the_largest_angle() -> None:
    stage, poses = driving(0.5, 0.2)
    entity = shown(stage)
    steps = sum(math.dist(old[:2], new[:2]) for old, new in itertools.pairwise(poses))
    # The poses on the wire are rounded to 1e-6 m.
    assert entity.travelled == pytest.approx(steps, abs=1e-4)
    assert entity.travelled is not None
    assert entity.travelled > 0.2
    turns = [abs(math.remainder(heading - poses[0][2], math.tau)) for _, _, heading in poses]
    assert entity.turned == pytest.approx(max(turns), abs=1e-5)


def test_a_move_by_an_operator_is_not_travelled() -> None:
    stage, _ = driving(0.5, 0.5)
    before = shown(stage).travelled
    assert stage.result("teleport", Teleport(agent="chair1", position=Position(x=3.0, y=2.0, heading=0.0))).code == "ok"
    assert shown(stage).x == 3.0
    assert shown(stage).travelled == before


def test_a_body_that_comes_does_not_change_the_sums_of_another() -> None:
    stage, _ = driving(0.5, 0.5)
    before = shown(stage).travelled
    stage.join("chair0", instance="b" * 16)
    stage.act("chair1", 0.0, 0.0)
    stage.act("chair0", 0.0, 0.0)
    stage.work(0.2)
    first, second = stage.ask("state", "")[0][0].entity  # type: ignore[attr-defined]
    assert (first.name, second.name) == ("chair0", "chair1")
    assert first.travelled < 0.01
    assert second.travelled >= (before or math.inf)


def test_a_new_run_and_a_new_body_begin_at_zero() -> None:
    stage, _ = driving(0.5, 0.5)
    assert stage.result("reset", Reset()).code == "ok"
    assert (shown(stage).travelled, shown(stage).turned) == (0.0, 0.0)
    stage, _ = driving(0.5, 0.5)
    assert stage.result("delete", Delete(agent="chair1")).code == "ok"
    stage.join("chair1", instance="b" * 16)
    assert shown(stage).travelled == 0.0
