"""One chair as an environment of Gymnasium, and many worlds of it."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode, SyncVectorEnv

from intellwheels_gym.chair_env import ChairEnv, chair_vector
from intellwheels_gym.rewards import End
from intellwheels_gym.task import load_task
from tests.every_case import every_case


@pytest.mark.parametrize(
    "settings",
    [
        {"scene": "door"},
        {"scene": "door", "observation": "dict", "action": "powers", "ticks": 4},
        {"scene": "corner", "action": "words", "reward": "progress"},
    ],
)
def test_checker_of_gymnasium_finds_nothing(settings: dict[str, Any]) -> None:
    check_env(gymnasium.make("IntellWheels/Chair-v0", **settings).unwrapped)


def test_chair_that_drives_straight_passes_the_door() -> None:
    env = ChairEnv("door", ticks=4)
    _, info = env.reset(seed=1)
    assert info == {"seed": "1", "tick": 0, "distance": 13.0, "contacts": 0}
    total, over = 0.0, False
    while not over:
        _, reward, terminated, truncated, info = env.step([0.5, 0.0])
        total, over = total + reward, terminated or truncated
    assert (terminated, truncated, info["end"], info["is_success"]) == (True, False, "reached", True)
    assert total == pytest.approx(13.0 - info["distance"] + 10.0 - 0.1 * info["tick"] * 0.05)
    with pytest.raises(ResetNeeded, match="the episode has ended"):
        env.step([0.5, 0.0])


def test_contact_ends_an_episode_without_success() -> None:
    env = ChairEnv("door", goal=(-2.0, 1.0), ticks=4)
    env.reset(seed=1)
    info: dict[str, Any] = {}
    for _ in range(100):
        _, _, terminated, _, info = env.step([0.5, 0.1])
        if terminated:
            break
    assert (info["end"], info["is_success"]) == ("contact", False)


def test_time_truncates_and_own_ends_terminate() -> None:
    env = ChairEnv("door", seconds=0.2, ends=["timeout"])
    env.reset(seed=1)
    assert [env.step([0.0, 0.0])[2:4] for _ in range(4)] == [(False, False)] * 3 + [(False, True)]
    env = ChairEnv("door", ends=[End("first", lambda _: True)])
    env.reset(seed=1)
    *_, terminated, _, info = env.step([0.0, 0.0])
    assert (terminated, info["end"]) == (True, "first")


def test_seeds_follow_from_the_first() -> None:
    env = ChairEnv("door")
    seeds = [[env.reset(seed=5)[1]["seed"], env.reset()[1]["seed"], env.reset()[1]["seed"]] for _ in range(2)]
    assert seeds[0] == seeds[1]
    assert seeds[0][0] == "5"
    assert len(set(seeds[0])) == 3


@every_case(
    ("settings", "text"),
    [
        ({"render_mode": "human"}, "render_mode: expected None, got 'human'"),
        ({"agent": "chiar"}, "learners: expected agents of the scene"),
        ({"observation": "image"}, "observation: expected flat or dict"),
        ({"action": "wheels"}, "action: expected one of velocity"),
        ({"reward": "fast"}, "reward: expected one of"),
        ({"ticks": 0}, "ticks: expected"),
        ({"scene": "figure6", "agent": "table", "goal": "goal1"}, "robot: expected"),
        ({"scene": load_task("figure6")}, "expected a task with one learner, got chair1, chair2, chair3"),
        ({"scene": load_task("door"), "seconds": 3.0}, "got a task, which has its own"),
    ],
)
def test_wrong_settings_are_named(settings: dict[str, Any], text: str) -> None:
    with pytest.raises(ValueError, match=text):
        ChairEnv(**{"scene": "door", **settings})


def test_wrong_use_is_named() -> None:
    env = ChairEnv("door")
    with pytest.raises(ResetNeeded, match="never began"):
        env.step([0.0, 0.0])
    with pytest.raises(ValueError, match="options: expected none, got start"):
        env.reset(options={"start": "there"})
    env.reset(seed=1)
    with pytest.raises(ValueError, match=r"action: expected v in \[-1, 1\], got nan"):
        env.step(np.array([np.nan, 0.0]))
    env.step([0.0, 0.0])  # nothing happened


@pytest.mark.parametrize("mode", list(AutoresetMode))
def test_many_worlds_begin_again_as_the_mode_says(mode: AutoresetMode) -> None:
    worlds = chair_vector("door", 2, autoreset=mode, seconds=0.1)
    first, infos = worlds.reset(seed=8)
    assert first.shape == (2, 12)
    assert infos["seed"].tolist() == ["8", "9"]
    still = np.zeros((2, 2), dtype=np.float32)
    worlds.step(still)
    *_, truncated, infos = worlds.step(still)
    assert truncated.all()
    ticks = infos["tick"].tolist()
    assert ticks == ([0, 0] if mode is AutoresetMode.SAME_STEP else [2, 2])
    if mode is AutoresetMode.DISABLED:
        worlds.reset(options={"reset_mask": np.array([True, True])})
    *_, truncated, infos = worlds.step(still)
    assert infos["tick"].tolist() == ([0, 0] if mode is AutoresetMode.NEXT_STEP else [1, 1])
    worlds.close()


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
@pytest.mark.parametrize("scene", ["door", "table1"])
def test_worlds_advanced_together_give_what_each_gives_alone(scene: str, mode: AutoresetMode) -> None:
    settings: dict[str, Any] = {"seconds": 1.0, "action": "powers", "ticks": 2}
    together = chair_vector(scene, 3, autoreset=mode, **settings)
    alone = SyncVectorEnv([lambda: ChairEnv(scene, **settings)] * 3, autoreset_mode=mode)
    draw = np.random.default_rng(1)
    found: Any = together.reset(seed=8)
    wanted: Any = alone.reset(seed=8)
    for _ in range(25):
        assert plain(found) == plain(wanted)
        actions = draw.uniform(0.2, 1.0, (3, 2)).astype(np.float32)
        found, wanted = together.step(actions), alone.step(actions)
    assert plain(found) == plain(wanted)


def plain(found: Any) -> Any:
    """Return what an environment gives as lists and dictionaries, which can be compared."""
    if isinstance(found, np.ndarray):
        return [plain(one) for one in found.tolist()]
    if isinstance(found, dict):
        return {name: plain(one) for name, one in found.items()}
    return [plain(one) for one in found] if isinstance(found, tuple) else found


def test_wrong_action_of_one_world_moves_none() -> None:
    worlds = chair_vector("door", 2, action="powers")
    worlds.reset(seed=1)
    with pytest.raises(ValueError, match="expected right in"):
        worlds.step(np.array([[0.5, 0.5], [0.5, 2.0]]))
    *_, infos = worlds.step(np.zeros((2, 2), dtype=np.float32))
    assert infos["tick"].tolist() == [1, 1]


@pytest.mark.parametrize(
    ("count", "autoreset", "text"),
    [(0, "NextStep", "count: expected"), (True, "NextStep", "count: expected"), (2, "never", "autoreset: expected")],
)
def test_wrong_vectors_are_named(count: int, autoreset: str, text: str) -> None:
    with pytest.raises(ValueError, match=text):
        chair_vector("door", count, autoreset=autoreset)
