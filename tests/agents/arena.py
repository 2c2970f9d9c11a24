"""Minds in the real simulated world, in one process: the same as a run in strict lockstep, without its processes."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import msgspec

from intellwheels_agents import minds
from intellwheels_agents.mind import Bridge, Context, Mind
from intellwheels_agents.options import Options
from intellwheels_agents.robot_document import equipped, split_options
from intellwheels_maps import floor, robot
from intellwheels_schemas.file_records import Inputs, Join
from intellwheels_schemas.messages import Actions, Event, Map, Parameters, Position, Robot, Scene, UserInput
from intellwheels_server.world import Setup, State, advance, apply, begin, measures
from intellwheels_server.world.kernels import rows

RUN = "0123456789abcdef"


@dataclass
class Player:
    """An agent of an arena."""

    name: str
    mind: Mind | Bridge
    muted: bool = False


class Arena:
    """A world and the minds in it.

    Attributes:
        state: The world.
        events: All events so far.
        paths: The pose (x, y, heading) of each body at each tick, tick 0 first.
        said: The messages of each agent, with their ticks.
        users: The user input of each agent from now on.
    """

    def __init__(self, ground: str | Map, seed: str = "1", period: float = 0.05) -> None:
        document = floor(ground) if isinstance(ground, str) else ground
        self.setup = Setup(floor=document, seed=seed, period=period, strict=True, truth=True)
        self.state: State = begin(self.setup, RUN)
        self.players: dict[str, Player] = {}
        self.events: list[Event] = []
        self.paths: dict[str, list[tuple[float, float, float]]] = {}
        self.said: dict[str, list[tuple[int, str]]] = {}
        self.users: dict[str, UserInput] = {}

    @classmethod
    def of(cls, scene: Scene, seed: str | None = None) -> Arena:
        """Return the arena of a scene with its whole cast."""
        arena = cls(scene.map, scene.seed if seed is None else seed, scene.period)
        for one in scene.cast:
            arena.join(one.name, one.mind, one.robot, one.place, {each.name: each.value for each in one.option})
        return arena

    def join(
        self,
        name: str,
        mind: str,
        body: str,
        place: str | None,
        options: Mapping[str, str] | None = None,
        position: Position | None = None,
    ) -> Player:
        """Add an agent, at a place of the floor or at a position."""
        of_robot, of_mind = split_options(dict(options or {}))
        source = minds.find(mind)
        document = self.adapted(source.equip(equipped(robot(body), of_robot), Options(of_mind)))
        wanted = msgspec.structs.replace(document, format=None, place=place, position=position)
        self.state, outputs = apply(self.state, [Join(agent=name, robot=wanted)])
        (outcome,) = outputs.outcomes
        assert outcome.code == "ok", outcome.text
        assert outcome.robot is not None
        assert outcome.position is not None
        context = Context(
            agent=name,
            robot=outcome.robot,
            position=outcome.position,
            parameters=Parameters(
                world="arena", period=self.setup.period, pace="lockstep", say_limit=100,
                say_range=8.0, command_timeout=0.5, grace=3.0,
            ),
            options=Options(of_mind),
            fetch_map=lambda: self.setup.floor,
        )  # fmt: skip
        player = self.players[name] = Player(name, source.make(context))
        self.paths[name] = [self._pose(name)]
        self.said[name] = []
        return player

    def adapted(self, document: Robot) -> Robot:
        """Return the robot that joins; a world with other sensors changes it."""
        return document

    def sent(self, name: str, answer: Actions) -> Actions:
        """Return the actions of an agent that act at this tick; a world with a slow line keeps them back."""
        return answer

    def _pose(self, name: str) -> tuple[float, float, float]:
        x, y, heading = self.state.numbers[[rows.X, rows.Y, rows.HEADING], self.state.body_set.index[name]].tolist()
        return x, y, heading

    def speed(self, name: str) -> float:
        """Return the speed of a body, m/s."""
        return float(self.state.numbers[rows.SPEED, self.state.body_set.index[name]])

    def step(self) -> None:
        """Let every mind decide once, then advance the world by one tick."""
        actions: dict[str, Actions] = {}
        for name, player in self.players.items():
            answer = player.mind.decide(measures(self.state, name))
            assert isinstance(answer, Actions)
            if player.muted:
                answer = Actions(left_motor=answer.left_motor, right_motor=answer.right_motor)
            if answer.say is not None:
                self.said[name].append((self.state.tick, answer.say))
            actions[name] = self.sent(name, answer)
        self.state, outputs = advance(self.state, Inputs(actions=actions, user_input=dict(self.users)))
        self.events.extend(outputs.events)
        for name in self.players:
            self.paths[name].append(self._pose(name))

    def run(self, seconds: float, until: Callable[[Arena], bool] = lambda _: False) -> float:
        """Step for so many seconds, or until a condition holds; return the simulated time it took."""
        began = self.state.tick
        for _ in range(math.ceil(seconds / self.setup.period)):
            if until(self):
                break
            self.step()
        return (self.state.tick - began) * self.setup.period

    def contacts(self) -> list[Event]:
        """Return all contacts so far."""
        return [event for event in self.events if event.code == "contact"]
