"""The scene that all browsers share, drawn once per tick. Nothing here depends on a single browser.

Each layer is below a node of its own, so a browser can hide it with a node of the same name in its own scene.
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
from intellwheels_viewer.drawings.labels import Labels, tags
from intellwheels_viewer.drawings.lidar_points import Lidars
from intellwheels_viewer.drawings.sun import add_sun
from intellwheels_viewer.drawings.trails import Trails
from intellwheels_viewer.drawings.wedges import Wedges
from intellwheels_viewer.palette import Colours

if TYPE_CHECKING:
    from intellwheels_viewer.snapshot import Snapshot

LAYERS: Final = {"all_wedges": "/wedges", "lidar": "/lidar", "trails": "/trails", "goals": "/goals"}
"""The node of each layer that a browser can hide. Labels and the wedges of the selection are a browser's own."""
SKY: Final = (232, 236, 241)
NIGHT: Final = (34, 37, 43)
"""Backgrounds of the light and the dark theme, sRGB."""
FEW: Final = 100
"""Up to this many bodies the wedges of all are drawn; above it only those of selected ones."""
MANY: Final = FEW // 3
"""Above this many bodies only selected bodies have arcs, and panels are updated less often."""
SLOW_EVERY: Final = 0.2
"""Simulated seconds between two updates of trails and, with many bodies, of a recording's labels."""
PERIOD: Final = 0.05
"""Seconds of a tick while the period is unknown, before the first tick."""


def background(colour: tuple[int, int, int]) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    """Return a picture of one colour, shape (2, 2, 3)."""
    return np.full((2, 2, 3), colour, np.uint8)


class Stage:
    """The scene of all browsers.

    Args:
        server: The web server.
        dark: Whether the page uses the dark theme.
    """

    def __init__(self, server: viser.ViserServer, *, dark: bool = False) -> None:
        self._server = server
        scene = server.scene
        scene.configure_environment_map(None)
        scene.configure_default_lights(enabled=False)
        # With these two lights a surface has the colour that was assigned to it.
        scene.add_light_hemisphere("/lights/sky", intensity=2.0)
        add_sun(scene, shadows=True)
        scene.set_background_image(background(NIGHT if dark else SKY), format="png")
        for name in (*LAYERS.values(), "/labels"):
            scene.add_frame(name, show_axes=False)
        self.colours = Colours()
        self._floor, self._walls = Floor(scene, dark=dark), Walls(scene, dark=dark)
        self.bodies = Bodies(scene)
        self._wedges, self._lidars = Wedges(scene), Lidars(scene)
        self._trails, self._goals = Trails(scene), Goals(scene)
        self._contacts, self._labels = Contacts(scene), Labels(scene)
        self._reported = Ghosts(scene, "/reported")
        self._has_wedges = False
        self._revision = -1
        self._slow_at: tuple[str, float] = ("", -1.0)

    def show(self, snapshot: Snapshot, wanted: Collection[str], *, wedges: bool = False, labels: bool = False) -> None:
        """Draw a snapshot in one frame.

        Args:
            snapshot: The run.
            wanted: Agents that some browser has selected; their sensors are always drawn.
            wedges: Whether some browser or a recording shows the wedges of all agents. A browser draws those of its
                own selection itself.
            labels: Whether a recording needs labels. A browser draws its own.
        """
        with self._server.atomic():
            if snapshot.floor is not None and snapshot.revision != self._revision:
                self._revision = snapshot.revision
                self._floor.show(snapshot.floor)
                self._walls.show(snapshot.floor)
            self.bodies.show(snapshot.bodies, snapshot.entities, self.colours, snapshot.stale)
            self._reported.show(reported(snapshot, self.colours))
            agents = watched(snapshot, wanted)
            many = len(snapshot.entities) > MANY
            if wedges or self._has_wedges:
                shown = agents if wedges else frozenset()
                arcs = wanted if many else None  # an arc is three quarters of a wedge's data
                self._wedges.show(snapshot.bodies, snapshot.entities, snapshot.measures, shown, arcs)
                self._has_wedges = wedges
            self._lidars.show(snapshot.bodies, snapshot.entities, snapshot.measures, agents)
            self._contacts.show(snapshot.events, snapshot.tick, snapshot.period or PERIOD)
            self._goals.show(snapshot.entities, self.bodies.documents, self.colours)
            run, at = self._slow_at
            is_due = snapshot.run != run or not at <= snapshot.time < at + SLOW_EVERY
            if labels and (is_due or not many):
                said = snapshot.utterances
                self._labels.show(tags(snapshot.bodies, snapshot.entities, said, snapshot.time, wanted), None)
            if is_due:
                self._slow_at = (snapshot.run, snapshot.time)
                self._trails.show(snapshot.history, snapshot.time, self.colours)

    def on_pick(self, call: Callable[[int, str], None]) -> None:
        """Call with the browser's number and the agent's name when a body is clicked."""
        self.bodies.on_pick(lambda name, event: call(event.client_id, name))


def watched(snapshot: Snapshot, wanted: Collection[str]) -> frozenset[str]:
    """Return the agents whose sensors are drawn: all if there are few, else those that a browser has selected."""
    if len(snapshot.entities) <= FEW:
        return frozenset(entity.name for entity in snapshot.entities)
    # A page can send any text as its selection.
    return frozenset(entity.name for entity in snapshot.entities if entity.name in wanted)
