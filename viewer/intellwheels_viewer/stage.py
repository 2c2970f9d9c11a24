"""What all browsers see: one scene, drawn once per tick. Nothing here knows who looks.

Layers stand under a node of their own each, so that a browser can hide one by its own node of that name.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import TYPE_CHECKING, Final

import numpy as np
import viser

from intellwheels_viewer.drawings.bodies import Bodies
from intellwheels_viewer.drawings.contact_flashes import Contacts
from intellwheels_viewer.drawings.extruded_walls import Walls
from intellwheels_viewer.drawings.floor_plate import Floor
from intellwheels_viewer.drawings.ghosts import Ghosts, reported
from intellwheels_viewer.drawings.goals import Goals
from intellwheels_viewer.drawings.labels import Labels
from intellwheels_viewer.drawings.lidar_points import Lidars
from intellwheels_viewer.drawings.trails import Trails
from intellwheels_viewer.drawings.wedges import Wedges
from intellwheels_viewer.palette import Colours

if TYPE_CHECKING:
    from intellwheels_viewer.snapshot import Snapshot

LAYERS: Final = {
    "wedges": "/wedges", "lidar": "/lidar", "trails": "/trails", "labels": "/labels",
    "goals": "/goals",
}  # fmt: skip
"""The node of each layer that a browser may hide."""
SKY: Final = (232, 236, 241)
NIGHT: Final = (34, 37, 43)
FEW: Final = 100
"""Bodies up to which all wedges are drawn; of more the selected ones' only."""
MANY: Final = FEW // 3
"""Bodies above which what costs most is eased: only selected readings have arcs, labels and panels are less often."""
SLOW_EVERY: Final = 0.2
"""Simulated seconds between two drawings of what does not have to be smooth: trails and, of many, labels."""


def background(colour: tuple[int, int, int]) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    """Return a plain picture, shape (2, 2, 3)."""
    return np.full((2, 2, 3), colour, np.uint8)


class Stage:
    """The scene of all browsers.

    Args:
        server: The page's server.
        dark: Whether the page is dark.
    """

    def __init__(self, server: viser.ViserServer, *, dark: bool = False) -> None:
        self._server = server
        scene = server.scene
        scene.configure_environment_map(None)
        scene.configure_default_lights(enabled=False)
        # Together they give a colour back as it was meant; see CONTRIBUTING.md.
        scene.add_light_hemisphere("/lights/sky", intensity=2.0)
        scene.add_light_directional("/lights/sun", intensity=1.2, position=(-6.0, -9.0, 16.0), cast_shadow=True)
        scene.set_background_image(background(NIGHT if dark else SKY), format="png")
        for name in LAYERS.values():
            scene.add_frame(name, show_axes=False)
        self.colours = Colours()
        self._floor, self._walls = Floor(scene), Walls(scene)
        self.bodies = Bodies(scene)
        self._wedges, self._lidars = Wedges(scene), Lidars(scene)
        self._trails, self._goals = Trails(scene), Goals(scene)
        self._contacts, self._labels = Contacts(scene), Labels(scene)
        self._reported = Ghosts(scene, "/reported")
        self._revision = -1
        self._slow_at: tuple[str, float] = ("", -1.0)

    def show(self, seen: Snapshot, wanted: Collection[str]) -> None:
        """Draw what is seen, in one frame.

        Args:
            seen: The run.
            wanted: Agents that some browser has selected: their names and sensors are always drawn.
        """
        with self._server.atomic():
            if seen.floor is not None and seen.revision != self._revision:
                self._revision = seen.revision
                self._floor.show(seen.floor)
                self._walls.show(seen.floor)
            if seen.tick == 0:
                self.colours.begin()
            self.bodies.show(seen.bodies, seen.entities, self.colours, seen.stale)
            self._reported.show(reported(seen, self.colours))
            agents = watched(seen, wanted)
            many = len(seen.entities) > MANY
            # Three quarters of a wedge's bytes are its arc.
            self._wedges.show(seen.bodies, seen.entities, seen.measures, agents, wanted if many else None)
            self._lidars.show(seen.bodies, seen.entities, seen.measures, agents)
            self._contacts.show(seen.events, seen.tick, period_of(seen))
            self._goals.show(seen.entities, self.colours)
            run, at = self._slow_at
            is_due = seen.run != run or not at <= seen.time < at + SLOW_EVERY
            if is_due or not many:
                self._labels.show(seen.bodies, seen.entities, seen.words, seen.time, wanted)
            if is_due:
                self._slow_at = (seen.run, seen.time)
                self._trails.show(seen.history, seen.time, self.colours)

    def on_pick(self, call: Callable[[int, str], None]) -> None:
        """Call with the browser's number and the agent when a body is clicked."""
        self.bodies.on_pick(lambda name, event: call(event.client_id, name))


def watched(seen: Snapshot, wanted: Collection[str]) -> frozenset[str]:
    """Return whose sensors are drawn: everybody's while they are few, else those that somebody selected."""
    if len(seen.entities) <= FEW:
        return frozenset(entity.name for entity in seen.entities)
    # What a page selects may be any text.
    return frozenset(entity.name for entity in seen.entities if entity.name in wanted)


def period_of(seen: Snapshot) -> float:
    """Return the run's period in seconds, as its newest tick tells; 50 ms before there is one."""
    return seen.time / seen.tick if seen.tick > 0 else 0.05
