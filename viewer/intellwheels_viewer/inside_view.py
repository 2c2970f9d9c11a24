"""What one browser sees from a chair, and others do not: ceiling, whole doors, the own hand. And whom it sees."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import viser

from intellwheels_schemas.messages import Entity
from intellwheels_viewer.drawings.building_colours import colours_of
from intellwheels_viewer.drawings.ceiling import ceiling
from intellwheels_viewer.drawings.cockpit import Cockpit
from intellwheels_viewer.drawings.door_tops import DoorTops
from intellwheels_viewer.drawings.glb import glb
from intellwheels_viewer.head_turn import Eye, position_of
from intellwheels_viewer.sight import Segments, blinds, in_sight, leaves

if TYPE_CHECKING:
    from intellwheels_viewer.snapshot import Snapshot


class InsideView:
    """The view from the chair in the scene of one browser. Its nodes are made when it is first seen.

    Args:
        scene: That of the browser.
        dark: Whether it has the colours of the dark theme; it may change before `show`.
    """

    def __init__(self, scene: viser.SceneApi, *, dark: bool = False) -> None:
        self._scene = scene
        self.dark = dark
        self._doors, self._cockpit = DoorTops(scene), Cockpit(scene)
        self._ceiling: viser.GlbHandle | None = None
        self._ceiling_of = (-1, dark)
        self._blinds: tuple[int, float, Segments] = (-1, 0.0, np.zeros((0, 4)))

    def show(self, snapshot: Snapshot, entity: Entity | None, eye: Eye, *, full_walls: bool) -> list[Entity] | None:
        """Show what is seen from a body, or hide it, and return the others in sight; None from elsewhere.

        Args:
            snapshot: The run.
            entity: The body from which the browser looks; None if it looks from elsewhere.
            eye: Where in the body the eye is.
            full_walls: Whether walls have their full height.
        """
        body = None if entity is None else snapshot.bodies.get(entity.name)
        self._doors.show(snapshot.bodies, snapshot.entities if full_walls or entity is not None else ())
        self._cockpit.show(None if body is None else body.robot, entity)
        self._show_ceiling(snapshot, visible=entity is not None)
        if entity is None:
            return None
        at = position_of(entity, eye)
        others = [each for each in snapshot.entities if each.name != entity.name]
        hidden_by = np.concatenate(
            [self._walls(snapshot, eye.height), leaves(snapshot.bodies, snapshot.entities, eye.height)]
        )
        return in_sight((float(at[0]), float(at[1])), others, hidden_by)

    def _walls(self, snapshot: Snapshot, height: float) -> Segments:
        revision, before, segments = self._blinds
        if snapshot.floor is not None and (revision, before) != (snapshot.revision, height):
            segments = blinds(snapshot.floor, height)
            self._blinds = (snapshot.revision, height, segments)
        return segments

    def _show_ceiling(self, snapshot: Snapshot, *, visible: bool) -> None:
        wanted = (snapshot.revision, self.dark)
        if visible and snapshot.floor is not None and wanted != self._ceiling_of:
            self._ceiling_of = wanted
            made = ceiling(snapshot.floor, colours_of(dark=self.dark))
            if made:
                self._ceiling = self._scene.add_glb("/ceiling", glb(made), cast_shadow=False, receive_shadow=False)
            elif self._ceiling is not None:
                self._ceiling.remove()
                self._ceiling = None
        if self._ceiling is not None:
            self._ceiling.visible = visible
