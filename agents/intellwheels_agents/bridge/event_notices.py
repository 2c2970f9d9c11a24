"""Lines that a bridge prints about events of its chair: taken, removed, replaced, left and so on. Pure.

simulator-gone, simulator-back     the simulator's token went or came back
removed ... reason=...             the body was taken out: deleted by an operator, left, or lost for too long
replaced ... owner=...             another process is the body now
taken, released                    an operator began or stopped driving the chair
mind-joined, mind-left, mind-lost, mind-returned    the program that drives the chair
body-lost, body-returned           the simulator has lost or found this bridge
"""

from __future__ import annotations

from intellwheels_schemas.messages import Body, Event


class EventNotices:
    """Turns messages about one chair into lines for scripts."""

    def __init__(self, agent: str, instance: str) -> None:
        """Create it without any history.

        Args:
            agent: The name of the chair.
            instance: The instance with which this bridge joins as its body.
        """
        self._agent = agent
        self._instance = instance
        self._owner = instance
        self._is_gone = False

    def renew(self, instance: str) -> None:
        """Take note that this bridge joins with another instance from now on."""
        self._instance = self._owner = instance

    def presence(self, alive: bool) -> str | None:
        """Return the line for the coming or going of the simulator, or None for the first coming."""
        if alive == (not self._is_gone):
            return None
        self._is_gone = not alive
        return f"simulator-{'back' if alive else 'gone'} agent={self._agent}"

    def event(self, event: Event) -> str | None:
        """Return the line for an event, or None when it does not concern this chair."""
        if event.agent != self._agent:
            return None
        where = f"agent={self._agent} tick={event.tick}"
        match event.code, event.text:
            case "deleted" | "left" | "lost", None:
                return f"removed {where} reason={event.code}"
            case "taken" | "released", _:
                return f"{event.code} {where}"
            case "joined" | "left" | "lost" | "returned", "mind":
                return f"mind-{event.code} {where}"
            case "lost" | "returned", "body":
                return f"body-{event.code} {where}"
        return None

    def body(self, body: Body) -> str | None:
        """Return the line for another owner of the body, or None if the owner is this bridge or there is none."""
        owner = body.owner or self._instance
        if owner == self._owner:
            return None
        self._owner = owner
        return None if owner == self._instance else f"replaced agent={self._agent} owner={owner}"
