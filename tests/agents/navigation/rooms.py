"""Small maps and bodies for the tests of the package `navigation`."""

from __future__ import annotations

from intellwheels_agents.navigation.cost_to_go import Weights
from intellwheels_agents.navigation.footprint_clearance import boxes_of, clearances, frame_of, solids_of
from intellwheels_schemas.messages import Corner, Grid, Map, Obstacle, Part, Place, Robot, Wall


def room(*obstacles: tuple[float, float, float, float], size: float = 6.0, places: tuple[Place, ...] = ()) -> Map:
    """Return a square room from (0, 0), with boxes: west, south, east, north."""
    ring = [(0.0, 0.0), (size, 0.0), (size, size), (0.0, size), (0.0, 0.0)]
    return Map(
        format="iw.v1",
        name="tested",
        wall=(Wall(thickness=0.1, corner=tuple(Corner(x=x, y=y) for x, y in ring)),),
        obstacle=tuple(
            Obstacle(
                name=f"box{i}",
                top=1.0,
                corner=tuple(Corner(x=x, y=y) for x, y in ((west, south), (east, south), (east, north), (west, north))),
            )
            for i, (west, south, east, north) in enumerate(obstacles)
        ),
        grid=Grid(position=places),
    )


CHAIR = Robot(
    top_speed=1.0,
    acceleration_curve=0.5,
    part=(
        Part(x=0.2, y=0.0, length=1.0, width=0.6, bottom=0.0, top=0.5),
        Part(x=0.1, y=0.0, length=0.6, width=0.5, bottom=0.5, top=1.3),
    ),
)


def weights(document: Map, robot: Robot = CHAIR) -> Weights:
    frame = frame_of(document, 0.1)
    return Weights(frame, clearances(frame, solids_of(document), boxes_of(robot)))
