"""How a learner is judged."""

from __future__ import annotations

import pytest

from intellwheels_gym.learner import Interface, Learner
from intellwheels_gym.scene_world import SceneWorld
from intellwheels_gym.task import load_task


@pytest.mark.parametrize("ticks", [0, -1, 1.0, True, "2"])
def test_ticks_of_a_step_are_a_whole_number(ticks: int) -> None:
    with pytest.raises(ValueError, match="ticks: expected a whole number from 1, got"):
        Interface(ticks=ticks)


def test_reward_that_is_no_number_is_refused() -> None:
    task = load_task("door")
    learner, world = Learner(task, "chair", Interface(reward=lambda _: float("nan"))), SceneWorld(task)
    world.reset("1")
    learner.begin(world)
    with pytest.raises(ValueError, match="reward: expected a finite number from the function, got nan"):
        learner.judge(world, (0.0, 0.0), 1)
