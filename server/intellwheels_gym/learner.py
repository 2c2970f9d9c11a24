"""One learner in a world: its spaces, its observations, what its steps are worth and when its episode ends."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from gymnasium import spaces

from intellwheels_gym.actions import ActionKind, ActionSet
from intellwheels_gym.observation import Observation, ObservationKind, Observer, observation_space
from intellwheels_gym.rewards import DEFAULT_ENDS, DEFAULT_REWARD, End, Reward, Step, ends_of, reward_of
from intellwheels_gym.scene_world import SceneWorld
from intellwheels_gym.task import Task, body_of


@dataclass(frozen=True)
class Interface:
    """How learners see, act and are judged, the same for all of them.

    Attributes:
        observation: `flat` or `dict`.
        action: `velocity`, `powers` or `words`.
        reward: A name of `rewards.REWARDS`, a function of a `Step`, or weights by name.
        ends: Names of `rewards.ENDS`, or `End`s.
        ticks: Ticks of a step, at least 1. The motors keep their powers meanwhile.
    """

    observation: ObservationKind = "flat"
    action: ActionKind = "velocity"
    reward: str | Reward | Mapping[str, float] = field(default_factory=lambda: DEFAULT_REWARD)
    ends: Sequence[str | End] = DEFAULT_ENDS
    ticks: int = 1

    def __post_init__(self) -> None:
        if isinstance(self.ticks, bool) or not isinstance(self.ticks, int) or self.ticks < 1:
            raise ValueError(f"ticks: expected a whole number from 1, got {self.ticks!r}")


class Outcome(NamedTuple):
    """What a step gives, as Gymnasium orders it."""

    observation: Observation
    reward: float
    terminated: bool
    truncated: bool
    info: dict[str, Any]


class Learner:
    """One learner of a task."""

    def __init__(self, task: Task, name: str, interface: Interface) -> None:
        """Check that the body can learn that way.

        Raises:
            ValueError: It cannot, or the interface names something that is not there.
        """
        (cast,) = (one for one in task.row.scene.cast if one.name == name)
        robot = body_of(cast, task.folder)
        self.name = name
        self._kind = interface.observation
        self._actions = ActionSet(interface.action, robot)
        self._reward = reward_of(interface.reward)
        self._ends = ends_of(interface.ends)
        self._limit = task.seconds
        self._within = task.goals[name].within
        self.observation_space: spaces.Space[Any] = observation_space(robot, self._kind)
        self.action_space: spaces.Space[Any] = self._actions.space()
        self._observer: Observer | None = None
        self._goal = (0.0, 0.0)
        self._distance = 0.0
        self._contacts = 0
        self._ticks = 0

    def begin(self, world: SceneWorld) -> tuple[Observation, dict[str, Any]]:
        """Return the first observation of an episode, and its information."""
        robot, position, self._goal = world.learners[self.name]
        self._actions = ActionSet(self._actions.kind, robot)
        self._observer = Observer(robot, position, self._goal, world.period, self._kind)
        self._observer.update(world.measures(self.name))
        self._contacts, self._ticks = world.contacts(self.name), 0
        self._distance = self._off(world)
        return self._observer.observation(), self._info(world)

    def powers(self, action: Any) -> tuple[float, float]:
        """Return the motor powers of an action.

        Raises:
            ValueError: It is no action of this learner.
        """
        return self._actions.powers(action)

    def watch(self, world: SceneWorld) -> None:
        """Take the measures of a tick."""
        assert self._observer is not None  # noqa: S101 - the environments begin first
        self._observer.update(world.measures(self.name))
        self._ticks += 1

    def judge(self, world: SceneWorld, powers: tuple[float, float], ticks: int) -> Outcome:
        """Return the outcome of a step of so many ticks."""
        assert self._observer is not None  # noqa: S101 - the environments begin first
        before, self._distance = self._distance, self._off(world)
        known, self._contacts = self._contacts, world.contacts(self.name)
        step = Step(
            before=before, after=self._distance, reached=self._distance <= self._within,
            contacts=self._contacts - known, seconds=ticks * world.period, time=self._ticks * world.period,
            limit=self._limit, powers=powers,
        )  # fmt: skip
        reward = float(self._reward(step))
        if not math.isfinite(reward):
            raise ValueError(f"reward: expected a finite number from the function, got {reward!r}")
        met = [end for end in self._ends if end.met(step)]
        terminated = any(not end.truncates for end in met)
        truncated = any(end.truncates for end in met)
        info = self._info(world)
        if met:
            info["end"] = "+".join(end.name for end in met)
            info["is_success"] = step.reached and self._contacts == 0
        return Outcome(self._observer.observation(), reward, terminated, truncated, info)

    def _off(self, world: SceneWorld) -> float:
        x, y, _ = world.pose(self.name)
        return math.hypot(self._goal[0] - x, self._goal[1] - y)

    def _info(self, world: SceneWorld) -> dict[str, Any]:
        state = world.state
        return {
            "seed": state.setup.seed, "tick": state.tick, "distance": self._distance, "contacts": self._contacts,
        }  # fmt: skip
