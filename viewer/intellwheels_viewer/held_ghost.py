"""What one browser holds over the floor: a ghost, until it is let go and the simulator has answered.

The page's messages move it in one thread and the answers to its wishes in another: nothing here waits for either.
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
    """The ghost in one browser's scene; there is one at most.

    Args:
        scene: The browser's own.
    """

    def __init__(self, scene: viser.SceneApi) -> None:
        self._lock = threading.Lock()
        self._ghosts = Ghosts(scene)
        self._ghost: Ghost | None = None

    @property
    def ghost(self) -> Ghost | None:
        """What is held, None when nothing is."""
        return self._ghost

    def hold(self, ghost: Ghost) -> None:
        """Show this ghost and no other."""
        self._show(ghost)

    def let_go(self, *_: object) -> None:
        """Show none. It takes, and ignores, what an answer to a wish brings."""
        self._show(None)

    def turn(self, heading: float) -> None:
        """Turn what is held to a heading, in radians."""
        self._change(heading=heading)

    def redden(self, *_: object) -> None:
        """Say of what is held that it may not stand there."""
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
    """Return a pose as a wish has it: its heading, in radians, is brought into (-pi, pi]."""
    turned = math.remainder(heading, math.tau)
    return Position(x=x, y=y, heading=math.pi if turned <= -math.pi else turned)
