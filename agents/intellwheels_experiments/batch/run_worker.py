"""A row's simulator and cast, kept alive from run to run: each begins by a reset with its own seed.

Once the cast is there the world is paused, and again at the end of each run: so every run begins alike, the first too.
A row with bridges has a second world, the laboratory, which plays the building; the two go tick by tick, so they are
paused, reset and resumed together. The laboratory says when a run is over, as its chairs are truly there; the world
that shows them ends by time alone, and begins anew once more at the end, which completes its files.
"""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Final, Self

from intellwheels_experiments.batch.experiment_rows import Row
from intellwheels_experiments.run.child_processes import ChildProcesses, Exited, Line
from intellwheels_experiments.run.launch_spec import (
    DEADLINE,
    LAB,
    LABORATORY,
    SERVER,
    agent_child,
    agent_command,
    bridge_child,
    bridge_command,
    laboratory_words,
    link_words,
    mind_command,
    parse,
    resolved,
)
from intellwheels_experiments.run.run_processes import free_port
from intellwheels_experiments.run.world_watch import WorldWatch, watching
from intellwheels_schemas.keys import Verb
from intellwheels_schemas.link import Link
from intellwheels_schemas.messages import Cast, End, Pause, Record, Reset, Resume

READY_LIMIT: Final = 180.0
"""Seconds for the simulator to be ready: a first start compiles its kernels, on a small machine slowly."""
JOIN_LIMIT: Final = 90.0
"""Seconds for the cast to join, and for a run to begin: the machine is full of runs."""
ANSWER_LIMIT: Final = 20.0
"""Seconds for the simulator to answer a verb."""
WORLD: Final = "main"


class RunWorkerError(RuntimeError):
    """A run came to no end, and its stand is of no further use; the text says why."""


class StoppedError(RuntimeError):
    """Told to stop."""


@dataclass(frozen=True, kw_only=True)
class Branch:
    """A run to begin as.

    Attributes:
        log: Its input log, of the world that its chair was truly in.
        at: The tick up to which it is followed.
        image: Of a chair in a laboratory, the log of the world that showed it.
    """

    log: Path
    at: int
    image: Path | None = None

    def words(self, *, of_image: bool) -> list[str]:
        """Return how a simulator is told."""
        log = self.image if of_image and self.image is not None else self.log
        return ["--branch", str(log.absolute()), "--at", str(self.at)]


@dataclass(frozen=True, kw_only=True)
class Site:
    """Where and how stands are put up.

    Attributes:
        source: The scene, a name or a path, as the simulator is told it.
        folder: Where relative paths in it start from, or None for a shipped scene.
        logs: A folder for the processes' logs.
        runs: A folder for what the simulator writes of each run.
        timeout: Seconds of wall time a run may take.
        branch: Each run begins as that one went.
    """

    source: str
    folder: Path | None
    logs: Path
    runs: Path
    timeout: float
    branch: Branch | None = None


class RunWorker:
    """A simulator and the cast of a row. To be used in a `with`, which ends them all.

    Args:
        site: Where.
        row: Which row.
        stop: Set from outside to give up.
    """

    def __init__(self, site: Site, row: Row, stop: threading.Event) -> None:
        self._site = site
        self._row = row
        self._stop = stop
        self._stack = ExitStack()
        self._children = self._stack.enter_context(ChildProcesses(site.logs))
        self._watches: dict[str, WorldWatch] = {}
        self._endpoints: dict[str, str] = {}
        self._said: dict[str, list[tuple[str, str | None]]] = {SERVER: [], LABORATORY: []}

    def __enter__(self) -> Self:
        try:
            self._begin()
        except BaseException:
            self._stack.close()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End the processes: the agents first, which leave in words."""
        living = self._children.living
        self._children.end([child for child in living if child not in self._servers], grace=2.0)
        self._stack.close()

    def run(self, seed: str) -> tuple[Path, Path | None]:
        """Run the scene with a seed to its end.

        Returns:
            The folders of what the simulators wrote of it: of the world that its chair was truly in, and, of a row
            with bridges, of the one that showed it.

        Raises:
            StandError: It came to no end.
            StoppedError: Told to stop.
        """
        deadline = time.monotonic() + self._site.timeout
        shown = self._reset(SERVER, seed)
        truth = self._reset(LABORATORY, seed) if self._row.bridges else shown
        for server in self._servers:
            self._ask(server, "resume", Resume())
        self._await(self._servers[-1], "ended", max(1.0, deadline - time.monotonic()), run=truth)
        self._pause()
        if self._row.bridges:
            self._reset(SERVER, seed)
        runs = self._site.runs
        return runs / truth, runs / shown if self._row.bridges else None

    @property
    def _servers(self) -> tuple[str, ...]:
        """The simulators, the one that tells the truth last."""
        return (SERVER, LABORATORY) if self._row.bridges else (SERVER,)

    def _begin(self) -> None:
        for server, world in zip(self._servers, (WORLD, LAB), strict=False):
            self._endpoints[server] = f"tcp/127.0.0.1:{free_port()}"
            self._children.start(server, partial(self._server_command, server, world))
            # One after the other: a first start compiles the kernels, which the second one then finds.
            self._await(server, "ready", READY_LIMIT)
            link = Link(world, connect=(self._endpoints[server],))
            try:
                self._watches[server] = self._stack.enter_context(watching(link, self._stop, listens=False))
            except ConnectionError as error:
                raise StoppedError from error if self._stop.is_set() else RunWorkerError(str(error))
        for cast in self._row.scene.cast:
            if cast.name in self._row.bridges:
                self._children.start(bridge_child(cast.name), partial(self._bridge_command, cast))
            self._children.start(agent_child(cast.name), partial(self._agent_command, cast))
        for server in self._servers:
            self._await(server, "running", JOIN_LIMIT)
        self._pause()

    def _pause(self) -> None:
        for server in self._servers:
            self._ask(server, "pause", Pause())

    def _reset(self, server: str, seed: str) -> str:
        """Begin a world anew and return its run."""
        end = self._row.scene.end
        if self._row.bridges and server == SERVER:
            end = End(timeout=end.timeout) if end is not None else None
        run = self._ask(server, "reset", Reset(seed=seed, end=end))
        self._await(server, "running", JOIN_LIMIT, run=run)
        return run

    def _server_command(self, server: str, world: str, lifeline: int) -> list[str]:
        site, row = self._site, self._row
        words = [*link_words(world, [self._endpoints[server]]), "--pace", "lockstep", "--miss", "strict"]
        words += ["--deadline", f"{DEADLINE:g}", "--runs", str(site.runs.absolute())]
        if server == LABORATORY and site.branch is None:
            words += laboratory_words(row.scene, row.bridges, site.folder)
        elif server == LABORATORY:
            words += ["--expect", ",".join(row.bridges), "--hide-truth"]
        else:
            words += ["--expect", ",".join(cast.name for cast in row.scene.cast)]
            if site.branch is None:
                words += ["--scene", resolved(site.source, site.folder), *row.words]
        if site.branch is not None:
            words += site.branch.words(of_image=server == SERVER and bool(row.bridges))
        return [sys.executable, "-m", "intellwheels_server", *words, "--lifeline", str(lifeline)]

    def _words(self, lifeline: int) -> list[str]:
        words = link_words(WORLD, (), [self._endpoints[SERVER]])
        return [*words, "--retry-for", f"{JOIN_LIMIT:g}", "--lifeline", str(lifeline)]

    def _agent_command(self, cast: Cast, lifeline: int) -> list[str]:
        told = mind_command if cast.name in self._row.bridges else agent_command
        return told(cast, self._site.folder, self._words(lifeline))

    def _bridge_command(self, cast: Cast, lifeline: int) -> list[str]:
        laboratory, words = (LAB, self._endpoints[LABORATORY]), self._words(lifeline)
        return bridge_command(cast, self._row.bridges[cast.name], self._site.folder, laboratory, words)

    def _ask(self, server: str, verb: Verb, message: Record) -> str:
        """Ask for a verb and return the run it is of then."""
        try:
            result = self._watches[server].control(verb, message, ANSWER_LIMIT)
        except ConnectionError as error:
            # The reason may be on its way.
            self._hear(server, 0.5, lambda _verb, _run: False)
            raise RunWorkerError(f"{server}: no answer to {verb}: {error}") from error
        if result.code != "ok" or result.run is None:
            raise RunWorkerError(f"{server}: {verb}: {result.text or result.code}")
        return result.run

    def _await(self, server: str, verb: str, limit: float, run: str | None = None) -> None:
        # A run before this one may have ended, too: a short one does before it can be paused.
        if not self._hear(server, limit, lambda said, of: said == verb and run in (None, of)):
            raise RunWorkerError(self._with_tail(server, f"did not say {verb!r} within {limit:.0f} s"))

    def _hear(self, server: str, limit: float, found: Callable[[str, str | None], bool]) -> bool:
        """Hear the processes until a simulator says something; return whether it did in time."""
        if (said := next((one for one in self._said[server] if found(*one)), None)) is not None:
            self._said[server].remove(said)
            return True
        deadline = time.monotonic() + limit
        while time.monotonic() < deadline:
            if self._stop.is_set():
                raise StoppedError
            match self._children.news(0.1):
                case Line(child=child, text=text) if child in self._servers:
                    verb, values = parse(text)
                    if verb in ("miss", "differs"):
                        who = agent_child(values["agent"]) if "agent" in values else child
                        raise RunWorkerError(self._with_tail(who, text))
                    of = values.get("run")
                    if child == server and found(verb, of):
                        return True
                    self._said[child].append((verb, of))
                case Exited(child=child) as exited:
                    raise RunWorkerError(self._with_tail(child, exited.how))
        return False

    def _with_tail(self, child: str, what: str) -> str:
        tail = [line for line in self._children.tail(child, 40) if not line.startswith("asked ")][-6:]
        return "\n  ".join([f"{child}: {what}", *tail])
