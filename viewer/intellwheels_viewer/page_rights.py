"""What one page may do, and why it may not do the rest. Pure.

Several things limit a page: the router's rules for the viewer, the lab's document for the browser's user, and how the
browser has reached the page.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

from intellwheels_schemas.keys import AGENT_VERBS, VERBS, Keys, Verb
from intellwheels_schemas.messages import Identity
from intellwheels_schemas.names import is_name
from intellwheels_schemas.rights import denial

_VERBS: Final[tuple[Verb, ...]] = tuple(VERBS.values())


@dataclass(frozen=True)
class PageRights:
    """The rights of one page.

    Attributes:
        looks_only: Why the page may only look, in words; empty if it may do more.
        holders: Those whose rights limit it. Without any, the page may do everything.
    """

    looks_only: str = ""
    holders: tuple[Identity, ...] = ()

    def limited_by(self, who: Identity) -> PageRights:
        """Return the rights that are left if another's limit them too."""
        return replace(self, holders=(*self.holders, who))

    def why_not(self, world: str, verb: Verb, agent: str | None = None) -> str:
        """Return why the page may not ask for a control verb; empty if it may.

        Args:
            world: The world that is shown; while it is empty, nothing can be said.
            verb: The verb.
            agent: The agent that the verb is about. Without it, a verb about an agent is not refused.
        """
        # A page can send any text as its selection.
        known = (verb not in AGENT_VERBS) if agent is None else is_name(agent)
        if self.looks_only or not is_name(world) or not known:
            return self.looks_only
        key = Keys(world).ctl(verb, agent)
        return next((why for who in self.holders if (why := denial(who, key))), "")

    def why_not_any(self, world: str, verbs: Sequence[Verb]) -> str:
        """Return which of these verbs the page may not ask for; empty if it may ask for all."""
        if self.looks_only or not is_name(world):
            return self.looks_only
        keys = Keys(world)
        for who in self.holders:
            lacking = [f"ctl/{verb}" for verb in verbs if verb not in AGENT_VERBS and denial(who, keys.ctl(verb))]
            if lacking:
                return f"{who.name} may not ask for {', '.join(lacking)} in world {world}"
        return ""

    def why_not_drive(self, world: str, agent: str | None) -> str:
        """Return why the page may not drive an agent; empty if it may."""
        if self.looks_only or not is_name(world) or agent is None or not is_name(agent):
            return self.looks_only
        keys = Keys(world)
        for who in self.holders:
            why = denial(who, keys.user(agent), "put") or denial(who, keys.ctl("take", agent))
            if why:
                return why
        return ""

    def why_not_see(self, world: str) -> str:
        """Return why the page may not show a world; empty if it may."""
        if not is_name(world):
            return ""
        keys = Keys(world)
        return next((why for who in self.holders if (why := denial(who, keys.every_state, "read"))), "")

    def where_to_look(self) -> str:
        """Return which worlds the page may show, for people; empty if nothing limits it."""
        lines = []
        for who in self.holders:
            worlds = sorted({may.world for may in who.may if not denial(who, Keys(may.world).every_state, "read")})
            lines.append(f"{who.name} may look at {', '.join(worlds) or 'no world'}")
        return ". ".join(lines)

    def why_not_place(self, world: str, agent: str | None) -> str:
        """Return why the page may neither place a thing nor change the selected body; empty if it may do either."""
        verbs: tuple[Verb, ...] = ("spawn", "teleport", "delete")
        reasons = [self.why_not(world, verb, agent if verb in AGENT_VERBS else None) for verb in verbs]
        return reasons[0] if all(reasons) or agent is None else ""

    def summary(self, world: str) -> str:
        """Return what the page may do, for people; empty if it may do everything."""
        if self.looks_only or not is_name(world):
            return f"View only: {self.looks_only}" if self.looks_only else ""
        return ". ".join(_summary(who, world) for who in self.holders)


def _summary(who: Identity, world: str) -> str:
    steers = [may for may in who.may if may.world == world and may.role in ("operator", "viewer")]
    agents = dict.fromkeys("every agent" if name == "*" else name for may in steers for name in may.agents)
    keys = Keys(world)
    words = [verb for verb in _VERBS if verb not in AGENT_VERBS and not denial(who, keys.ctl(verb))]
    done = [*words, f"steer {', '.join(agents)}"] if agents else list(words)
    return f"As {who.name} this page may {', '.join(done)}" if done else f"View only: {who.name} may only look"


EVERYTHING: Final = PageRights()
"""The rights of a page that nothing limits."""
