"""The world of a task in this process: the simulator's own, with the minds of the scene for all who do not learn.

A run is the one that `iw-run` gives for the same scene, row and seed in lockstep: the same places, noise and order.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from typing import NamedTuple

import msgspec

from intellwheels_agents import minds
from intellwheels_agents.mind import Bridge, Context, Mind
from intellwheels_agents.options import Options
from intellwheels_agents.robot_document import split_options
from intellwheels_experiments.batch.seed_variation import varied_floor, varied_row
from intellwheels_gym.task import Task, body_of
from intellwheels_maps.cast_places import cast_places
from intellwheels_schemas import defaults
from intellwheels_schemas.file_records import Depart, Inputs, Join
from intellwheels_schemas.messages import Actions, Cast, Map, Measures, Parameters, Position, Robot
from intellwheels_server.world import Setup, State, Walls, advance, apply, begin, measures
from intellwheels_server.world.empty_world import empty_world
from intellwheels_server.world.kernels import rows


class Placed(NamedTuple):
    """A learner's body at the beginning of an episode: the robot as accepted, its pose, and its goal in m."""

    robot: Robot
    position: Position
    goal: tuple[float, float]


class SceneWorld:
    """A world with the cast of a task. `reset` comes first.

    Attributes:
        period: Simulated time of a tick, s.
        learners: The bodies of those who learn, by name.
    """

    def __init__(self, task: Task) -> None:
        self._task = task
        self.period = task.row.scene.period
        self.learners: dict[str, Placed] = {}
        self._minds: dict[str, Mind | Bridge] = {}
        self._walls: tuple[Map, Walls] | None = None
        self._state: State | None = None

    @property
    def state(self) -> State:
        """The state of the world."""
        if self._state is None:
            raise RuntimeError("expected reset() before anything else")
        return self._state

    def reset(self, seed: str) -> None:
        """Begin the run of a seed.

        Raises:
            WireError: The seed makes the map or an option invalid.
            ValueError: A body cannot start where it should.
        """
        scene = varied_row(self._task.row, seed).scene
        ground = varied_floor(self._task.ground, self._task.row, seed)
        setup = Setup(
            floor=ground, seed=seed, period=scene.period, say_range=scene.say_range, say_walls=scene.say_walls,
            say_loss=scene.say_loss, say_delay=scene.say_delay, truth=scene.truth, strict=True,
        )  # fmt: skip
        run = hashlib.blake2b(seed.encode(), digest_size=8).hexdigest()
        self._state = self._empty(setup, run)
        self.learners, self._minds = {}, {}
        places = cast_places(scene.cast, ground, beside=self._task.folder)
        for one in scene.cast:
            self._join(one, places.get(one.name), ground)

    def _empty(self, setup: Setup, run: str) -> State:
        """Return a world without bodies. Cutting walls takes time, so the last ones are kept."""
        ground = setup.floor
        if self._walls is not None:
            before, walls = self._walls
            if before.wall == ground.wall and before.obstacle == ground.obstacle:
                return empty_world(setup, run, walls)
        state = begin(setup, run)
        self._walls = ground, state.walls
        return state

    def _join(self, one: Cast, place: str | None, ground: Map) -> None:
        body = body_of(one, self._task.folder)
        learns = one.name in self._task.goals
        _, mind_options = split_options({option.name: option.value for option in one.option})
        options = Options(mind_options)
        source = None if learns else minds.find(self._mind_of(one))
        if source is not None:
            body = source.equip(body, Options(mind_options))
        wanted = msgspec.structs.replace(body, format=None, place=place)
        self._state, outputs = apply(self.state, [Join(agent=one.name, robot=wanted)])
        (outcome,) = outputs.outcomes
        if outcome.robot is None or outcome.position is None:
            raise ValueError(f"agent {one.name!r} cannot start: {outcome.text}")
        if source is None:
            self.learners[one.name] = Placed(
                outcome.robot, outcome.position, self._task.goals[one.name].on(ground)
            )  # fmt: skip
            return
        self._minds[one.name] = source.make(
            Context(
                agent=one.name, robot=outcome.robot, position=outcome.position, parameters=self._parameters(),
                options=options, fetch_map=lambda: ground, run=self.state.run,
            )
        )  # fmt: skip
        options.check_all_read()

    def _mind_of(self, one: Cast) -> str:
        folder = self._task.folder
        is_file = one.mind.endswith(".py") or "/" in one.mind
        return str(folder / one.mind) if is_file and folder is not None else one.mind

    def _parameters(self) -> Parameters:
        setup = self.state.setup
        return Parameters(
            world=defaults.WORLD, period=setup.period, pace="lockstep", say_limit=setup.say_limit,
            say_range=setup.say_range, command_timeout=setup.command_timeout, grace=defaults.GRACE,
        )  # fmt: skip

    def advance(self, powers: Mapping[str, tuple[float, float]]) -> None:
        """Make one tick: every mind decides, and the learners' motors get their powers, in [-1, 1]."""
        inputs = self.decide(powers)
        state, _ = advance(self.state, inputs)
        self.take(state, inputs)

    def decide(self, powers: Mapping[str, tuple[float, float]]) -> Inputs:
        """Return the inputs of the next tick: what every mind decides, and the learners' powers, in [-1, 1]."""
        actions = {name: Actions(left_motor=left, right_motor=right) for name, (left, right) in powers.items()}
        for name, mind in self._minds.items():
            try:
                decided = mind.decide(measures(self.state, name))
            except Exception as error:
                error.add_note(f"raised by the mind of agent {name!r}")
                raise
            if isinstance(decided, Actions):
                actions[name] = decided
        return Inputs(actions=actions)

    def take(self, state: State, inputs: Inputs) -> None:
        """Go on from the state that these inputs lead to. Whoever leaves is gone at once."""
        self._state = state
        for name in [name for name, one in inputs.actions.items() if one.leave]:
            del self._minds[name]
            self._state, _ = apply(self.state, [Depart(agent=name)])

    def measures(self, name: str) -> Measures:
        """Return the measures of a learner at this tick."""
        return measures(self.state, name)

    def pose(self, name: str) -> tuple[float, float, float]:
        """Return the true pose of a body: x and y in m, heading in rad."""
        state = self.state
        x, y, heading = state.numbers[[rows.X, rows.Y, rows.HEADING], state.body_set.index[name]].tolist()
        return x, y, heading

    def contacts(self, name: str) -> int:
        """Return the number of contacts of a body so far. A contact that lasts counts once."""
        return int(self.state.flags[rows.CONTACTS, self.state.body_set.index[name]])
