"""Many chairs as a parallel environment of PettingZoo."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest
from gymnasium.error import ResetNeeded

from intellwheels_gym.chairs_env import ChairsEnv

with warnings.catch_warnings():
    # Its tests import a game by a way that it has deprecated itself.
    warnings.simplefilter("ignore")
    from pettingzoo.test import parallel_api_test, parallel_seed_test

STILL = np.zeros(2, dtype=np.float32)


@pytest.mark.parametrize("settings", [{}, {"observation": "dict", "action": "words", "ticks": 5, "seconds": 2.0}])
def test_checker_of_pettingzoo_finds_nothing(settings: dict[str, Any]) -> None:
    parallel_api_test(ChairsEnv("figure6", **settings), num_cycles=60)


def test_seed_test_of_pettingzoo_finds_nothing() -> None:
    parallel_seed_test(lambda: ChairsEnv("figure6", ticks=4), num_cycles=15)


def test_chair_that_has_ended_stays_while_the_others_drive_on() -> None:
    env = ChairsEnv("figure6", learners=["chair1", "chair2"], goals={"chair1": (0.0, 0.0)}, ticks=4)
    env.reset(seed=1)
    assert env.possible_agents == ["chair1", "chair2"]
    over = False
    for _ in range(200):
        found = env.step({"chair1": [1.0, 0.0], "chair2": [0.0, 0.0]})
        over = found[2]["chair1"]
        if over:
            break
    assert over
    assert env.agents == ["chair2"]
    observations, *_ = env.step({"chair2": [0.0, 0.0]})
    assert list(observations) == ["chair2"]


def test_wrong_use_is_named() -> None:
    env = ChairsEnv("figure6")
    with pytest.raises(ResetNeeded, match="none began"):
        env.step({})
    env.reset(seed=1)
    with pytest.raises(ValueError, match="actions: expected those of chair1, chair2, chair3, got chair1, door"):
        env.step({"chair1": STILL, "door": STILL})
    with pytest.raises(ValueError, match="agent 'chair2': action: expected two numbers, got shape"):
        env.step({"chair1": STILL, "chair2": np.zeros(3), "chair3": STILL})
