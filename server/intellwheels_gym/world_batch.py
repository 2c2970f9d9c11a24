"""The worlds of many environments, advanced together as far as they fit to one another."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

from intellwheels_gym.scene_world import SceneWorld
from intellwheels_server.world import State, advance
from intellwheels_server.world.many_worlds import Worlds, advance_many, stack

Told: TypeAlias = tuple[SceneWorld, Mapping[str, tuple[float, float]]]
"""A world, and the powers of its learners."""


class WorldBatch:
    """Advances worlds by `advance_many`. A world that does not fit to the others is advanced alone.

    Worlds begin again at any time, and those that leave and join change their bodies. So each world is compared before
    every tick with what the batch knows of it, and put into its place again where it differs.
    """

    def __init__(self, count: int) -> None:
        """Prepare places for so many worlds."""
        self._count = count
        self._worlds: Worlds | None = None
        self._known: dict[int, State] = {}

    def advance(self, told: Mapping[int, Told]) -> None:
        """Make one tick of some worlds, given by their places. The others stay as they are.

        Raises:
            Exception: Whatever a mind raises, with a note that names its agent.
        """
        if not told:
            return
        inputs = {place: world.decide(powers) for place, (world, powers) in told.items()}
        worlds = self._filled({place: world.state for place, (world, _) in told.items()})
        together = {place: own for place, own in inputs.items() if place in self._known}
        worlds, _ = advance_many(worlds, together)
        self._worlds, self._known = worlds, {}
        for place, (world, _) in told.items():
            if place not in together:
                world.take(advance(world.state, inputs[place])[0], inputs[place])
                continue
            state = worlds.state(place)
            world.take(state, inputs[place])
            if world.state is state:
                self._known[place] = state

    def _filled(self, states: Mapping[int, State]) -> Worlds:
        """Return the batch with these states in their places, if they fit. `_known` then has those that do."""
        worlds = self._worlds
        if worlds is None or not (self._known or any(worlds.misfit(state) is None for state in states.values())):
            # Free places get any world that fits: it moves with the others and nobody looks at it.
            worlds = stack([next(iter(states.values()))] * self._count)
            self._known = {}
        new = {place: state for place, state in states.items() if self._known.get(place) is not state}
        fitting = {place: state for place, state in new.items() if worlds.misfit(state) is None}
        self._known = {place: state for place, state in states.items() if place not in new or place in fitting}
        return worlds.replaced(fitting) if fitting else worlds
