"""The title of the browser tab: the map, what of it is real, and the world, so that tabs can be told apart."""

from __future__ import annotations

import html
import json
from typing import TYPE_CHECKING, Final

import viser

if TYPE_CHECKING:
    from intellwheels_viewer.snapshot import Snapshot

APPLICATION: Final = "IntellWheels"


def title_of(snapshot: Snapshot) -> str:
    """Return the title for a snapshot: map, world and application, as far as they are known."""
    parts = []
    if snapshot.floor is not None and snapshot.phase in ("live", "silent", "gone"):
        parts.append(snapshot.floor.title or snapshot.floor.name)
        parts += reality(snapshot)
    if snapshot.world:
        parts.append(snapshot.world)
    return " \u2013 ".join([*parts, APPLICATION])


def reality(snapshot: Snapshot) -> list[str]:
    """Return how many chairs are real and how many virtual, such as "2 real, 2 virtual"; nothing if none is real."""
    chairs = [body.robot for body in snapshot.bodies.values() if body.robot.kind == "wheelchair"]
    real = [robot for robot in chairs if robot.type == "real"]
    if not real:
        return []
    simulated = " on simulated hardware" if all(robot.hardware == "simulated" for robot in real) else ""
    virtual = len(chairs) - len(real)
    return [f"{len(real)} real{simulated}" + (f", {virtual} virtual" if virtual else "")]


def script(title: str) -> str:
    """Return HTML that sets the title. The text of a peer is a JSON string in an escaped attribute."""
    code = f"document.title={json.dumps(title)}"
    return f'<img src="x:" alt="" style="display:none" onerror="{html.escape(code)}">'


class PageTitle:
    """The title of one browser's tab.

    Args:
        gui: Makes the element, in the open container.
    """

    def __init__(self, gui: viser.GuiApi) -> None:
        self._element = gui.add_html(script(APPLICATION))

    def show(self, snapshot: Snapshot) -> None:
        """Show the title of a snapshot; nothing is sent for an equal one."""
        self._element.content = script(title_of(snapshot))
