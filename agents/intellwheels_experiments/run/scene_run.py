"""A run from its first process to its last: start, wait for the barrier, watch, end all, judge.

Every wait has a deadline, and however it finishes there is a result.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import partial
from typing import Final, Protocol

from intellwheels_experiments.run.child_processes import ChildProcesses, Exited, Line
from intellwheels_experiments.run.launch_spec import (
    LABORATORY,
    SERVER,
    VIEWER,
    LaunchSpec,
    agent_child,
    bridge_child,
    parse,
)
from intellwheels_experiments.run.progress import Progress
from intellwheels_experiments.run.run_record import RunRecord
from intellwheels_experiments.run.run_report import Finish, Result, versions
from intellwheels_experiments.run.verdict import judge

READY_LIMIT: Final = 180.0
"""Seconds for the simulator to be ready: a first start compiles its kernels, on a small machine slowly."""

START_LIMIT: Final = 60.0
"""Seconds for all agents to be at the barrier once they were started."""

VIEW_LIMIT: Final = 60.0
"""Seconds for the viewer to serve its page."""

COLD_START: Final = 5.0
"""Seconds after which a start that is still going on is surely a first one."""


class Watch(Protocol):
    """What sees a run from outside."""

    def pour(self, record: RunRecord) -> None:
        """Put what arrived since the last time into the record."""

    def complete(self, record: RunRecord) -> None:
        """Ask the simulator for what is true now and for events that were not seen."""


@dataclass(frozen=True, slots=True)
class _Finished:
    how: Finish
    words: str = ""
    tick: int | None = None
    hash: str | None = None


def perform(
    plan: LaunchSpec,
    watching: Callable[[threading.Event], AbstractContextManager[Watch]],
    progress: Progress,
    stop: threading.Event,
) -> Result:
    """Run a scene and return what came of it.

    Args:
        plan: What to run.
        watching: Begins to watch the world of the plan; called once its simulator is ready.
        progress: Shows how it goes on.
        stop: Set from outside to break the run off.

    Raises:
        OSError: A process cannot be started.
    """
    record = RunRecord()
    stopwatch = _Stopwatch()
    with ChildProcesses(plan.logs) as children:
        finish = _start(plan, children, progress, stop)
        if finish is None:
            try:
                with watching(stop) as watch:
                    finish = _follow(plan, children, watch, record, progress, stop, stopwatch)
                    watch.pour(record)
                    if SERVER in children.living:
                        watch.complete(record)
                    if finish.how == "ended" and VIEWER in children.living:
                        _stay(children, progress, stop)
            except ConnectionError as error:
                finish = _Finished("interrupted" if stop.is_set() else "died", str(error))
        progress.doing("ending the processes")
        # The agents first: they leave in words, which needs somebody to hear them.
        children.end([child for child in children.living if child not in (SERVER, LABORATORY, VIEWER)])
        children.end(list(children.living), grace=5.0)
    return _result(plan, record, finish, stopwatch.seconds)


class _Stopwatch:
    """Wall time from the first step to the end."""

    def __init__(self) -> None:
        self._begin: float | None = None
        self._end: float | None = None

    def begin(self) -> None:
        self._begin = time.monotonic()

    def end(self) -> None:
        self._end = time.monotonic()

    @property
    def seconds(self) -> float:
        if self._begin is None:
            return 0.0
        return (self._end or time.monotonic()) - self._begin


def _start(plan: LaunchSpec, children: ChildProcesses, progress: Progress, stop: threading.Event) -> _Finished | None:
    """Start all processes once the simulator is ready; return how the run finished, if it did already."""
    # One after the other: a first start compiles the kernels, which the second one then finds.
    servers = {SERVER: plan.server_command, LABORATORY: plan.laboratory_command}
    for server in (SERVER, LABORATORY) if plan.scene.bridge else (SERVER,):
        children.start(server, servers[server])
        if (finish := _await_ready(server, children, progress, stop)) is not None:
            return finish
    if plan.view is not None and (finish := _open_view(plan, children, progress, stop)) is not None:
        return finish
    for cast in plan.scene.cast:
        if cast.name in plan.bridges:
            children.start(bridge_child(cast.name), partial(plan.bridge_command, cast))
        children.start(agent_child(cast.name), partial(plan.agent_command, cast))
    progress.say(
        f"started world={plan.world} at={','.join(plan.meeting)} agents={len(plan.scene.cast)} logs={plan.logs}"
    )
    if plan.scene.bridge:
        progress.say(f"laboratory world={plan.lab} at={plan.laboratory} chairs={','.join(plan.bridges)}")
    return None


def _await_ready(server: str, children: ChildProcesses, progress: Progress, stop: threading.Event) -> _Finished | None:
    """Wait until a simulator is ready; return how the run finished, if it did already."""
    begun = time.monotonic()
    shown = False
    while True:
        waited = time.monotonic() - begun
        match children.news(0.2):
            case Line(child=child, text=text) if child == server and parse(text)[0] == "ready":
                return None
            case Exited() as exited:
                return _died(children, exited)
        if stop.is_set():
            return _Finished("interrupted", "before the simulator was ready")
        if waited > READY_LIMIT:
            return _Finished("overtime", _with_tail(children, server, f"not ready after {READY_LIMIT:.0f} s"))
        if waited > COLD_START and not shown:
            progress.say("the simulator compiles its kernels: once, about 45 s")
            shown = True


def _open_view(
    plan: LaunchSpec, children: ChildProcesses, progress: Progress, stop: threading.Event
) -> _Finished | None:
    """Start the viewer and say where its page is, before anything moves; return how the run finished, if it did."""
    children.start(VIEWER, plan.viewer_command)
    begun = time.monotonic()
    while True:
        match children.news(0.2):
            case Line(child=child, text=text) if child == VIEWER and parse(text)[0] == "ready":
                progress.say(f"view it at {parse(text)[1].get('url', '?')}")
                return None
            case Exited() as exited:
                return _died(children, exited)
        if stop.is_set():
            return _Finished("interrupted", "before the viewer was ready")
        if time.monotonic() - begun > VIEW_LIMIT:
            return _Finished("overtime", _with_tail(children, VIEWER, f"no page after {VIEW_LIMIT:.0f} s"))


def _stay(children: ChildProcesses, progress: Progress, stop: threading.Event) -> None:
    """Leave the last picture on the page until told to stop, or until nobody shows it any more."""
    progress.say("the run is over; the page stays until Ctrl-C")
    progress.doing("over; the page stays until Ctrl-C")
    while not stop.is_set() and {SERVER, VIEWER} <= set(children.living):
        children.news(0.2)


def _follow(
    plan: LaunchSpec,
    children: ChildProcesses,
    watch: Watch,
    record: RunRecord,
    progress: Progress,
    stop: threading.Event,
    stopwatch: _Stopwatch,
) -> _Finished:
    """Watch the run until it finishes."""
    begun = time.monotonic()
    running = False
    while True:
        news = children.news(0.1)
        waited = time.monotonic() - begun
        if isinstance(news, Line) and news.child == SERVER:
            verb, values = parse(news.text)
            if verb == "running" and not running:
                running = True
                stopwatch.begin()
            elif verb == "ended":
                stopwatch.end()
                return _Finished("ended", tick=_number(values.get("tick")), hash=values.get("hash"))
            elif verb == "miss":
                stopwatch.end()
                return _Finished("missed", _missed(children, values), _number(values.get("tick")))
        elif isinstance(news, Line) and news.child == LABORATORY and parse(news.text)[0] == "miss":
            stopwatch.end()
            return _Finished("missed", _with_tail(children, LABORATORY, news.text))
        elif isinstance(news, Exited) and news.child == VIEWER:
            progress.say(_with_tail(children, VIEWER, f"{news.how}; the run goes on without a page"))
        elif isinstance(news, Exited) and (news.child in (SERVER, LABORATORY) or news.code != 0):
            stopwatch.end()
            return _died(children, news)
        watch.pour(record)
        progress.follow(record)
        if stop.is_set():
            stopwatch.end()
            return _Finished("interrupted")
        if not running and waited > START_LIMIT:
            awaited = ", ".join(record.clock.waiting) if record.clock else ""
            return _Finished("overtime", f"not running after {START_LIMIT:.0f} s, waiting for {awaited or 'nobody'}")
        if waited > plan.timeout:
            stopwatch.end()
            return _Finished("overtime", f"broken off after {plan.timeout:.0f} s of wall time")


def _died(children: ChildProcesses, exited: Exited) -> _Finished:
    return _Finished("died", _with_tail(children, exited.child, exited.how))


def _missed(children: ChildProcesses, values: Mapping[str, str]) -> str:
    what = f"missed tick {values.get('tick', '?')}"
    child = agent_child(values.get("agent", ""))
    return _with_tail(children, child, what) if children.log_of(child).exists() else what


def _with_tail(children: ChildProcesses, child: str, what: str) -> str:
    tail = children.tail(child)
    words = f"{child}: {what}"
    return "\n".join([f"{words}; the last lines of {children.log_of(child)}:", *(f"  {line}" for line in tail)])


def _number(text: str | None) -> int | None:
    return int(text) if text is not None and text.isdecimal() else None


def _result(plan: LaunchSpec, record: RunRecord, finish: _Finished, wall: float) -> Result:
    clock = record.clock
    tick = finish.tick if finish.tick is not None else clock.tick if clock else 0
    verdict = judge(plan.scene, plan.floor, record, ended=finish.how == "ended")
    simulated = tick * plan.scene.period
    return Result(
        scene=plan.scene.name,
        map=plan.floor.name,
        seed=plan.scene.seed,
        pace=plan.pace,
        world=plan.world,
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
    )
