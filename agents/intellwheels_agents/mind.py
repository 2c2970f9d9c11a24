"""What a mind is, and what it is told when it is made.

A mind is pure: what it perceives goes in, what it does comes out. It knows no network, no clock and
no tick it was not told of. It is made anew at each run, so it needs no reset.

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
from intellwheels_schemas.messages import Actions, Map, Measures, Parameters, Pose, Position, Robot


class Mind(Protocol):
    """What decides."""

    def decide(self, measures: Measures) -> Actions:
        """Return what to do now that this is perceived.

        Of the actions only powers, mode, goal, say and leave are the mind's; the harness fills in the rest.
        """
        ...


class Bridge(Protocol):
    """What stands for the body of a real chair: role `body`."""

    def decide(self, measures: Measures) -> Pose | None:
        """Return where the chair is, or None when that is not known: then nothing is reported."""
        ...


@dataclass(frozen=True)
class Context:
    """What a mind is told when a run begins.

    Attributes:
        agent: The name of its body.
        robot: The body as the simulator accepted it.
        position: Where the body stood when it joined.
        parameters: The simulation's.
        options: What the user gave, text by name.
        fetch_map: Asks the simulator for its map; `map` and `places` do so when first read.
        run: Which run it is.
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
        """The floor, fetched when first read."""
        return self.fetch_map()

    @cached_property
    def places(self) -> Mapping[str, Position]:
        """The named places of the floor."""
        places = self.map.grid.position if self.map.grid else ()
        return {p.name: Position(x=p.x, y=p.y, heading=math.radians(p.heading_deg)) for p in places}

    def place(self, name: str, option: str) -> Position:
        """Return a named place.

        Args:
            name: The place's name.
            option: The option that names it, for the error.

        Raises:
            OptionError: The map has no such place.
        """
        if name not in self.places:
            known = ", ".join(sorted(self.places)) or "none"
            raise OptionError(f"option {option}: expected a place of the map ({known}), got {name!r}")
        return self.places[name]

    def way(self) -> list[tuple[float, float]]:
        """Return the points that the options `points`, `via` and `to` name, in this order; none of them is the start.

        Raises:
            OptionError: A place is not in the map, or points are no numbers.
        """
        points = list(self.options.points("points"))
        for option in ("via", "to"):
            places = [self.place(name, option) for name in self.options.words(option)]
            points += [(place.x, place.y) for place in places]
        return points


Make = Callable[[Context], Mind | Bridge]
Equip = Callable[[Robot, Options], Robot]
