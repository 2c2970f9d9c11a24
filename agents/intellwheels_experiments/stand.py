"""A row's simulator and cast, kept alive from run to run: each begins by a reset with its own seed.

The world is paused before its cast joins, and again at the end of each run: so every run begins alike, the first too.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Final, Self

from intellwheels_experiments.children import Children, Exited, Line
from intellwheels_experiments.plan import SERVER, agent_child, agent_command, link_words, parse, resolved
from intellwheels_experiments.processes import free_port
from intellwheels_experiments.rows import Row
from intellwheels_experiments.watch import Watch, watching
from intellwheels_schemas.keys import Verb
from intellwheels_schemas.link import Link
from intellwheels_schemas.messages import Pause, Record, Reset, Resume

READY_LIMIT: Final = 180.0
"""Seconds for the simulator to be ready: a first start compiles its kernels, on a small machine slowly."""
JOIN_LIMIT: Final = 90.0
"""Seconds for the cast to join, and for a run to begin: the machine is full of runs."""
ANSWER_LIMIT: Final = 20.0
"""Seconds for the simulator to answer a verb."""
DEADLINE: Final = 60.0
"""Seconds the simulator waits for an answer before it ends the run."""
WORLD: Final = "main"


class StandError(RuntimeError):
    """A run came to no end, and its stand is of no further use; the text says why."""


class StoppedError(RuntimeError):
    """Told to stop."""


@dataclass(frozen=True, kw_only=True)
class Site:
    """Where and how stands are put up.

    Attributes:
        source: The scene, a name or a path, as the simulator is told it.
        folder: Where relative paths in it start from, or None for a shipped scene.
        logs: A folder for the processes' logs.
        runs: A folder for what the simulator writes of each run.
        timeout: Seconds of wall time a run may take.
        branch: A log and a tick: each run begins as that one went.
    """

    source: str
    folder: Path | None
    logs: Path
    runs: Path
    timeout: float
    branch: tuple[Path, int] | None = None


class Stand:
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
        self._children = self._stack.enter_context(Children(site.logs))
        self._watch: Watch | None = None

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
        self._children.end([child for child in living if child != SERVER], grace=2.0)
        self._stack.close()

    def run(self, seed: str) -> Path:
        """Run the scene with a seed to its end and return the folder of what the simulator wrote of it.

        Raises:
            StandError: It came to no end.
            StoppedError: Told to stop.
        """
        deadline = time.monotonic() + self._site.timeout
        run = self._ask("reset", Reset(seed=seed))
        self._await("running", JOIN_LIMIT)
        self._ask("resume", Resume())
        self._await("ended", max(1.0, deadline - time.monotonic()))
        self._ask("pause", Pause())
        return self._site.runs / run

    def _begin(self) -> None:
        site = self._site
        endpoint = f"tcp/127.0.0.1:{free_port()}"
        self._children.start(SERVER, partial(self._server_command, endpoint))
        self._await("ready", READY_LIMIT)
        link = Link(WORLD, connect=(endpoint,))
        try:
            self._watch = self._stack.enter_context(watching(link, self._stop, listens=False))
        except ConnectionError as error:
            raise StoppedError from error if self._stop.is_set() else StandError(str(error))
        self._ask("pause", Pause())
        words = [*link_words(WORLD, (), [endpoint]), "--retry-for", f"{JOIN_LIMIT:g}"]
        for cast in self._row.scene.cast:
            self._children.start(
                agent_child(cast.name),
                lambda lifeline, cast=cast: agent_command(  # type: ignore[misc]
                    cast, site.folder, [*words, "--lifeline", str(lifeline)]
                ),
            )
        self._await("running", JOIN_LIMIT)

    def _server_command(self, endpoint: str, lifeline: int) -> list[str]:
        from sys import executable  # noqa: PLC0415 - read here, as tests put another in its place

        site = self._site
        words = [
            *link_words(WORLD, [endpoint]),
            "--pace",
            "lockstep",
            "--miss",
            "strict",
            "--deadline",
            f"{DEADLINE:g}",
        ]
        words += ["--expect", ",".join(cast.name for cast in self._row.scene.cast), "--runs", str(site.runs.absolute())]
        if site.branch is None:
            words += ["--scene", resolved(site.source, site.folder), *self._row.words]
        else:
            words += ["--branch", str(site.branch[0].absolute()), "--at", str(site.branch[1])]
        return [executable, "-m", "intellwheels_server", *words, "--lifeline", str(lifeline)]

    def _ask(self, verb: Verb, message: Record) -> str:
        """Ask for a verb and return the run it is of then."""
        assert self._watch is not None  # noqa: S101 - `_begin` came before
        try:
            result = self._watch.control(verb, message, ANSWER_LIMIT)
        except ConnectionError as error:
            self._hear(0.5, lambda _verb: False)
            raise StandError(f"{SERVER}: no answer to {verb}: {error}") from error
        if result.code != "ok" or result.run is None:
            raise StandError(f"{SERVER}: {verb}: {result.text or result.code}")
        return result.run

    def _await(self, verb: str, limit: float) -> None:
        if not self._hear(limit, lambda said: said == verb):
            raise StandError(self._with_tail(SERVER, f"did not say {verb!r} within {limit:.0f} s"))

    def _hear(self, limit: float, found: Callable[[str], bool]) -> bool:
        """Hear the processes until the simulator says something; return whether it did in time."""
        deadline = time.monotonic() + limit
        while time.monotonic() < deadline:
            if self._stop.is_set():
                raise StoppedError
            match self._children.news(0.1):
                case Line(child=child, text=text) if child == SERVER:
                    verb, values = parse(text)
                    if verb in ("miss", "differs"):
                        who = agent_child(values["agent"]) if "agent" in values else SERVER
                        raise StandError(self._with_tail(who, text))
                    if found(verb):
                        return True
                case Exited(child=child) as exited:
                    raise StandError(self._with_tail(child, exited.how))
        return False

    def _with_tail(self, child: str, what: str) -> str:
        tail = [line for line in self._children.tail(child, 40) if not line.startswith("asked ")][-6:]
        return "\n  ".join([f"{child}: {what}", *tail])
