"""A page with a browser that is nothing but its socket, and a simulator that keeps what it is asked."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import viser

from intellwheels_schemas.keys import Verb
from intellwheels_schemas.messages import Record, Result, UserInput
from intellwheels_viewer.page import Page
from intellwheels_viewer.palette import Colours
from intellwheels_viewer.snapshot import Snapshot
from intellwheels_viewer.steering import Refusal
from tests.viewer.browser import Browser
from tests.viewer.panels import made_up
from tests.viewer.wire import body, entity, until

SNAPSHOT = replace(
    made_up.snapshot(), entities=(entity("a", 1.0, 1.0), entity("b", 4.0, 1.0)), bodies={"a": body("a"), "b": body("b")}
)


class Network:
    """Keeps what it is asked, and grants it or not."""

    def __init__(self) -> None:
        self.asked: list[tuple[Verb, Record]] = []
        self.puts: list[tuple[str, UserInput]] = []
        self.worlds: list[str] = []
        self.speech: list[tuple[str, str | None]] = []
        self.refuses = ""
        self.quiet = 0.0
        self.world = "main"

    def ask(self, verb: Verb, request: Record) -> Result:
        self.asked.append((verb, request))
        if self.refuses:
            raise Refusal(self.refuses)
        return Result(code="ok", lease="0" * 16)

    def put_user(self, agent: str, request: UserInput) -> None:
        self.puts.append((agent, request))

    def note_speech(self, text: str, to: str | None) -> None:
        self.speech.append((text, to))

    def choose(self, world: str) -> None:
        self.worlds.append(world)

    def wished(self) -> Record:
        """Wait for the newest wish."""
        until(lambda: self.asked)
        return self.asked[-1][1]


class Opened:
    """A page with its browser."""

    def __init__(self, server: viser.ViserServer, browser: Browser) -> None:
        self.network, self.browser = Network(), browser
        (client,) = until(lambda: list(server.get_clients().values()))
        self.client = client
        self.page = Page(client, cast(Any, self.network), Colours())
        self.show(SNAPSHOT)

    def show(self, snapshot: Snapshot) -> None:
        self.page.draw(snapshot)
        self.page.panels(snapshot)

    def drag(self, name: str, *steps: tuple[str, tuple[float, float]]) -> None:
        """Drag a body from where it stands."""
        stood = SNAPSHOT.entity(name)
        assert stood is not None
        for phase, (x, y) in steps:
            event = SimpleNamespace(phase=phase, start_position=(stood.x, stood.y, 0.0), end_position=(x, y, 0.0))
            self.page.drag(name, cast(Any, event))

    def ghost(self) -> bool:
        return self.page._held_ghost.ghost is not None
