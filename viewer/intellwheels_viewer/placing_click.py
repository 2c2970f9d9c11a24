"""Placing from the palette: a ghost stands under the pointer, and a click on the floor asks for the body.

What may not stand there turns red and is kept, to be placed elsewhere; a body is there when the state says so.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from typing import Final

import msgspec
import viser

from intellwheels_maps import robot
from intellwheels_schemas.messages import Spawn
from intellwheels_viewer.cameras import on_floor, ray
from intellwheels_viewer.clicks import FloorClicks
from intellwheels_viewer.drawings.ghosts import Ghost
from intellwheels_viewer.held_ghost import HeldGhost, position
from intellwheels_viewer.panels.place import PALETTE
from intellwheels_viewer.steering import Wishes

GHOST_COLOUR: Final = (90, 100, 115)


class PlacingClick:
    """What one browser places.

    Args:
        client: The browser.
        wishes: Where bodies are asked for.
        hand: Holds the ghost.
        names: Returns the names that are taken.

    Attributes:
        label: Of the palette; None while nothing is placed.
    """

    def __init__(
        self, client: viser.ClientHandle, wishes: Wishes, hand: HeldGhost, names: Callable[[], Collection[str]]
    ) -> None:
        self._client, self._wishes, self._hand, self._names = client, wishes, hand, names
        self.label: str | None = None
        self._heading = 0.0
        self._clicks = FloorClicks(client.scene, self.put)

    def choose(self, label: str | None) -> None:
        """Begin to place what a label of the palette names; anything else ends it."""
        self.label = label if label in PALETTE else None
        self._clicks.listen(self.label is not None)
        if self.label is None:
            self._hand.let_go()
            return
        look_at = self._client.camera.look_at
        self._preview(float(look_at[0]), float(look_at[1]))

    def turn(self, degrees: float) -> None:
        """Turn what is placed, this and those to come, to a heading."""
        if not math.isfinite(degrees):
            return  # a page's values are a stranger's
        self._heading = math.radians(degrees)
        if self.label is not None:
            self._hand.turn(self._heading)

    def hover(self, right: float, up: float) -> None:
        """Move the ghost under the pointer, which is so far from the middle of the picture, each in [-1, 1]."""
        at = on_floor(*ray(self._client.camera, right, up))
        if at is not None:
            self._preview(*at)

    def put(self, x: float, y: float) -> None:
        """Ask for what is placed to stand at a point."""
        if self.label is None:
            return
        self._preview(x, y)
        stem = PALETTE[self.label]
        named = msgspec.structs.replace(robot(stem), name=self._free_name(stem), format=None)
        wish = Spawn(robot=named, position=position(x, y, self._heading))
        self._wishes.ask("Not placed", "spawn", wish, self._hand.let_go, self._hand.redden)

    def _preview(self, x: float, y: float) -> None:
        label = self.label
        if label is not None:
            self._hand.hold(Ghost(robot(PALETTE[label]), x, y, self._heading, GHOST_COLOUR))

    def _free_name(self, stem: str) -> str:
        taken = self._names()
        return next(name for number in range(1, 10_000) if (name := f"{stem}{number}") not in taken)
