"""Bodies that are there are dragged, turned and removed: a ghost moves, the body only when the state says so."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import viser

from intellwheels_schemas.messages import Delete, Teleport
from intellwheels_viewer.cameras import on_floor
from intellwheels_viewer.drawings.ghosts import Ghost
from intellwheels_viewer.held_ghost import HeldGhost, position
from intellwheels_viewer.steering import Wishes

if TYPE_CHECKING:
    from intellwheels_viewer.palette import Colours
    from intellwheels_viewer.snapshot import Snapshot

NUDGE: Final = 0.05
"""Metres: a body pulled less far was clicked."""


class DragMove:
    """What one browser does with the bodies that are there.

    Args:
        client: The browser.
        wishes: Where moves are asked for.
        hand: Holds the ghost.
        colours: The colour of each agent.
    """

    def __init__(self, client: viser.ClientHandle, wishes: Wishes, hand: HeldGhost, colours: Colours) -> None:
        self._client, self._wishes, self._hand, self._colours = client, wishes, hand, colours
        self._pulled: tuple[str, float, float] | None = None

    def drag(self, seen: Snapshot, name: str, event: viser.SceneNodeDragEvent[viser.SceneNodeHandle]) -> None:
        """Take one event of a drag that began on a body: its ghost moves, and at the end the body is asked to."""
        at = self._under(event.end_position)
        entity, body = seen.entity(name), seen.bodies.get(name)
        if event.phase == "start" or self._pulled is None or self._pulled[0] != name:
            start = self._under(event.start_position)
            if start is None or entity is None:
                return
            self._pulled = (name, entity.x - start[0], entity.y - start[1])
        if entity is None or body is None or at is None:
            self._pulled = None
            self._hand.let_go()
            return
        x, y = at[0] + self._pulled[1], at[1] + self._pulled[2]
        far = math.hypot(x - entity.x, y - entity.y) > NUDGE
        if far:
            self._hand.hold(Ghost(body.robot, x, y, entity.heading, self._colours.rgb(name)))
        if event.phase == "end":
            self._pulled = None
            if far:
                wish = Teleport(agent=name, position=position(x, y, entity.heading))
                self._wishes.ask("Not placed", "teleport", wish, self._hand.let_go, self._hand.let_go)
            else:
                self._hand.let_go()

    def turn(self, seen: Snapshot, name: str | None, degrees: float) -> None:
        """Ask for a body to be turned on by so much."""
        entity = None if name is None else seen.entity(name)
        if entity is not None:
            turned = position(entity.x, entity.y, entity.heading + math.radians(degrees))
            self._wishes.ask("Not turned", "teleport", Teleport(agent=entity.name, position=turned))

    def remove(self, name: str | None) -> None:
        """Ask for a body to be taken away."""
        if name is not None:
            self._wishes.ask("Not removed", "delete", Delete(agent=name))

    def _under(self, point: tuple[float, float, float]) -> tuple[float, float] | None:
        """Return the floor under the pointer: viser tells where it is on a plane that faces the camera."""
        eye = self._client.camera.position
        return on_floor(eye, (point[0] - eye[0], point[1] - eye[1], point[2] - eye[2]))
