"""One run of a scene: start its processes, wait for the barrier, watch the run, end the processes, judge the run.

Every wait has a deadline. However the run finishes, there is a result.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import partial
from signal import SIGKILL
from typing import Final, Protocol

from intellwheels_experiments.run.child_processes import READY_LIMIT, ChildProcesses, Exited, WaitError
from intellwheels_experiments.run.foreign_program import launch_agent
from intellwheels_experiments.run.launch_spec import (
    LABORATORY,
    SERVER,
    VIEWER,
    LaunchSpec,
    bridge_child,
)
from intellwheels_experiments.run.program_restarts import Controls, ProgramRestarts
from intellwheels_experiments.run.progress import Progress
from intellwheels_experiments.run.run_record import RunRecord
from intellwheels_experiments.run.run_report import Finish, Result, versions
from intellwheels_experiments.run.start_watch import await_ready
from intellwheels_experiments.run.verdict import judge
from intellwheels_schemas.messages import Cast

START_LIMIT: Final = 60.0
"""Seconds for all agents to join once they were started."""

VIEW_LIMIT: Final = 60.0
"""Seconds for the viewer to serve its page."""

END_LIMIT: Final = 30.0
"""Seconds for the simulators to write the rest of their logs and to end; the machine may be busy."""

INTERVAL: Final = 0.1
"""Seconds between two checks of a run."""


class Watch(Controls, Protocol):
    """Receives what a world publishes, queries it and controls it."""

    def drain(self, record: RunRecord) -> None:
        """Put what arrived since the last call into the record."""


@dataclass(frozen=True, slots=True)
class _Finished:
    how: Finish
    words: str = ""
    tick: int | None = None
    hash: str | None = None


class _StartError(Exception):
    """A run finished before it began."""

    def __init__(self, finish: _Finished) -> None:
        super().__init__(finish.words)
        self.finish = finish


def perform(
    spec: LaunchSpec,
    watching: Callable[[threading.Event], AbstractContextManager[Watch]],
    progress: Progress,
    stop: threading.Event,
) -> Result:
    """Run a scene and return its result.

    Args:
        spec: What to run.
        watching: Connects to the world of the spec. Called once, when the simulator is ready.
        progress: Shows how far the run is.
        stop: Set from outside to abort the run.

    Raises:
        OSError: A process cannot be started.
    """
    record = RunRecord()
    stopwatch = _Stopwatch()
    further = 0
    with ChildProcesses(spec.logs) as children:
        restarts = ProgramRestarts(children, partial(_start_agent, spec, children))
        try:
            _start(spec, children, restarts, progress, stop)
            with watching(stop) as watch:
                finish = _follow(spec, children, restarts, watch, record, progress, stop, stopwatch)
                watch.drain(record)
                if SERVER in children.running:
                    watch.query_all(record)
                if finish.how == "ended" and VIEWER in children.running:
                    further = _keep_page(spec, children, restarts, watch, progress, stop)
        except _StartError as error:
            finish = error.finish
        except ConnectionError as error:
            finish = _Finished("interrupted" if stop.is_set() else "died", str(error))
        progress.doing("ending the processes")
        # The agents first: each says that it leaves, and the simulator must still be there to hear it.
        children.end([child for child in children.running if child not in (SERVER, LABORATORY, VIEWER)])
        servers = (SERVER, LABORATORY) if spec.bridges else (SERVER,)
        children.end(children.running, grace=END_LIMIT)
        if finish.how == "ended":
            # A simulator that could not write the last of its log says so when it ends, and one that had to be killed
            # has not written it. If it ended by itself already, that may not be known yet: so it is awaited too.
            children.end(servers)
            children.receive()
            for server in servers:
                exited = children.exited(server) or Exited(server, -SIGKILL)
                if exited.code != 0:
                    finish = _died(children, exited)
    return _result(spec, record, finish, stopwatch.seconds, further)


class _Stopwatch:
    """Wall time from the first step to the end."""

    def __init__(self) -> None:
        self._begin: float | None = None
        self._end: float | None = None

    def begin(self) -> None:
        if self._begin is None:
            self._begin = time.monotonic()

    def end(self) -> None:
        self._end = time.monotonic()

    @property
    def begun(self) -> bool:
        return self._begin is not None

    @property
    def seconds(self) -> float:
        if self._begin is None:
            return 0.0
        return (self._end or time.monotonic()) - self._begin


def _start_agent(spec: LaunchSpec, children: ChildProcesses, cast: Cast) -> str:
    values = {"endpoint": next(iter(spec.meeting), ""), "world": spec.world}
    return launch_agent(children, cast, partial(spec.agent_command, cast), values, spec.folder)


def _start(
    spec: LaunchSpec,
    children: ChildProcesses,
    restarts: ProgramRestarts,
    progress: Progress,
    stop: threading.Event,
) -> None:
    """Start all processes, the simulator first.

    Raises:
        _StartError: A process ended or was not ready in time, or `stop` was set.
    """
    # One after the other: the first start compiles the kernels, and the second finds them compiled.
    servers = {SERVER: spec.server_command, LABORATORY: spec.laboratory_command}
    for server in (SERVER, LABORATORY) if spec.scene.bridge else (SERVER,):
        children.launch(server, servers[server])
        _await_ready(server, READY_LIMIT, children, stop, progress)
    if spec.view is not None:
        children.launch(VIEWER, spec.viewer_command)
        ready = _await_ready(VIEWER, VIEW_LIMIT, children, stop, progress)
        # Before anything moves.
        progress.say(f"view it at {ready.get('url', '?')} (the scene starts when the page is open)")
    for cast in spec.scene.cast:
        if cast.name in spec.bridges:
            children.launch(bridge_child(cast.name), partial(spec.bridge_command, cast))
        restarts.add(cast, _start_agent(spec, children, cast))
    progress.say(
        f"started world={spec.world} at={','.join(spec.meeting)} agents={len(spec.scene.cast)} logs={spec.logs}"
    )
    if spec.scene.bridge:
        progress.say(f"laboratory world={spec.lab} at={spec.laboratory} chairs={','.join(spec.bridges)}")


def _await_ready(
    child: str, limit: float, children: ChildProcesses, stop: threading.Event, progress: Progress
) -> Mapping[str, str]:
    """Wait until a process prints `ready`; return the values of that line.

    Args:
        child: The process.
        limit: Seconds that it may print nothing.
        children: All processes.
        stop: Set to abort.
        progress: Where to say what it waits for, or that it compiles kernels.

    Raises:
        _StartError: A process ended or was silent for too long, or `stop` was set.
    """

    def check() -> None:
        for exited in children.exits.values():
            raise _StartError(_died(children, exited))
        if stop.is_set():
            raise _StartError(_Finished("interrupted", f"before the {child} was ready"))

    try:
        return await_ready(
            children, child, limit, check=check, say=progress.say, doing=progress.doing, interval=INTERVAL
        )
    except WaitError:
        finish = _Finished("overtime", _with_tail(children, child, f"not ready, and silent for {limit:.0f} s"))
        raise _StartError(finish) from None


def _keep_page(
    spec: LaunchSpec,
    children: ChildProcesses,
    restarts: ProgramRestarts,
    watch: Watch,
    progress: Progress,
    stop: threading.Event,
) -> int:
    """Keep the scene and its page until `stop` is set, or until the simulator or the viewer ends.

    The page can run the scene again. Each of these runs is judged, but the result of the command is that of the first.
    Returns how many further runs reached their end.
    """
    progress.say("the run has ended; run it again from the page, or stop with Ctrl-C")
    progress.doing("ended; run it again from the page, or stop with Ctrl-C")
    record = RunRecord()
    further = 0

    def over() -> bool | None:
        nonlocal record, further
        watch.drain(record)
        restarts.follow(record, watch)
        if children.find_line(SERVER, "ended") is not None:
            watch.query_all(record)
            verdict = judge(spec.scene, spec.floor, record)
            further += 1
            progress.say(f"run {further + 1}: {'all conditions hold' if verdict.held else '; '.join(verdict.failed)}")
            record = RunRecord()
        return True if stop.is_set() or not {SERVER, VIEWER} <= set(children.running) else None

    try:
        children.wait(over, "Ctrl-C", math.inf, interval=INTERVAL)
    except ConnectionError as error:
        # The run is over, and its result stays what it was.
        progress.say(f"the page ends: {error}")
    return further


def _follow(
    spec: LaunchSpec,
    children: ChildProcesses,
    restarts: ProgramRestarts,
    watch: Watch,
    record: RunRecord,
    progress: Progress,
    stop: threading.Event,
    stopwatch: _Stopwatch,
) -> _Finished:
    """Watch the run until it finishes."""
    begun = time.monotonic()
    has_page = spec.view is not None

    def look() -> _Finished | None:
        nonlocal has_page
        if children.find_line(SERVER, "running") is not None:
            stopwatch.begin()
        finish = _printed(children, restarts, spec)
        if finish is not None:
            return finish
        if has_page and (exited := children.exited(VIEWER)) is not None:
            progress.say(_with_tail(children, VIEWER, f"{exited.how}; the run continues without a page"))
            has_page = False
        for child, exited in children.exits.items():
            if child in (SERVER, LABORATORY) or (child != VIEWER and exited.code != 0):
                return _died(children, exited)
        watch.drain(record)
        restarts.follow(record, watch)
        progress.follow(record)
        if stop.is_set():
            return _Finished("interrupted")
        # Somebody who looks at the page may have paused the run before it began.
        if spec.view is None and not stopwatch.begun and time.monotonic() - begun > START_LIMIT:
            awaited = ", ".join(record.clock.waiting) if record.clock else ""
            return _Finished("overtime", f"not running after {START_LIMIT:.0f} s; waiting for {awaited or 'no agent'}")
        return None

    try:
        finish = children.wait(look, "end of the run", spec.timeout, interval=INTERVAL)
    except WaitError:
        finish = _Finished("overtime", f"aborted after {spec.timeout:.0f} s of wall time")
    stopwatch.end()
    return finish


def _printed(children: ChildProcesses, restarts: ProgramRestarts, spec: LaunchSpec) -> _Finished | None:
    """Return how the run finished by what a simulator printed, or None."""
    if (values := children.find_line(SERVER, "miss")) is not None:
        return _Finished("missed", _missed(children, restarts, values), _number(values.get("tick")))
    if (values := children.find_line(SERVER, "ended")) is not None:
        return _Finished("ended", tick=_number(values.get("tick")), hash=values.get("hash"))
    if spec.scene.bridge and (values := children.find_line(LABORATORY, "miss")) is not None:
        return _Finished("missed", _with_tail(children, LABORATORY, f"missed tick {values.get('tick', '?')}"))
    return None


def _died(children: ChildProcesses, exited: Exited) -> _Finished:
    return _Finished("died", _with_tail(children, exited.child, exited.how))


def _missed(children: ChildProcesses, restarts: ProgramRestarts, values: Mapping[str, str]) -> str:
    what = f"missed tick {values.get('tick', '?')}"
    child = restarts.child_of(values.get("agent", ""))
    return _with_tail(children, child, what) if children.log_of(child).exists() else what


def _with_tail(children: ChildProcesses, child: str, what: str) -> str:
    tail = children.tail(child)
    return "\n".join([f"{child}: {what}; the last lines of {children.log_of(child)}:", *(f"  {line}" for line in tail)])


def _number(text: str | None) -> int | None:
    return int(text) if text is not None and text.isdecimal() else None


def _result(spec: LaunchSpec, record: RunRecord, finish: _Finished, wall: float, further: int) -> Result:
    clock = record.clock
    tick = finish.tick if finish.tick is not None else clock.tick if clock else 0
    verdict = judge(spec.scene, spec.floor, record, ended=finish.how == "ended")
    simulated = tick * spec.scene.period
    return Result(
        scene=spec.scene.name,
        map=spec.floor.name,
        seed=spec.scene.seed,
        pace=spec.pace,
        world=spec.world,
        run=record.run,
        finish=finish.how,
        words=finish.words,
        held=verdict.held,
        failed=verdict.failed,
        hash=finish.hash,
        ticks=tick,
        time=simulated,
        wall=wall,
        factor=simulated / wall if wall > 0 else 0.0,
        late=clock.late if clock else 0,
        contacts=verdict.contacts,
        events=dict(sorted(record.counts.items())),
        agents=verdict.agents,
        versions=versions(),
        further=further,
    )
