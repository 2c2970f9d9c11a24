"""Placing a body from the palette: a ghost follows the pointer, and a click on the floor requests the body.

If the simulator refuses, the ghost turns red and stays, so that the user can place it elsewhere.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Final

import msgspec
import viser

from intellwheels_maps import robot
from intellwheels_schemas.messages import Delete, Result, Spawn
from intellwheels_viewer.cameras import on_floor, ray
from intellwheels_viewer.clicks import FloorClicks
from intellwheels_viewer.drawings.ghosts import Ghost
from intellwheels_viewer.held_ghost import HeldGhost, position
from intellwheels_viewer.panels.place import PALETTE
from intellwheels_viewer.steering import RequestQueue
from intellwheels_viewer.undo import UndoStack

if TYPE_CHECKING:
    from intellwheels_viewer.snapshot import Snapshot

GHOST_COLOUR: Final = (90, 100, 115)


class PlacingClick:
    """Placing in one browser.

    Args:
        client: The browser.
        requests: Takes the requests for bodies.
        held_ghost: The browser's ghost.
        snapshot: Returns the newest snapshot, for the names in use and the run.
        undo: Takes the requests that remove placed bodies again.

    Attributes:
        label: The label in the palette that is being placed; None for none.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        requests: RequestQueue,
        held_ghost: HeldGhost,
        snapshot: Callable[[], Snapshot],
        undo: UndoStack,
    ) -> None:
        self._client, self._requests, self._held_ghost = client, requests, held_ghost
        self._snapshot, self._undo = snapshot, undo
        self.label: str | None = None
        self._heading = 0.0
        self._clicks = FloorClicks(client.scene, self.put)

    def choose(self, label: str | None) -> None:
        """Start placing the thing with this label of the palette; any other value stops placing."""
        self.label = label if label in PALETTE else None
        self._clicks.listen(self.label is not None)
        if self.label is None:
            self._held_ghost.clear()
            return
        look_at = self._client.camera.look_at
        self._preview(float(look_at[0]), float(look_at[1]))

    def turn(self, degrees: float) -> None:
        """Set the heading of this body and of those placed next."""
        if not math.isfinite(degrees):
            return  # the values of a page are not trusted
        self._heading = math.radians(degrees)
        if self.label is not None:
            self._held_ghost.turn(self._heading)

    def hover(self, right: float, up: float) -> None:
        """Move the ghost to the pointer, given from the centre of the picture in half widths and half heights."""
        at = on_floor(*ray(self._client.camera, right, up))
        if at is not None:
            self._preview(*at)

    def put(self, x: float, y: float) -> None:
        """Request the body at a point, in metres."""
        if self.label is None:
            return
        self._preview(x, y)
        stem = PALETTE[self.label]
        name, run = self._free_name(stem), self._snapshot().run
        named = msgspec.structs.replace(robot(stem), name=name, format=None)
        request = Spawn(robot=named, position=position(x, y, self._heading))

        def placed(_: Result) -> None:
            self._held_ghost.clear()
            self._undo.push(run, "delete", Delete(agent=name))

        self._requests.ask("Not placed", "spawn", request, placed, self._held_ghost.mark_refused)

    def _preview(self, x: float, y: float) -> None:
        label = self.label
        if label is not None:
            self._held_ghost.hold(Ghost(robot(PALETTE[label]), x, y, self._heading, GHOST_COLOUR))

    def _free_name(self, stem: str) -> str:
        taken = {entity.name for entity in self._snapshot().entities}
        return next(name for number in range(1, 10_000) if (name := f"{stem}{number}") not in taken)
