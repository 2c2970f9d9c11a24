"""Processes of a test on a world and a port of their own, and a peer that speaks raw bytes.

For tests of the service itself, which must see bytes and starts that fail; what tests an agent uses the fixture
`intellwheels`. Every wait has a deadline and is for something: a printed line, an event, a tick.
"""

from __future__ import annotations

import json
import os
import re
import select
import subprocess
import sys
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Self

import zenoh

from intellwheels_experiments.run.child_processes import DEADLINE, ChildProcesses
from intellwheels_experiments.run.endpoints import free_port
from intellwheels_schemas.keys import AGENT_VERBS

__all__ = ["DEADLINE", "JSON", "XML", "Peer", "Stage", "children_of", "free_port", "is_gone", "resident", "run"]

JSON = "application/json"
XML = "application/xml"


def is_gone(pid: int, within: float = 0.0) -> bool:
    """Return whether a process, anybody's child, ends within so many seconds."""
    try:
        descriptor = os.pidfd_open(pid)
    except ProcessLookupError:
        return True
    try:
        return bool(select.select([descriptor], [], [], within)[0])
    finally:
        os.close(descriptor)


def children_of(pid: int) -> list[int]:
    """Return the processes that a process started."""
    return [int(child) for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


def resident(pid: int) -> int:
    """Return a process's resident memory in bytes."""
    return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def run(module: str, *words: str, timeout: float = 120.0, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run a command of the project to its end."""
    return subprocess.run(
        [sys.executable, "-m", module, *words],
        capture_output=True,
        text=True,
        timeout=timeout,
        check=False,
        env={**os.environ, **environment},
    )


class Stage(ChildProcesses):
    """The processes of a test.

    Attributes:
        world: The world's name.
        endpoint: Where its simulator listens.
        simulator: The child that is the newest simulator.
        folder: For whatever files a test needs; the logs are in it.
    """

    def __init__(self, folder: Path, world: str) -> None:
        super().__init__(folder / "logs")
        self.folder = folder
        self.world = world
        self.endpoint = f"tcp/127.0.0.1:{free_port()}"
        self.simulator = "server"

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        # How they end in words is tested where it matters.
        self.close(grace=0.0)

    def server(self, *words: str, ready: bool = True) -> str:
        """Start a simulator, and wait until it is ready."""
        link = ["--listen", self.endpoint, "--world", self.world]
        # A shorter grace time than the default, for the sake of the tests that wait for its end.
        child = self.start("server", "intellwheels_server", *link, "--grace", "3", *words)
        self.simulator = child
        if ready:
            self.line(child, "ready")
        return child

    def agent(self, name: str, mind: str = "drive", *words: str, robot: str = "rear-wheel", joined: bool = True) -> str:
        """Start an agent, and wait until it joined."""
        child = self.start(
            name, "intellwheels_agents", mind, "--name", name, "--robot", robot,
            "--connect", self.endpoint, "--world", self.world, *words,
        )  # fmt: skip
        if joined:
            self.line(child, "joined")
        return child

    @contextmanager
    def peer(self) -> Iterator[Peer]:
        """Connect to the world with nothing of the project's own between."""
        config = zenoh.Config()
        for name, value in (
            ("mode", "client"),
            ("connect/endpoints", [self.endpoint]),
            ("scouting/multicast/enabled", False),
            ("scouting/gossip/enabled", False),
        ):
            config.insert_json5(name, json.dumps(value))
        with zenoh.open(config) as session:
            peer = Peer(self, session)
            try:
                yield peer
            finally:
                peer.close()


class Peer:
    """A raw peer: it puts and asks bytes, and keeps what it hears as plain JSON data."""

    def __init__(self, stage: Stage, session: zenoh.Session) -> None:
        self.stage = stage
        self.session = session
        self.prefix = f"iw/v1/{stage.world}/"
        self._heard: dict[str, deque[Any]] = {}
        self._subscribers: list[Any] = []
        self._events = self.hear("event")
        self._clocks = self.hear("clock", 1)
        self._states = self.hear("state/*", 50)

    def close(self) -> None:
        for subscriber in self._subscribers:
            subscriber.undeclare()

    def hear(self, key: str, keep: int = 20_000) -> deque[Any]:
        """Return what will arrive on a key from now on, as plain data, the newest last."""
        heard: deque[Any] = deque(maxlen=keep)

        def store(sample: zenoh.Sample) -> None:
            heard.append((str(sample.key_expr), bytes(sample.payload)))

        self._subscribers.append(self.session.declare_subscriber(self.prefix + key, store))
        return heard

    def put(self, key: str, payload: bytes | dict[str, Any], encoding: str = JSON) -> None:
        """Put bytes, or plain data as JSON."""
        data = payload if isinstance(payload, bytes) else json.dumps(payload).encode()
        self.session.put(self.prefix + key, data, encoding=encoding, congestion_control=zenoh.CongestionControl.BLOCK)

    def ask(self, key: str, payload: bytes | dict[str, Any] | None = None, encoding: str = JSON) -> list[Any]:
        """Query and return the replies as plain data; error replies too."""
        data = payload if payload is None or isinstance(payload, bytes) else json.dumps(payload).encode()
        replies = self.session.get(self.prefix + key, payload=data, encoding=encoding, timeout=DEADLINE)
        found = []
        for reply in replies:
            answer = reply.ok if reply.ok is not None else reply.err
            assert answer is not None
            found.append(json.loads(bytes(answer.payload)))
        return found

    def session_of(self, agent: str) -> str:
        """Wait for actions of an agent and return the session in them, as any stranger in an open world can."""
        heard = self.hear(f"in/{agent}/actions", 1)
        _, data = self.stage.wait(lambda: next(iter(heard), None), f"actions of {agent}", unless=self.stage.simulator)
        found = re.search(rb'Session(?:=|":)"([0-9a-f]{16})"', data)
        assert found is not None, data
        return found[1].decode()

    def ctl(self, verb: str, **fields: Any) -> dict[str, Any]:
        """Ask for a verb and return its result. `Agent` goes into the key of the verbs that are about one."""
        about = f"/{fields.pop('Agent')}" if verb in AGENT_VERBS else ""
        (result,) = self.ask(f"ctl/{verb}{about}", fields)
        assert isinstance(result, dict)
        return result

    def events(self) -> list[dict[str, Any]]:
        """Return all events the simulator keeps."""
        (events,) = self.ask("event")
        return list(events.get("Event", []))

    def event(self, code: str, agent: str | None = None, timeout: float = DEADLINE, since: int = 0) -> dict[str, Any]:
        """Wait for an event, also one that was; return the first from number `since` on."""

        def found() -> dict[str, Any] | None:
            for event in self.events():
                is_it = event["Code"] == code and (agent is None or event.get("Agent") == agent)
                if is_it and event["Number"] >= since:
                    return event
            return None

        return self.stage.wait(found, f"event {code} of {agent}", timeout, unless=self.stage.simulator)

    def clock(self) -> dict[str, Any]:
        """Wait for a clock from now on and return it."""
        self._clocks.clear()
        return dict(self.stage.wait(lambda: _newest(self._clocks), "clock", unless=self.stage.simulator))

    def tick(self, at_least: int) -> dict[str, Any]:
        """Wait until the run is so far; return the clock."""

        def found() -> dict[str, Any] | None:
            clock = _newest(self._clocks)
            return clock if clock and clock["Tick"] >= at_least else None

        return self.stage.wait(found, f"tick {at_least}", unless=self.stage.simulator)

    def ticks_on(self, ticks: int = 5) -> None:
        """Wait until the run went on by so many ticks."""
        self.tick(self.clock()["Tick"] + ticks)

    def entities(self) -> dict[str, dict[str, Any]]:
        """Return the true state of every body now."""
        return {entity["Name"]: entity for part in self.ask("state/*") for entity in part.get("Entity", [])}

    def entity(self, name: str, like: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
        """Wait until a body's state is like that; return it."""

        def found() -> dict[str, Any] | None:
            entity = self.entities().get(name)
            return entity if entity is not None and like(entity) else None

        return self.stage.wait(found, f"state of {name}", unless=self.stage.simulator)

    def errors(self, agent: str) -> deque[Any]:
        """Return the errors that will be sent to an agent from now on."""
        return self.hear(f"out/{agent}/error")

    def error(self, heard: deque[Any], code: str) -> dict[str, Any]:
        """Wait for an error with a code."""

        def found() -> dict[str, Any] | None:
            for _, data in list(heard):
                error = json.loads(data)
                if error["Code"] == code:
                    return dict(error)
            return None

        return self.stage.wait(found, f"error {code}", unless=self.stage.simulator)


def _newest(heard: Sequence[Any]) -> dict[str, Any] | None:
    return dict(json.loads(heard[-1][1])) if heard else None
