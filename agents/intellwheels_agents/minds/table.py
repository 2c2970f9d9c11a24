"""A table, or any other obstacle: it does nothing, but answers every tick, so that lockstep can wait for it."""

from __future__ import annotations

from intellwheels_agents.mind import Context
from intellwheels_schemas.messages import Actions, Measures

_NOTHING = Actions()


class Mind:
    """Does nothing."""

    def __init__(self, _context: Context) -> None:
        pass

    def decide(self, _measures: Measures) -> Actions:
        """Return empty actions."""
        return _NOTHING
