"""The interface of a mind, and the context it is made with.

A mind is pure: `Measures` go in, `Actions` come out. It knows no network and no clock, and sees only the ticks it is
given. A new one is made for each run, so it needs no reset.

    from intellwheels_agents import Actions, Context, Measures

    class Mind:
        def __init__(self, context: Context) -> None:
            self.power = context.options.number("power", 0.5, -1.0, 1.0)

        def decide(self, measures: Measures) -> Actions:
            if measures.collision:
                return Actions(left_motor=0.0, right_motor=0.0, say="ouch")
            return Actions(left_motor=self.power, right_motor=self.power)
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

from intellwheels_agents.options import OptionError, Options
from intellwheels_maps.site_frame import from_site
from intellwheels_schemas.explain import did_you_mean
from intellwheels_schemas.messages import Actions, Map, Measures, Parameters, Pose, Position, Robot


class Mind(Protocol):
    """Decides what an agent does."""

    def decide(self, measures: Measures) -> Actions:
        """Return the actions for the measures of a tick.

        A mind sets powers, mode, goal, say and leave; the harness fills in all other fields.
        """
        ...


class Bridge(Protocol):
    """The body of a real chair, in the role `body`."""

    def decide(self, measures: Measures) -> Pose | None:
        """Return the chair's pose; None if it is unknown, and then nothing is reported."""
        ...


@dataclass(frozen=True)
class Context:
    """The information for a mind at the beginning of a run.

    Attributes:
        agent: The agent's name.
        robot: The body, as the simulator accepted it.
        position: Where the body was when it joined.
        parameters: The simulation's parameters.
        options: The options that the user gave, text by name.
        fetch_map: Asks the simulator for its map; `map` and `places` call it when they are first read.
        run: The identifier of the run.
    """

    agent: str
    robot: Robot
    position: Position
    parameters: Parameters
    options: Options
    fetch_map: Callable[[], Map]
    run: str = ""

    @cached_property
    def map(self) -> Map:
        """The map, fetched when first read."""
        return self.fetch_map()

    @cached_property
    def places(self) -> Mapping[str, Position]:
        """The named places of the map."""
        places = self.map.grid.position if self.map.grid else ()
        return {p.name: Position(x=p.x, y=p.y, heading=math.radians(p.heading_deg)) for p in places}

    def place(self, name: str, option: str) -> Position:
        """Return a named place.

        Args:
            name: The place's name.
            option: The option that gave the name, for the error text.

        Raises:
            OptionError: The map has no such place.
        """
        if name not in self.places:
            known = ", ".join(sorted(self.places)) or "none"
            hint = did_you_mean(name, self.places)
            raise OptionError(f"option {option}: expected a place of the map ({known}), got {name!r}{hint}")
        return self.places[name]

    def points(self, option: str) -> list[tuple[float, float]]:
        """Return the points of an option in the map frame, m. The user gives them in the coordinates of the site.

        Raises:
            OptionError: The option does not hold pairs of numbers.
        """
        given = self.options.points(option)
        return [from_site(self.map, point) for point in given]

    def route(self) -> list[tuple[float, float]]:
        """Return the points named by the options `points`, `via` and `to`, in this order, without the start; m.

        Raises:
            OptionError: The map has no such place, or `points` does not hold pairs of numbers.
        """
        points = self.points("points")
        for option in ("via", "to"):
            places = [self.place(name, option) for name in self.options.words(option)]
            points += [(place.x, place.y) for place in places]
        return points


Make = Callable[[Context], Mind | Bridge]
Equip = Callable[[Robot, Options], Robot]
