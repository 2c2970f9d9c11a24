"""What a browser may do by how it has come: the proxy's word for its user, and whether it is a browser at all. Pure."""

from __future__ import annotations

import datetime
from collections.abc import Mapping
from dataclasses import dataclass

from intellwheels_schemas.lab_rules import has_expired
from intellwheels_schemas.messages import Lab
from intellwheels_viewer.page_rights import PageRights


@dataclass(frozen=True)
class Door:
    """Whom the page lets do more than look.

    Attributes:
        wide: Whether other machines can reach the page.
        programs: Whether a program that sends no `Origin` may steer, though other machines can reach the page.
        user_header: The header in which the proxy names the user, in lower case; empty without users.
        lab: What each user may do; None without users.
    """

    wide: bool = False
    programs: bool = False
    user_header: str = ""
    lab: Lab | None = None

    @property
    def warning(self) -> str:
        """What the viewer says at every start if other machines reach its page without a login; empty otherwise."""
        if not self.wide or self.user_header:
            return ""
        return "open: other machines reach the page without a login; viewer/PROXY.md shows a proxy that has one"

    def rights(self, headers: Mapping[str, str], today: datetime.date | None = None) -> PageRights:
        """Return the rights of a browser.

        Args:
            headers: The headers of its request, with names in lower case.
            today: The day in UTC; None for that of this machine's clock.
        """
        if self.wide and not self.programs and "origin" not in headers:
            return PageRights("a program that sends no Origin may not steer; see --allow-programs")
        if not self.user_header:
            return PageRights()
        name = headers.get(self.user_header, "")
        if not name:
            return PageRights(f"the proxy named no user in {self.user_header}")
        for identity in () if self.lab is None else self.lab.identity:
            if identity.name == name and has_expired(identity, today or datetime.datetime.now(datetime.UTC).date()):
                return PageRights(f"{name} expired after {identity.until}")
            if identity.name == name:
                return PageRights(holders=(identity,))
        return PageRights(f"{name[:40]} is not in the lab's document")
