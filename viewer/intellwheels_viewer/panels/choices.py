"""The choices of one browser: together with the snapshot, everything that a panel shows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from intellwheels_schemas.agent_colours import Look
from intellwheels_viewer.page_rights import EVERYTHING, PageRights


@dataclass(frozen=True)
class Choices:
    """The state of one browser.

    Attributes:
        selected: The selected agent; it may have left.
        looks: The colour and the stripes of each body.
        rights: What this page may do, and why it may not do the rest.
        driven: The agent that this page drives now.
        placing: The label of the thing that the next click on the floor places, see `place.PALETTE`.
        can_undo: Whether a change can be undone.
        quiet: Seconds of wall time since the last clock.
    """

    selected: str | None = None
    looks: Mapping[str, Look] = field(default_factory=dict)
    rights: PageRights = EVERYTHING
    driven: str | None = None
    placing: str | None = None
    can_undo: bool = False
    quiet: float = 3.0
