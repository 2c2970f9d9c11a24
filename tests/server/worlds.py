"""Small worlds for tests: a floor from corners, boxes on wheels, steps by the hundred."""

from __future__ import annotations

from collections.abc import Iterable

from intellwheels_schemas.file_records import Change, Inputs, Join
from intellwheels_schemas.messages import (
    Actions,
    Corner,
    End,
    Event,
    Grid,
    Map,
    Place,
    Position,
    Robot,
    Timeout,
    Wall,
)
from intellwheels_server.world import Outcome, Setup, State, advance, apply, begin

RUN = "0123456789abcdef"

ROUNDED = 5.1e-7
"""How far a reading may be from the exact number: readings are rounded to 1e-6."""


def box_wall(x0: float, y0: float, x1: float, y1: float) -> Wall:
    """Return a solid wall over a rectangle."""
    return Wall(corner=tuple(Corner(x=x, y=y) for x, y in ((x0, y0), (x1, y0), (x1, y1), (x0, y1))))


def floor_of(walls: Iterable[Wall] = (), places: Iterable[Place] = ()) -> Map:
    """Return a floor with these walls and places."""
    return Map(format="iw.v1", name="test", wall=tuple(walls), grid=Grid(position=tuple(places)))


def cart(x: float = 0.0, y: float = 0.0, heading: float = 0.0, **fields: object) -> Robot:
    """Return a robot of one part, 1.0 by 0.6, centre of movement in its middle, that obeys at once."""
    known: dict[str, object] = {
        "kind": "wheelchair",
        "length": 1.0,
        "width": 0.6,
        "center": 0.5,
        "top": 1.3,
        "top_speed": 1.0,
        "track": 0.5,
        "position": Position(x=x, y=y, heading=heading),
    }
    return Robot(**{**known, **fields})  # type: ignore[arg-type]


def world(robots: dict[str, Robot] | None = None, walls: Iterable[Wall] = (), **setup: object) -> State:
    """Return a world at tick 0 with these robots, all of which must be let in."""
    known: dict[str, object] = {"floor": floor_of(walls)}
    state = begin(Setup(**{**known, **setup}), RUN)  # type: ignore[arg-type]
    for name, robot in (robots or {}).items():
        state, outcome, _ = do(state, Join(agent=name, robot=robot))
        assert outcome.code == "ok", outcome.text
    return state


def unusual_setup() -> Setup:
    """Return a setup in which every field has a value other than its default."""
    setup = Setup(
        floor=floor_of([box_wall(5.0, 5.0, 6.0, 6.0)]),
        seed="unusual",
        period=0.025,
        say_limit=7,
        say_range=3.5,
        say_walls=True,
        say_loss=0.25,
        say_delay=0.75,
        command_timeout=1.25,
        truth=True,
        end=End(timeout=Timeout(seconds=60.0)),
        strict=True,
    )
    usual = Setup(floor=floor_of())
    same = [name for name in Setup.__struct_fields__ if getattr(setup, name) == getattr(usual, name)]
    assert same == [], f"give these fields another value here: {same}"
    return setup


def do(state: State, change: Change) -> tuple[State, Outcome, tuple[Event, ...]]:
    """Make one change."""
    state, outputs = apply(state, [change])
    return state, outputs.outcomes[0], outputs.events


def run(
    state: State, steps: int, powers: dict[str, tuple[float, float]] | None = None, inputs: Inputs | None = None
) -> tuple[State, list[Event]]:
    """Step so often under the same powers; return the state and all events."""
    events: list[Event] = []
    actions = {name: Actions(left_motor=left, right_motor=right) for name, (left, right) in (powers or {}).items()}
    for _ in range(steps):
        state, outputs = advance(state, inputs or Inputs(actions=actions))
        events.extend(outputs.events)
    return state, events
