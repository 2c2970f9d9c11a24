"""A simulator, agents and faults for tests, as real processes. `plugin` makes it a pytest fixture.

    with Rig(Path("logs"), floor="corner", seed="1") as sim:
        sim.agent("chair1", mind="my_mind.py", robot="rear-wheel", place="leader")
        sim.run_until(lambda now: now["chair1"].x > 8.0, seconds=20.0)
        assert sim.contacts == []

In lockstep, the default, the world stands still between the calls. Within a call it advances one tick at a time, so a
condition sees every tick, and the world stops at the tick at which it holds. At the other paces the world runs by
itself, and a condition sees the states that the world publishes.

Lengths are in m, angles in rad, speeds in m/s. Simulated times are in s since the start of the run. Every wait has a
deadline.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, suppress
from itertools import chain
from pathlib import Path
from typing import Any, Final, Self

from intellwheels_experiments.run.child_processes import DEADLINE, SLICE, WaitError
from intellwheels_experiments.run.launch_spec import resolved
from intellwheels_experiments.run.world_watch import WorldWatch, watching
from intellwheels_experiments.testing.history import AbsentError, History, Moment, Point
from intellwheels_experiments.testing.process_group import GRACE, WORLD, ProcessGroup
from intellwheels_maps import scene as scene_file
from intellwheels_schemas.channels import VERB_CLASSES
from intellwheels_schemas.extras import missing_extra
from intellwheels_schemas.keys import Verb
from intellwheels_schemas.link import Link
from intellwheels_schemas.messages import Delete, Event, Miss, Pace, Result, Step

ROUNDING: Final = 1e-9
"""Seconds by which a simulated time may be too short, as sums of periods are rounded."""


class Rig(ProcessGroup):
    """A world at a free port of this machine, with the agents of a test. Use it in a `with`, which ends all processes.

    Args:
        logs: The folder of the processes' logs. It is made if it does not exist.
        floor: An included map or the path of one. Default: the scene's map, or `room`.
        scene: An included scene or the path of one, for its map, seed, period and end. `cast` starts its agents.
        pace: `lockstep`, `realtime` or `free`. Default: the scene's pace, or `lockstep`.
        seed: The seed of all noise. Default: the scene's seed, or `1`.
        miss: What happens in lockstep if an answer does not come: `strict` ends the run, `elastic` continues without
            it. Default: the scene's choice, or `strict`.
        speed: Multiple of real time, at pace `realtime`.
        router: Whether the agents connect to the simulator through a router, which `cut_router` can kill.
        arguments: Further arguments for `iw-server`, such as `("--truth", "--grace", "1")`.
        folder: Where relative paths start. Default: the working directory.

    Attributes:
        pace: The pace of the world.
        endpoint: The Zenoh endpoint at which the simulator listens.
        processes: The child processes, for their ids and logs.

    Raises:
        WireError: The scene cannot be read.
        WaitError: On entering the `with`: the simulator did not get ready.
    """

    def __init__(
        self,
        logs: Path,
        *,
        floor: str | None = None,
        scene: str | None = None,
        pace: Pace | None = None,
        seed: str | None = None,
        miss: Miss | None = None,
        speed: float = 1.0,
        router: bool = False,
        arguments: Sequence[str] = (),
        folder: Path | None = None,
    ) -> None:
        self._source = None if scene is None else resolved(scene, folder)
        self._scene = None if self._source is None else scene_file(self._source)
        self.pace: Pace = pace or (self._scene.pace if self._scene else "lockstep")
        self._speed = speed
        given = {"--scene": self._source, "--map": floor and resolved(floor, folder), "--seed": seed, "--miss": miss}
        chosen = ["--pace", self.pace]
        for option, value in given.items():
            chosen += [option, value] if value is not None else []
        if self.pace == "realtime":
            chosen += ["--speed", repr(speed)]
        if self.pace == "free":
            chosen += ["--open-loop"]
        super().__init__(logs, [*chosen, *arguments], router=router, folder=folder)
        self._history = History()
        self._watch: WorldWatch | None = None
        self._session = ExitStack()

    # ------------------------------------------------------------ start and end

    def __enter__(self) -> Self:
        try:
            if self.has_router:
                self.mend_router()
            self._begin()
        except BaseException:
            self.close()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End all processes. A second call does nothing."""
        self._session.close()
        super().close()

    def _begin(self) -> None:
        """Start the simulator and connect to it."""
        lacking = missing_extra("server")
        if lacking is not None:
            raise WaitError(f"the simulator is not installed: {lacking}")
        self._start_simulator()
        link = Link(WORLD, connect=(self.endpoint,))
        steps = self.pace == "lockstep"
        self._watch = self._session.enter_context(watching(link, threading.Event(), subscribes=not steps))
        if steps:
            self.ctl("pause")
        self._query()

    # ------------------------------------------------------------ agents

    def agent(
        self,
        name: str,
        mind: str | Sequence[str] = "avoid",
        *,
        robot: str | None = None,
        place: str | None = None,
        encoding: str = "json",
        may_end: bool = False,
        **options: object,
    ) -> None:
        """Start an agent as a process of its own and wait until it has joined.

        Args:
            name: Its name.
            mind: An included mind, the path of a Python file, or the command of any program as a sequence of arguments.
                In a command `{endpoint}`, `{world}` and `{name}` are replaced. The program also finds them in its
                environment, as IW_ENDPOINT, IW_WORLD and IW_NAME.
            robot: Its body: an included robot or the path of one. Default: the mind's own. Not for a command.
            place: The place of the map where it starts. Default: any free place. Not for a command.
            encoding: The encoding of its messages, `json` or `xml`. Not for a command.
            may_end: Whether the process may end with another code than 0. Otherwise that fails the test.
            options: Options of the mind. Names that begin with a capital letter set fields of its robot, such as
                `MotorNoise=0.02`. Not for a command.

        Raises:
            WireError: The name is not a valid name of an agent, or the command cannot be started.
            ValueError: A command was given with a robot, a place or options.
            WaitError: It did not join, or a process ended.
        """
        self._watched().query(self._history)
        since = self._history.next_missing
        self._start_agent(name, mind, robot, place, encoding, options)
        if may_end:
            self._may_end.add(self._child(name))
        self._await_joined([name], since)

    def cast(self, *names: str) -> None:
        """Start agents of the scene and wait until all of them have joined.

        Args:
            names: The names of the agents. Default: all of the scene.

        Raises:
            WaitError: There is no scene, an agent did not join, or a process ended.
            LookupError: The scene has no agent of such a name.
        """
        if self._scene is None or self._source is None:
            raise WaitError("cast: expected a rig with a scene, got one with a map only")
        folder = Path(self._source).parent if Path(self._source).is_absolute() else None
        known = [cast.name for cast in self._scene.cast]
        for name in names:
            if name not in known:
                agents = ", ".join(known) or "none"
                raise LookupError(f"cast: expected an agent of the scene ({agents}), got {name!r}")
        chosen = [cast for cast in self._scene.cast if not names or cast.name in names]
        self._watched().query(self._history)
        since = self._history.next_missing
        for cast in chosen:
            self._start_cast(cast, folder, "json")
        self._await_joined([cast.name for cast in chosen], since)

    def _await_joined(self, names: Iterable[str], since: int) -> None:
        wanted = list(names)

        def joined() -> bool | None:
            self._check()
            present = {
                event.agent for event in self.events if event.code in ("joined", "returned") and event.number >= since
            }
            return True if present.issuperset(wanted) else None

        self.processes.wait(joined, f"join of {', '.join(wanted)}", unless=self._simulator)

    # ------------------------------------------------------------ time

    def run_until(self, condition: Callable[[Moment], object] | None = None, seconds: float = 20.0) -> Moment:
        """Let the world run until a condition holds.

        In lockstep the condition sees every tick, and the world stops at the tick at which it held. At the other paces
        it sees the states that the world publishes.

        Args:
            condition: Called with each moment, the present one first. It counts as false while it looks up a body
                that is absent. None: run for `seconds`.
            seconds: The simulated time in s within which the condition must hold.

        Returns:
            The moment at which the condition held.

        Raises:
            WaitError: The condition did not hold in time, the run ended, or a process ended that should not have.
            ValueError: `seconds` is negative or not finite.
        """
        __tracebackhide__ = True
        if not 0.0 <= seconds < math.inf:
            raise ValueError(f"seconds: expected a finite number of simulated seconds, at least 0, got {seconds}")
        begun = self.now
        until = begun.time + seconds - ROUNDING
        for now in chain([begun], self._moments(begun, seconds)):
            why = ""
            try:
                if condition is not None and condition(now):
                    return now
            except AbsentError as error:
                why = f": {error}"
            if now.time >= until:
                if condition is None:
                    return now
                what = f"run_until: the condition did not hold within {seconds:g} s of simulated time{why}"
                raise WaitError(f"{what}\n{now.describe()}")
        raise AssertionError("unreachable")  # the moments have no end

    def run_for(self, seconds: float) -> Moment:
        """Let the world run for some simulated seconds, and return the moment then.

        Raises:
            WaitError: The run ended, or a process ended that should not have.
            ValueError: `seconds` is negative or not finite.
        """
        __tracebackhide__ = True
        return self.run_until(None, seconds)

    def _moments(self, begun: Moment, seconds: float) -> Iterator[Moment]:
        """Yield the moments after this one, without end. In lockstep the world advances with each one taken."""
        if self.pace == "lockstep":
            while True:
                yield self._step()
        factor = self._speed if self.pace == "realtime" else 1.0
        deadline = time.monotonic() + seconds / factor + DEADLINE
        watch, history = self._watched(), self._history
        history.unread.clear()
        while True:
            self._check(SLICE)
            watch.drain(history)
            # The event may arrive before the state of its tick.
            over = history.ended is not None
            if over:
                watch.query(history)
            while history.unread:
                now = history.unread.popleft()
                if over or now.tick != begun.tick:
                    yield now
            if over:
                raise WaitError(f"the run ended\n{self.now.describe()}")
            if time.monotonic() > deadline:
                raise WaitError(f"the simulated time does not advance\n{self.now.describe()}")

    def _step(self) -> Moment:
        try:
            result = self._watched().control("step", Step(count=1), DEADLINE)
        except ConnectionError as error:
            # The simulator's log says why, once its process has ended.
            self.processes.wait(lambda: self.processes.exited(self._simulator), f"answer of the simulator ({error})")
            self._check()
            raise
        if result.code == "failed":
            # The simulator may be about to end. Then its log says why.
            with suppress(WaitError):
                self.processes.exit(self._simulator, GRACE)
        self._check()
        self._history.unread.clear()
        self._query()
        if result.code != "ok":
            raise WaitError(f"the world does not advance: {result.text or result.code}\n{self._newest().describe()}")
        return self._newest()

    def ctl(self, verb: Verb, **fields: Any) -> Result:
        """Ask the simulator for a control verb, such as `ctl("delete", agent="chair1")`.

        Args:
            verb: The verb.
            fields: The fields of its message, with their names in `intellwheels_schemas.messages`.

        Returns:
            The answer. Its `code` is `ok`, or says why the simulator refused.

        Raises:
            ConnectionError: No answer came in time.
        """
        watch, message = self._watched(), VERB_CLASSES[verb](**fields)
        if verb not in ("reset", "load", "restore"):
            return watch.control(verb, message, DEADLINE)
        ended = self._restarts.end()
        for agent in ended if verb != "restore" else ():
            watch.control("delete", Delete(agent=agent), DEADLINE)
        result = watch.control(verb, message, DEADLINE)
        self._restarts.start_ended()
        self._await_joined(ended, 0)
        return result

    # ------------------------------------------------------------ what happened

    @property
    def now(self) -> Moment:
        """The present moment, queried from the simulator."""
        self._query()
        return self._newest()

    @property
    def events(self) -> tuple[Event, ...]:
        """All events of the present run, in order."""
        return self.now.events

    @property
    def contacts(self) -> list[tuple[str, str]]:
        """The pairs that came into contact in the present run, in order: two bodies, or a body and `wall`."""
        return self.now.contacts

    def pose(self, name: str) -> Point:
        """Return the present time and the true pose of a body.

        Raises:
            AbsentError: There is no such body.
        """
        now = self.now
        body = now[name]
        return Point(now.time, body.x, body.y, body.heading)

    def path(self, name: str) -> list[Point]:
        """Return the true poses of a body in the present run: in lockstep of every tick, else of the published states.

        Raises:
            AbsentError: There was no such body.
        """
        self._query()
        if name not in self._history.paths:
            known = ", ".join(self._history.paths) or "none"
            raise AbsentError(f"expected one of the bodies of this run ({known}), got {name!r}")
        return list(self._history.paths[name])

    # ------------------------------------------------------------ restart

    def restart_simulator(self) -> None:
        """Kill the simulator, start it again, and wait until all running agents have joined the new run.

        Frozen agents are not awaited.

        Raises:
            WaitError: The simulator did not get ready, or an agent did not join.
        """
        self._session.close()
        self._kill_simulator()
        self._history = History()
        awake = self._awake()
        # An agent that joins before the new world is paused would let it run for a random number of ticks.
        with self._stopped(awake if self.pace == "lockstep" else ()):
            self._begin()
        self._await_joined(awake, 0)

    def _watched(self) -> WorldWatch:
        if self._watch is None:
            raise ValueError("expected a rig in a `with`, got one that was not started")
        return self._watch

    def _query(self) -> None:
        self._watched().query(self._history)

    def _newest(self) -> Moment:
        if self._history.newest is None:
            raise WaitError(f"the simulator did not report the state of the world\n{self.processes.report()}")
        return self._history.newest
