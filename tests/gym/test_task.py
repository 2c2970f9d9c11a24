"""Every shipped scene is a task, and what does not fit a scene is named."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from intellwheels_gym.task import Task, load_task
from intellwheels_maps import names
from intellwheels_schemas.errors import WireError
from tests.every_case import every_case

WITHOUT_GOAL: dict[str, dict[str, Any]] = {
    "lab": {"learners": ["real1"], "goals": {"real1": "goal1"}},
    "umbmark": {"goal": (2.0, 0.0)},
}
"""What the scenes without a Reach for a chair need."""


def made(name: str) -> Task:
    return load_task(name, **WITHOUT_GOAL.get(name, {}))


@every_case("name", names("scenes"))
def test_every_shipped_scene_is_a_task(name: str) -> None:
    task = made(name)
    assert task.goals
    assert task.seconds > 0.0


def test_learners_are_the_wheelchairs_with_a_goal_in_the_order_of_the_cast() -> None:
    task = load_task("figure6")
    assert list(task.goals) == ["chair1", "chair2", "chair3"]
    assert task.goals["chair2"].on(task.ground) != task.goals["chair3"].on(task.ground)
    assert task.seconds == 120.0
    assert list(load_task("figure6", single=True).goals) == ["chair1"]
    assert list(load_task("figure6", learners=["chair3", "chair1"]).goals) == ["chair1", "chair3"]


def test_goal_may_be_a_place_or_a_point() -> None:
    place = load_task("door", goal="back-goal").goals["chair"]
    assert (place.place, place.within) == ("back-goal", 0.3)
    point = load_task("door", goal=(3, 0.5)).goals["chair"]
    assert point.on(load_task("door").ground) == (3.0, 0.5)


def test_row_of_an_experiment_is_chosen_by_name() -> None:
    task = load_task("door", row="v07+towards+r30+t5")
    options = {one.name: {option.name: option.value for option in one.option} for one in task.row.scene.cast}
    assert options["door"]["swing"] == "left"


@every_case(
    ("arguments", "text"),
    [
        ({"of": "dor"}, "got 'dor'; did you mean 'door'"),
        ({"of": "nowhere.xml"}, "nowhere.xml"),
        ({"of": "umbmark"}, "no Reach for 'chair': expected a place"),
        ({"of": "door", "learners": ["chiar"]}, "expected agents of the scene .* got 'chiar'"),
        ({"of": "door", "learners": "chair"}, "learners: expected names of agents"),
        ({"of": "door", "learners": []}, "learners: expected names of agents"),
        ({"of": "door", "learners": ["chair", "chair"]}, "each name once"),
        ({"of": "door", "goal": "gaol"}, "goals: expected a place of map 'door' .* got 'gaol'"),
        ({"of": "door", "goal": (1.0,)}, r"goals: expected a place or \(x, y\) in m for 'chair'"),
        ({"of": "door", "goal": (float("nan"), 0.0)}, r"goals: expected a place or \(x, y\)"),
        ({"of": "door", "goals": {"door": "goal"}}, r"expected the name of a learner \(chair\), got 'door'"),
        ({"of": "figure6", "goal": "goal1"}, "goal: expected one learner"),
        ({"of": "door", "row": "v07"}, "row: expected one of scene 'door'"),
        ({"of": "door", "seconds": 0.0}, "seconds: expected a number above 0, got 0.0"),
        ({"of": "door", "seconds": float("nan")}, "seconds: expected a number above 0, got nan"),
        ({"of": "door", "seconds": "60"}, "seconds: expected a number above 0, got '60'"),
        ({"of": "follow", "row": "walls"}, "row: expected"),
    ],
)
def test_what_does_not_fit_is_named(arguments: dict[str, Any], text: str) -> None:
    with pytest.raises((ValueError, WireError), match=text):
        load_task(**arguments)


def test_program_that_does_not_learn_needs_a_network(tmp_path: Path) -> None:
    file = tmp_path / "scene.xml"
    file.write_text(
        '<Scene Format="iw.v1" Name="two" Map="room"><Cast Name="chair1" Command="mine"/>'
        '<Cast Name="chair2" Command="mine"/></Scene>'
    )
    with pytest.raises(ValueError, match="agent 'chair2': expected a mind, got a command"):
        load_task(file, learners=["chair1"], goal="goal1")
