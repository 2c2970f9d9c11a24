"""Scenes as tasks for reinforcement learning: environments of Gymnasium and PettingZoo, on the simulator's own world.

    import gymnasium, intellwheels_gym

    env = gymnasium.make("IntellWheels/Chair-v0", scene="door")
    observation, info = env.reset(seed=1)
    observation, reward, terminated, truncated, info = env.step([0.5, 0.0])

`ChairEnv` is one chair, `chair_vector` many worlds of it, `ChairsEnv` many chairs in one world. Nothing is sent over a
network. `Observer` and `ActionSet` let a mind on the network see and act as in training.
"""

from intellwheels_schemas.extras import missing_extra

_LACKING = missing_extra("learn")
if _LACKING is not None:
    raise ImportError(f"intellwheels_gym: {_LACKING}")

import gymnasium as _gymnasium  # noqa: E402 - only if it is there

from intellwheels_gym.actions import ActionSet  # noqa: E402
from intellwheels_gym.chair_env import ChairEnv, chair_vector  # noqa: E402
from intellwheels_gym.chairs_env import ChairsEnv  # noqa: E402
from intellwheels_gym.observation import Observer  # noqa: E402
from intellwheels_gym.rewards import ENDS, REWARDS, End, Step  # noqa: E402
from intellwheels_gym.task import Task, load_task  # noqa: E402

__all__ = [
    "ENDS", "REWARDS", "ActionSet", "ChairEnv", "ChairsEnv", "End", "Observer", "Step", "Task", "chair_vector",
    "load_task",
]  # fmt: skip

if "IntellWheels/Chair-v0" not in _gymnasium.registry:
    _gymnasium.register("IntellWheels/Chair-v0", entry_point="intellwheels_gym.chair_env:ChairEnv")
