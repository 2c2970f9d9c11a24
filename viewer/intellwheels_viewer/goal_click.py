"""A goal by a click: "go there", for bodies whose mind declares that it takes goals, and for no others.

A goal is told once. The simulator keeps it for the mind when the user falls silent.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import viser

from intellwheels_schemas.messages import Goal
from intellwheels_viewer.clicks import FloorClicks

if TYPE_CHECKING:
    from intellwheels_viewer.snapshot import Snapshot
    from intellwheels_viewer.steering import Driving


def takes_goals(seen: Snapshot, name: str | None) -> bool:
    """Return whether an agent is there, not in a log only, and goes where it is told."""
    body = None if name is None else seen.bodies.get(name)
    return body is not None and seen.last_tick is None and "goal" in body.robot.user_input


class GoalClick:
    """The click of one browser that is awaited as a goal.

    Args:
        client: The browser.
        driving: The browser's hand on bodies: it tells goals.
        notify: Gets title and text for the user.
    """

    def __init__(self, client: viser.ClientHandle, driving: Driving, notify: Callable[[str, str], None]) -> None:
        self._driving, self._notify = driving, notify
        self._agent: str | None = None
        self._clicks = FloorClicks(client.scene, self.put)

    def begin(self, seen: Snapshot, name: str | None) -> None:
        """Await a click as the goal of an agent, or say why not."""
        if name is None or name not in seen.bodies:
            self._notify("No goal set", "Nothing selected: click a chair first.")
        elif not takes_goals(seen, name):
            self._notify("No goal set", f"The mind of {name} takes no goals.")
        else:
            self._agent = name
            self._clicks.listen(True)
            self._notify("Click the floor", f"Where shall {name} go?")

    def end(self) -> None:
        """Await none."""
        self._agent = None
        self._clicks.listen(False)

    def put(self, x: float, y: float) -> None:
        """Take a point of the floor as the goal."""
        agent = self._agent
        self.end()
        if agent is not None:
            self._driving.go(agent, Goal(x=x, y=y))
