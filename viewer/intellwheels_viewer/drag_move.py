"""Dragging, turning and removing bodies. A ghost moves with the pointer; the body moves when the simulator agrees."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import viser

from intellwheels_schemas.messages import Delete, Entity, Position, Result, Teleport
from intellwheels_viewer.cameras import on_floor
from intellwheels_viewer.drawings.ghosts import Ghost
from intellwheels_viewer.held_ghost import HeldGhost, position
from intellwheels_viewer.steering import RequestQueue
from intellwheels_viewer.undo import UndoStack

if TYPE_CHECKING:
    from intellwheels_viewer.palette import Colours
    from intellwheels_viewer.snapshot import Snapshot

NUDGE: Final = 0.05
"""Metres: a shorter drag counts as a click."""


class DragMove:
    """Moving bodies in one browser.

    Args:
        client: The browser.
        requests: Takes the requests for moves.
        held_ghost: The browser's ghost.
        colours: The colour of each agent.
        undo: Takes the requests that undo moves.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        requests: RequestQueue,
        held_ghost: HeldGhost,
        colours: Colours,
        undo: UndoStack,
    ) -> None:
        self._client, self._requests, self._held_ghost, self._colours = client, requests, held_ghost, colours
        self._undo = undo
        self._pulled: tuple[str, float, float] | None = None

    def drag(self, snapshot: Snapshot, name: str, event: viser.SceneNodeDragEvent[viser.SceneNodeHandle]) -> None:
        """Take one event of a drag that began on a body: move its ghost, and at the end request the move."""
        at = self._under(event.end_position)
        entity, body = snapshot.entity(name), snapshot.bodies.get(name)
        if event.phase == "start" or self._pulled is None or self._pulled[0] != name:
            start = self._under(event.start_position)
            if start is None or entity is None:
                return
            self._pulled = (name, entity.x - start[0], entity.y - start[1])
        if entity is None or body is None or at is None:
            self._pulled = None
            self._held_ghost.clear()
            return
        x, y = at[0] + self._pulled[1], at[1] + self._pulled[2]
        far = math.hypot(x - entity.x, y - entity.y) > NUDGE
        if far:
            self._held_ghost.hold(Ghost(body.robot, x, y, entity.heading, self._colours.rgb(name)))
        if event.phase == "end":
            self._pulled = None
            if far:
                self._move(snapshot, entity, position(x, y, entity.heading), "Not placed")
            else:
                self._held_ghost.clear()

    def turn(self, snapshot: Snapshot, name: str | None, degrees: float) -> None:
        """Request that a body turns by this many degrees, anticlockwise."""
        entity = None if name is None else snapshot.entity(name)
        if entity is not None:
            turned = position(entity.x, entity.y, entity.heading + math.radians(degrees))
            self._move(snapshot, entity, turned, "Not turned")

    def _move(self, snapshot: Snapshot, entity: Entity, to: Position, what: str) -> None:
        run, before = snapshot.run, position(entity.x, entity.y, entity.heading)

        def moved(_: Result) -> None:
            self._held_ghost.clear()
            self._undo.push(run, "teleport", Teleport(agent=entity.name, position=before))

        request = Teleport(agent=entity.name, position=to)
        self._requests.ask(what, "teleport", request, moved, self._held_ghost.clear)

    def remove(self, name: str | None) -> None:
        """Request that a body is removed."""
        if name is not None:
            self._requests.ask("Not removed", "delete", Delete(agent=name))

    def _under(self, point: tuple[float, float, float]) -> tuple[float, float] | None:
        """Return the floor point under the pointer. Viser reports the pointer on a plane that faces the camera."""
        eye = self._client.camera.position
        return on_floor(eye, (point[0] - eye[0], point[1] - eye[1], point[2] - eye[2]))
