"""What a page does with the link by which its browser came: it selects, looks and, in a playback, goes to the tick."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from intellwheels_viewer.page_link import PageLink, link_of

if TYPE_CHECKING:
    from intellwheels_viewer.page import Page
    from intellwheels_viewer.snapshot import Snapshot


class PageArrival:
    """The link of one browser, used once: when there is a run with a map.

    Args:
        notify: Shows a notice: its title and its text.
    """

    def __init__(self, notify: Callable[[str, str], None]) -> None:
        self._notify = notify
        self._link: PageLink | None = None
        self._read = False

    def read(self, query: str) -> None:
        """Take the query of the page's address, the first time."""
        if self._read:
            return
        self._read = True
        link, wrong = link_of(query)
        if wrong:
            self._notify("Not all of the link is understood", "; ".join(wrong))
        if link != PageLink():
            self._link = link

    def arrive(self, page: Page, snapshot: Snapshot) -> None:
        """Show what the link says, if that has not been done."""
        link = self._link
        if link is None or snapshot.phase != "live" or snapshot.floor is None or not snapshot.entities:
            return
        self._link = None
        if link.agent is not None and snapshot.entity(link.agent) is None:
            self._notify("The link selects a body that is not here", link.agent)
        elif link.agent is not None:
            page.select(link.agent)
        if link.mode is not None:
            page.look(link.mode)
        if link.eye is not None and link.to is not None:
            page.camera.look_from(link.eye, link.to)
        if link.tick is not None and snapshot.last_tick is not None:
            page.seek(min(link.tick, snapshot.last_tick))
        elif link.tick is not None and link.tick != snapshot.tick:
            text = f"It shows tick {link.tick}. Only a playback (iw-server --play) can go back to a tick."
            self._notify("The link is of another moment", text)
