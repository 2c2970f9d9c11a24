"""The title of the browser tab: the map, what of it is real, and the world, so that tabs can be told apart."""

from __future__ import annotations

import html
import json
from collections import Counter
from typing import TYPE_CHECKING, Final

import viser

from intellwheels_viewer.drivers import reality_of

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
    """Return how many chairs are real, stand-ins and virtual, such as "2 real, 2 virtual"; nothing if all are virtual.

    A stand-in for a real chair joins through a real chair's bridge, but its hardware is simulated.
    """
    chairs = Counter(reality_of(body.robot) for body in snapshot.bodies.values() if body.robot.kind == "wheelchair")
    real, acted, virtual = chairs["real"], chairs["stand-in"], chairs["simulated"]
    if not real + acted:
        return []
    stand_ins = f"{acted} stand-ins for real chairs" if acted > 1 else f"{acted} stand-in for a real chair"
    said = ((real, f"{real} real"), (acted, stand_ins), (virtual, f"{virtual} virtual"))
    return [", ".join(words for count, words in said if count)]


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
