"""The ghost that one browser drags or places, shown until the simulator has answered.

The page's messages move it in one thread and answers to requests change it in another; nothing here blocks.
"""

from __future__ import annotations

import dataclasses
import math
import threading
from typing import Any

import viser

from intellwheels_schemas.messages import Position
from intellwheels_viewer.drawings.ghosts import Ghost, Ghosts


class HeldGhost:
    """The ghost in one browser's scene, at most one.

    Args:
        scene: The scene of the browser.
    """

    def __init__(self, scene: viser.SceneApi) -> None:
        self._lock = threading.Lock()
        self._ghosts = Ghosts(scene)
        self._ghost: Ghost | None = None

    @property
    def ghost(self) -> Ghost | None:
        """The ghost, or None."""
        return self._ghost

    def hold(self, ghost: Ghost) -> None:
        """Show this ghost instead of the current one."""
        self._show(ghost)

    def clear(self, *_: object) -> None:
        """Remove the ghost. Takes, and ignores, the answer to a request."""
        self._show(None)

    def turn(self, heading: float) -> None:
        """Set the heading of the ghost, in radians."""
        self._change(heading=heading)

    def mark_refused(self, *_: object) -> None:
        """Draw the ghost in red, because the simulator refused its pose."""
        self._change(refused=True)

    def _change(self, **changes: Any) -> None:
        with self._lock:
            if self._ghost is not None:
                self._ghost = dataclasses.replace(self._ghost, **changes)
                self._ghosts.show({"hand": self._ghost})

    def _show(self, ghost: Ghost | None) -> None:
        with self._lock:
            self._ghost = ghost
            self._ghosts.show({} if ghost is None else {"hand": ghost})


def position(x: float, y: float, heading: float) -> Position:
    """Return a pose for a request, its heading normalised to (-pi, pi]."""
    turned = math.remainder(heading, math.tau)
    return Position(x=x, y=y, heading=math.pi if turned <= -math.pi else turned)
