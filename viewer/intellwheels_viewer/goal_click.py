"""Setting a goal by a click, for bodies whose mind declares that it takes goals.

A goal is sent once. The simulator keeps it for the mind after the user's input has ended.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import viser

from intellwheels_schemas.messages import Goal, Map
from intellwheels_viewer.clicks import FloorClicks
from intellwheels_viewer.drawings.rooms import extent

if TYPE_CHECKING:
    from intellwheels_viewer.snapshot import Snapshot
    from intellwheels_viewer.steering import Driving


def takes_goals(snapshot: Snapshot, name: str | None) -> bool:
    """Return whether an agent is in a live run and takes goals."""
    body = None if name is None else snapshot.bodies.get(name)
    return body is not None and snapshot.last_tick is None and "goal" in body.robot.user_input


def is_on(floor: Map, x: float, y: float) -> bool:
    """Return whether a point, in metres, is within the extent of a map."""
    west, east, south, north = extent(floor)
    return west <= x <= east and south <= y <= north


class GoalClick:
    """Setting goals in one browser.

    Args:
        client: The browser.
        driving: Sends the goals.
        notify: Called with a title and a text for the user.
    """

    def __init__(self, client: viser.ClientHandle, driving: Driving, notify: Callable[[str, str], None]) -> None:
        self._driving, self._notify = driving, notify
        self._agent: str | None = None
        self._floor: Map | None = None
        self._clicks = FloorClicks(client.scene, self.put)

    def begin(self, snapshot: Snapshot, name: str | None) -> None:
        """Take the next click as the goal of an agent, or tell the user why not."""
        if name is None or name not in snapshot.bodies:
            self._notify("No goal set", "Nothing is selected. Click a chair first.")
        elif not takes_goals(snapshot, name):
            self._notify("No goal set", f"{name} does not take goals.")
        else:
            self._agent, self._floor = name, snapshot.floor
            self._clicks.listen(True)
            self._notify("Click the floor", f"The next click sets the goal of {name}.")

    def end(self) -> None:
        """Stop waiting for a click."""
        self._agent = None
        self._clicks.listen(False)

    def put(self, x: float, y: float) -> None:
        """Set the goal to a point, in metres. A point outside the map is refused, and the next click counts."""
        agent = self._agent
        if agent is not None and self._floor is not None and not is_on(self._floor, x, y):
            self._notify("No goal set", "This point is outside the map. Click another one, or press Escape.")
            return
        self.end()
        if agent is not None:
            self._driving.go(agent, Goal(x=x, y=y))
