"""Runs one row of an experiment again and again: its simulator and agents stay alive, and a reset starts each run.

The world is paused as soon as the agents have joined, and again at the end of each run. So every run starts from the
same situation, the first one too.

A row with bridges has a second world, the laboratory, which represents the real building. The two worlds advance
together, tick by tick, so they are paused, reset and resumed together. The laboratory decides when a run is over,
because its chairs are at their true poses. The mirror, which is the world that shows the chairs at the poses that their
bridges report, ends at the timeout only. It is reset once more after the run, which completes its files.
"""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Final, NamedTuple, NoReturn, Self

from intellwheels_experiments.batch.experiment_rows import Row
from intellwheels_experiments.run.child_processes import READY_LIMIT, ChildProcesses, WaitError
from intellwheels_experiments.run.endpoints import free_endpoint
from intellwheels_experiments.run.foreign_program import launch_agent
from intellwheels_experiments.run.launch_spec import (
    ANSWER_DEADLINE,
    LAB,
    LABORATORY,
    SERVER,
    agent_command,
    bridge_child,
    bridge_command,
    laboratory_arguments,
    link_arguments,
    mind_command,
    resolved,
)
from intellwheels_experiments.run.program_restarts import ProgramRestarts
from intellwheels_experiments.run.start_watch import await_ready
from intellwheels_experiments.run.world_watch import WorldWatch, watching
from intellwheels_maps import floor
from intellwheels_maps.cast_places import cast_places
from intellwheels_schemas import defaults
from intellwheels_schemas.keys import Verb
from intellwheels_schemas.link import Link
from intellwheels_schemas.messages import Cast, Delete, End, Pause, Record, Reset, Resume

JOIN_LIMIT: Final = 90.0
"""Seconds for the agents to join, and for a run to start: other runs keep the machine busy."""
CONTROL_LIMIT: Final = 20.0
"""Seconds for the simulator to answer a control verb."""
INTERVAL: Final = 0.1
"""Seconds between two checks whether the batch was stopped."""
LAST_WORDS: Final = 0.5
"""Seconds to wait for the reason that a simulator prints when it does not answer."""


class RunWorkerError(RuntimeError):
    """A run did not reach its end, and its worker cannot be used any more. The text says why."""


class StoppedError(RuntimeError):
    """The batch was stopped."""


@dataclass(frozen=True, kw_only=True)
class Branch:
    """A recorded run whose beginning each run repeats.

    Attributes:
        log: The input log of the world in which its chair truly was.
        at: The tick up to which the log is followed.
        mirror: For a chair in a laboratory, the input log of the world that mirrored it.
    """

    log: Path
    at: int
    mirror: Path | None = None

    def arguments(self, *, of_mirror: bool) -> list[str]:
        """Return the arguments that make a simulator follow the log."""
        log = self.mirror if of_mirror and self.mirror is not None else self.log
        return ["--branch", str(log.absolute()), "--at", str(self.at)]


@dataclass(frozen=True, kw_only=True)
class WorkerSettings:
    """The settings of the workers of a batch.

    Attributes:
        source: The scene's name or path, as the simulator gets it.
        folder: Where relative paths in the scene start; None for an included scene.
        logs: A folder for the logs of the processes.
        runs: A folder for the files that the simulators write of each run.
        timeout: Seconds of wall time that a run may take.
        branch: A run whose beginning each run repeats, or None.
        say: Tells people why a simulator is not ready yet.
    """

    source: str
    folder: Path | None
    logs: Path
    runs: Path
    timeout: float
    branch: Branch | None = None
    say: Callable[[str], None] = lambda _: None


class RunFolders(NamedTuple):
    """The folders of what the simulators wrote of a run.

    Attributes:
        truth: Of the world in which the chair truly was.
        mirror: For a row with bridges, of the world that mirrored the chair; else None.
    """

    truth: Path
    mirror: Path | None


class RunWorker:
    """A simulator and the agents of a row. Use it in a `with`, which starts and ends them.

    Args:
        settings: The settings of the worker.
        row: The row.
        stop: Set from outside to give up.

    Raises:
        RunWorkerError: A process did not start, or an agent did not join.
        StoppedError: `stop` was set.
    """

    def __init__(self, settings: WorkerSettings, row: Row, stop: threading.Event) -> None:
        self._settings = settings
        self._row = row
        self._stop = stop
        self._stack = ExitStack()
        self._children = self._stack.enter_context(ChildProcesses(settings.logs))
        self._watches: dict[str, WorldWatch] = {}
        self._endpoints: dict[str, str] = {}
        self._agents: dict[str, str] = {}
        self._restarts = ProgramRestarts(self._children, self._start_agent)

    def __enter__(self) -> Self:
        try:
            self._start()
        except BaseException:
            self._stack.close()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End the processes. The agents go first: each says that it leaves, and the simulator must hear it."""
        self._children.end([child for child in self._children.running if child not in self._servers], grace=2.0)
        self._stack.close()

    def run(self, seed: str) -> RunFolders:
        """Run the scene with a seed to its end, and return where the files of the run are.

        Raises:
            RunWorkerError: The run did not reach its end.
            StoppedError: `stop` was set.
        """
        deadline = time.monotonic() + self._settings.timeout
        for agent in self._restarts.end():
            self._control(SERVER, "delete", Delete(agent=agent))
        mirror = self._reset(SERVER, seed)
        truth = self._reset(LABORATORY, seed) if self._row.bridges else mirror
        for server in self._servers:
            self._control(server, "resume", Resume())
        self._await(self._servers[-1], "ended", max(1.0, deadline - time.monotonic()), run=truth)
        self._pause()
        if self._row.bridges:
            self._reset(SERVER, seed)
        runs = self._settings.runs
        return RunFolders(runs / truth, runs / mirror if self._row.bridges else None)

    @property
    def _servers(self) -> tuple[str, ...]:
        """The simulators, last the one with the true poses."""
        return (SERVER, LABORATORY) if self._row.bridges else (SERVER,)

    def _start(self) -> None:
        for server, world in zip(self._servers, (defaults.WORLD, LAB), strict=False):
            self._endpoints[server] = free_endpoint()
            self._children.launch(server, partial(self._server_command, server, world))
            # One after the other: the first start compiles the kernels, and the second finds them compiled.
            self._await_ready(server)
            link = Link(world, connect=(self._endpoints[server],))
            try:
                self._watches[server] = self._stack.enter_context(watching(link, self._stop, subscribes=False))
            except ConnectionError as error:
                raise StoppedError from error if self._stop.is_set() else RunWorkerError(str(error))
        for cast in self._row.scene.cast:
            if cast.name in self._row.bridges:
                self._children.launch(bridge_child(cast.name), partial(self._bridge_command, cast))
            self._restarts.add(cast, self._start_agent(cast))
        for server in self._servers:
            self._await(server, "running", JOIN_LIMIT)
        self._pause()

    def _start_agent(self, cast: Cast) -> str:
        values = {"endpoint": self._endpoints[SERVER], "world": defaults.WORLD}
        child = launch_agent(self._children, cast, partial(self._agent_command, cast), values, self._settings.folder)
        self._agents[cast.name] = child
        return child

    def _pause(self) -> None:
        for server in self._servers:
            self._control(server, "pause", Pause())

    def _reset(self, server: str, seed: str) -> str:
        """Start a new run in a world and return its id."""
        end = self._row.scene.end
        if self._row.bridges and server == SERVER:
            end = End(timeout=end.timeout) if end is not None else None
        run = self._control(server, "reset", Reset(seed=seed, end=end))
        if server == SERVER:
            self._restarts.start_ended()
        self._await(server, "running", JOIN_LIMIT, run=run)
        return run

    # ------------------------------------------------------------ commands

    def _server_command(self, server: str, world: str, lifeline: int) -> list[str]:
        settings, row = self._settings, self._row
        arguments = [*link_arguments(world, [self._endpoints[server]]), "--pace", "lockstep", "--miss", "strict"]
        arguments += ["--deadline", f"{ANSWER_DEADLINE:g}", "--runs", str(settings.runs.absolute())]
        if server == LABORATORY and settings.branch is None:
            arguments += laboratory_arguments(row.scene, row.bridges, settings.folder)
        elif server == LABORATORY:
            arguments += ["--expect", ",".join(row.bridges), "--hide-truth"]
        else:
            arguments += ["--expect", ",".join(cast.name for cast in row.scene.cast)]
            place_map = floor(row.scene.map, beside=settings.folder)
            for agent, place in cast_places(row.scene.cast, place_map, beside=settings.folder).items():
                arguments += ["--reserve", f"{agent}={place}"]
            if settings.branch is None:
                arguments += ["--scene", resolved(settings.source, settings.folder), *row.arguments]
        if settings.branch is not None:
            arguments += settings.branch.arguments(of_mirror=server == SERVER and bool(row.bridges))
        return [sys.executable, "-m", "intellwheels_server", *arguments, "--lifeline", str(lifeline)]

    def _client_arguments(self, lifeline: int) -> list[str]:
        arguments = link_arguments(defaults.WORLD, (), [self._endpoints[SERVER]])
        return [*arguments, "--retry-for", f"{JOIN_LIMIT:g}", "--lifeline", str(lifeline)]

    def _agent_command(self, cast: Cast, lifeline: int) -> list[str]:
        make = mind_command if cast.name in self._row.bridges else agent_command
        return make(cast, self._settings.folder, self._client_arguments(lifeline))

    def _bridge_command(self, cast: Cast, lifeline: int) -> list[str]:
        laboratory, arguments = (LAB, self._endpoints[LABORATORY]), self._client_arguments(lifeline)
        return bridge_command(cast, self._row.bridges[cast.name], self._settings.folder, laboratory, arguments)

    # ------------------------------------------------------------ the simulators

    def _control(self, server: str, verb: Verb, message: Record) -> str:
        """Ask a simulator for a control verb and return the id of the run that it has then."""
        try:
            result = self._watches[server].control(verb, message, CONTROL_LIMIT)
        except ConnectionError as error:
            # The last line that a process prints is a better reason, and it may not have arrived yet.
            with suppress(WaitError):
                self._children.wait(self._check, "reason", LAST_WORDS)
            raise RunWorkerError(f"{server}: no answer to {verb}: {error}") from error
        if result.code != "ok" or result.run is None:
            raise RunWorkerError(f"{server}: {verb}: {result.text or result.code}")
        return result.run

    def _await(self, server: str, verb: str, limit: float, run: str | None = None) -> None:
        """Wait until a simulator prints a verb, about a given run if there is one."""
        values = {} if run is None else {"run": run}

        def look() -> dict[str, str] | None:
            if self._stop.is_set():
                raise StoppedError
            self._check_misses()
            # An earlier run may have ended, too: a short one does before it can be paused.
            found = self._children.find_line(server, verb, **values)
            if found is None:
                self._check()
            return found

        try:
            self._children.wait(look, f"line {verb!r} of {server}", limit, interval=INTERVAL)
        except WaitError:
            self._fail(server, f"did not print {verb!r} within {limit:.0f} s")

    def _await_ready(self, server: str) -> None:
        """Wait until a simulator is ready, however long it compiles."""

        def check() -> None:
            if self._stop.is_set():
                raise StoppedError
            self._check()

        try:
            await_ready(self._children, server, READY_LIMIT, check=check, say=self._settings.say, interval=INTERVAL)
        except WaitError:
            self._fail(server, f"is not ready, and printed nothing for {READY_LIMIT:.0f} s")

    def _check(self) -> None:
        """Raise if a simulator ended its run early, or if a process ended."""
        self._check_misses()
        for child, exited in self._children.exits.items():
            self._fail(child, exited.how)

    def _check_misses(self) -> None:
        for server in self._servers:
            if server not in self._endpoints:
                continue
            for verb in ("miss", "differs"):
                if (values := self._children.find_line(server, verb)) is not None:
                    who = self._agents.get(values.get("agent", ""), server)
                    self._fail(who, " ".join([verb, *(f"{name}={value}" for name, value in values.items())]))

    def _fail(self, child: str, what: str) -> NoReturn:
        tail = [line for line in self._children.tail(child, 40) if not line.startswith("asked ")][-6:]
        raise RunWorkerError("\n  ".join([f"{child}: {what}", *tail]))
