"""The link as one page uses it: requests that the page may not make end here.

A hidden or disabled control still answers a message that somebody made by hand.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from intellwheels_schemas.keys import AGENT_VERBS, Verb
from intellwheels_schemas.messages import Record, Result, UserInput
from intellwheels_viewer.page_rights import PageRights
from intellwheels_viewer.steering import VIEW_ONLY, Refusal, Simulator


class Worlds(Simulator, Protocol):
    """The link, as a page uses it."""

    @property
    def world(self) -> str:
        """The world that is shown; empty while there is none."""

    @property
    def quiet(self) -> float:
        """Seconds since the last clock."""

    def choose(self, world: str) -> None:
        """Show another world."""

    def note_speech(self, text: str, to: str | None) -> None:
        """Show a message of a user to an agent, or to everybody with None."""


class LimitedWorlds:
    """Passes on what a page may do.

    Args:
        worlds: The link of all pages.
        rights: Returns what this page may do now.
    """

    def __init__(self, worlds: Worlds, rights: Callable[[], PageRights]) -> None:
        self._worlds, self._rights = worlds, rights

    @property
    def world(self) -> str:
        """The world that is shown; empty while there is none."""
        return self._worlds.world

    @property
    def quiet(self) -> float:
        """Seconds since the last clock."""
        return self._worlds.quiet

    def choose(self, world: str) -> None:
        """Show another world, in all pages, if this one may do more than look."""
        if not self._rights().looks_only:
            self._worlds.choose(world)

    def note_speech(self, text: str, to: str | None) -> None:
        """Show a message of a user to an agent, or to everybody with None."""
        self._worlds.note_speech(text, to)

    def ask(self, verb: Verb, request: Record) -> Result:
        """Return the answer. Blocks.

        Raises:
            Refusal: The page may not ask for it, or the simulator refused it.
        """
        agent = getattr(request, "agent", None) if verb in AGENT_VERBS else None
        if why := self._rights().why_not(self._worlds.world, verb, agent):
            raise Refusal(f"{VIEW_ONLY}: {why}")
        return self._worlds.ask(verb, request)

    def put_user(self, agent: str, request: UserInput) -> None:
        """Publish a user's input, if the page may drive the agent. Never blocks."""
        if not self._rights().why_not_drive(self._worlds.world, agent):
            self._worlds.put_user(agent, request)
