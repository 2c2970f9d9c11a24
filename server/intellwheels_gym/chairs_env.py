"""Many chairs of one scene that learn, as a PettingZoo parallel environment."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from gymnasium import spaces
from gymnasium.error import ResetNeeded
from pettingzoo import ParallelEnv

from intellwheels_gym.actions import ActionKind
from intellwheels_gym.chair_env import LARGEST_SEED
from intellwheels_gym.learner import Interface, Learner
from intellwheels_gym.observation import Observation, ObservationKind
from intellwheels_gym.rewards import DEFAULT_ENDS, DEFAULT_REWARD, End, Reward
from intellwheels_gym.scene_world import SceneWorld
from intellwheels_gym.task import load_task
from intellwheels_schemas.messages import Scene

STILL = (0.0, 0.0)


class ChairsEnv(ParallelEnv):  # type: ignore[misc] # PettingZoo ships no types
    """Several chairs of a scene in one world. The others of the cast have the minds that the scene gives them.

    A chair whose episode has ended stays where it is, with its motors off, until all have ended. Seeds and `info` are
    those of `ChairEnv`.

    Attributes:
        possible_agents: The learners, in the order of the cast.
        agents: Those whose episode has not ended.
    """

    metadata: ClassVar[dict[str, Any]] = {"name": "intellwheels_chairs_v0", "render_modes": []}

    def __init__(
        self,
        scene: str | Path | Scene,
        *,
        learners: Sequence[str] | None = None,
        goals: Mapping[str, object] | None = None,
        row: str | None = None,
        seconds: float | None = None,
        observation: ObservationKind = "flat",
        action: ActionKind = "velocity",
        reward: str | Reward | Mapping[str, float] = DEFAULT_REWARD,
        ends: Sequence[str | End] = DEFAULT_ENDS,
        ticks: int = 1,
    ) -> None:
        """Load a scene as a task of several learners.

        Args:
            scene: The name of an included scene, the path of a file, or a scene.
            learners: The agents that learn; default: every wheelchair with a goal.
            goals: Their goals by name: a place of the map, or (x, y) in m; default: their Reach in the scene.
            row: As for `ChairEnv`, like all that follow.
            seconds: Length of an episode.
            observation: `flat` or `dict`.
            action: `velocity`, `powers` or `words`.
            reward: How a step of each chair is judged.
            ends: When the episode of a chair ends.
            ticks: Ticks of a step.

        Raises:
            WireError: The scene or a file that it uses is missing or wrong.
            ValueError: An argument does not fit.
        """
        task = load_task(scene, learners=learners, goals=goals, row=row, seconds=seconds)
        self._interface = Interface(observation, action, reward, ends, ticks)
        self._learners = {name: Learner(task, name, self._interface) for name in task.goals}
        self._world = SceneWorld(task)
        self._random = np.random.default_rng()
        self.render_mode = None
        self.possible_agents = list(self._learners)
        self.agents: list[str] = []
        self.observation_spaces = {name: one.observation_space for name, one in self._learners.items()}
        self.action_spaces = {name: one.action_space for name, one in self._learners.items()}

    def observation_space(self, agent: str) -> spaces.Space[Any]:
        """Return the space of an agent's observations, always the same object."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> spaces.Space[Any]:
        """Return the space of an agent's actions, always the same object."""
        return self.action_spaces[agent]

    def reset(
        self,
        seed: int | None = None,
        options: dict[str, Any] | None = None,  # noqa: ARG002 - PettingZoo passes it by name
    ) -> tuple[dict[str, Observation], dict[str, dict[str, Any]]]:
        """Begin an episode, and return the first observations and the information, by agent.

        Args:
            seed: A whole number from 0; None draws the next one.
            options: Without effect: there are none, and PettingZoo wants any to be accepted.
        """
        if seed is not None:
            self._random = np.random.default_rng(seed)
        number = int(self._random.integers(LARGEST_SEED)) if seed is None else seed
        self._world.reset(str(number))
        self.agents = list(self.possible_agents)
        begun = {name: one.begin(self._world) for name, one in self._learners.items()}
        return {name: first[0] for name, first in begun.items()}, {name: first[1] for name, first in begun.items()}

    def step(
        self, actions: Mapping[str, Any]
    ) -> tuple[dict[str, Observation], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]]:
        """Make a step, and return observations, rewards, terminated, truncated and information, by agent.

        Args:
            actions: The action of every agent in `agents`.

        Raises:
            ValueError: An action is missing or wrong, or is that of somebody else.
            ResetNeeded: The episode of every agent has ended, or none began.
        """
        if not self.agents:
            raise ResetNeeded("expected reset() before step(): all episodes have ended, or none began")
        if set(actions) != set(self.agents):
            raise ValueError(f"actions: expected those of {', '.join(self.agents)}, got {', '.join(actions) or 'none'}")
        powers = dict.fromkeys(self.possible_agents, STILL)
        for name in self.agents:
            try:
                powers[name] = self._learners[name].powers(actions[name])
            except ValueError as error:
                raise ValueError(f"agent {name!r}: {error}") from None
        for _ in range(self._interface.ticks):
            self._world.advance(powers)
            for name in self.agents:
                self._learners[name].watch(self._world)
        found = {
            name: self._learners[name].judge(self._world, powers[name], self._interface.ticks) for name in self.agents
        }
        self.agents = [name for name, one in found.items() if not (one.terminated or one.truncated)]
        return (
            {name: one.observation for name, one in found.items()},
            {name: one.reward for name, one in found.items()},
            {name: one.terminated for name, one in found.items()},
            {name: one.truncated for name, one in found.items()},
            {name: one.info for name, one in found.items()},
        )

    def close(self) -> None:
        """Do nothing: the world is in this process."""

    def render(self) -> None:
        """Do nothing: the viewer shows runs on the network."""
