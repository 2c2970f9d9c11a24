"""A simulator, agents and faults for a test, as real processes. It knows no test framework; `plugin` is for pytest.

In lockstep the world stands between calls and goes one step at a time within them: every tick is looked at, and none
is made beyond the one at which a condition held. At the other paces it goes on by itself and what it publishes is
looked at. Nothing is waited for by sleeping, and every wait has a deadline.
"""

from __future__ import annotations

import importlib.util
import math
import signal
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from itertools import chain
from pathlib import Path
from typing import Any, Final, Self

from intellwheels_experiments.run.launch_spec import resolved
from intellwheels_experiments.run.run_processes import DEADLINE, SLICE, AwaitedError
from intellwheels_experiments.run.world_watch import WorldWatch, watching
from intellwheels_experiments.testing.history import AbsentError, History, Moment, Point
from intellwheels_experiments.testing.process_group import GRACE, WORLD, ProcessGroup
from intellwheels_maps import scene as scene_file
from intellwheels_schemas.channels import VERB_CLASSES
from intellwheels_schemas.keys import Verb
from intellwheels_schemas.link import Link
from intellwheels_schemas.messages import Event, Miss, Pace, Result, Step

ROUNDING: Final = 1e-9
"""Seconds by which a simulated time may be short of what was asked for: sums of periods round."""


class Rig(ProcessGroup):
    """A world on a free port of this machine with the agents of a test. To be used in a `with`.

    Args:
        logs: The folder of the processes' logs; it is made if it is not there.
        floor: A shipped floor or a path; default: the scene's, or `room`.
        scene: A shipped scene or a path, for its floor, seed, period and end; `cast` starts its agents.
        pace: What makes a tick begin; default: the scene's, or `lockstep`.
        seed: All noise follows from it; default: the scene's, or `1`.
        miss: In lockstep, of an answer that does not come: end the run (`strict`) or go on (`elastic`).
        speed: Times real time, at pace `realtime`.
        router: Whether the agents meet the simulator at a router, which can be cut.
        words: Further words for `iw-server`, such as `("--truth", "--grace", "1")`.
        folder: Where relative paths start from; default: the working directory.
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
        words: Sequence[str] = (),
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
        super().__init__(logs, [*chosen, *words], router=router, folder=folder)
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
        """End everything. More than once does nothing."""
        self._session.close()
        super().close()

    def _begin(self) -> None:
        """Start the simulator and be connected to it."""
        if importlib.util.find_spec("numba") is None:
            raise AwaitedError(
                "the simulator is not installed: expected the extra of `pip install intellwheels[server]`"
            )
        self._start_simulator()
        link = Link(WORLD, connect=(self.endpoint,))
        stands = self.pace == "lockstep"
        self._watch = self._session.enter_context(watching(link, threading.Event(), listens=not stands))
        if stands:
            self.ctl("pause")
        self._look()

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
        """Start an agent as a process of its own and wait until it joined.

        Args:
            name: Its name.
            mind: A shipped mind, the path of a Python file, or the command of any program: its words, in which
                `{endpoint}`, `{world}` and `{name}` are replaced; they are in its environment too, as IW_ENDPOINT ...
            robot: Its body, a shipped robot or a path; default: the mind's own. Not for a command.
            place: Where it starts, a place of the floor; default: any that is free. Not for a command.
            encoding: What it speaks, `json` or `xml`. Not for a command.
            may_end: Whether it may end otherwise than with code 0 without the test failing.
            options: Options of the mind; with a capital letter, fields of its robot. Not for a command.

        Raises:
            AwaitedError: It did not join.
        """
        self._watched().look(self._history)
        since = self._history.wanted
        self._start_agent(name, mind, robot, place, encoding, options)
        if may_end:
            self._may_end.add(self._child(name))
        self._await_joined([name], since)

    def cast(self, *names: str) -> None:
        """Start agents of the scene, by default all, and wait until all of them joined.

        Raises:
            AwaitedError: One did not join, or there is no scene.
            LookupError: The scene has nobody of a name.
        """
        if self._scene is None or self._source is None:
            raise AwaitedError("cast: expected a scene, got a floor only")
        folder = Path(self._source).parent if Path(self._source).is_absolute() else None
        known = [cast.name for cast in self._scene.cast]
        for name in names:
            if name not in known:
                raise LookupError(f"cast: expected one of the scene's ({', '.join(known) or 'none'}), got {name!r}")
        wanted = [cast for cast in self._scene.cast if not names or cast.name in names]
        self._watched().look(self._history)
        since = self._history.wanted
        for cast in wanted:
            self._start_agent_of(cast, folder, "json")
        self._await_joined([cast.name for cast in wanted], since)

    def _await_joined(self, names: Iterable[str], since: int) -> None:
        missing = list(names)

        def joined() -> bool | None:
            self._check()
            self._look()
            come = {
                event.agent for event in self.events if event.code in ("joined", "returned") and event.number >= since
            }
            return True if come.issuperset(missing) else None

        self.processes.wait(joined, f"join of {', '.join(missing)}", unless=self._simulator)

    # ------------------------------------------------------------ time

    def run_until(self, condition: Callable[[Moment], object] | None = None, seconds: float = 20.0) -> Moment:
        """Let the world go on until a condition holds, and return the moment at which it did.

        In lockstep the condition sees every tick, and the world stands at that tick; at other paces it sees what is
        published.

        Args:
            condition: Is shown each moment, the present one first. None: the time alone. One that looks at a body that
                is not there does not hold.
            seconds: Simulated seconds after which it is given up.

        Raises:
            AwaitedError: The condition did not hold, the run came to its end, or a process died.
            ValueError: `seconds` is no time that ends.
        """
        __tracebackhide__ = True
        if not 0.0 <= seconds < math.inf:
            raise ValueError(f"seconds: expected simulated seconds from 0 on, got {seconds}")
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
                raise AwaitedError(f"{what}\n{now.describe()}")
        raise AssertionError("unreachable")  # moments go on or raise

    def run_for(self, seconds: float) -> Moment:
        """Let the world go on for so many simulated seconds and return the moment then.

        Raises:
            AwaitedError: The run came to its end, or a process died.
        """
        __tracebackhide__ = True
        return self.run_until(None, seconds)

    def _moments(self, begun: Moment, seconds: float) -> Iterator[Moment]:
        """Yield the moments after this one, without end; the world goes on as far as they are taken."""
        if self.pace == "lockstep":
            while True:
                yield self._step()
        factor = self._speed if self.pace == "realtime" else 1.0
        deadline = time.monotonic() + seconds / factor + DEADLINE
        watch, history = self._watched(), self._history
        history.fresh.clear()
        while True:
            self._check(SLICE)
            watch.pour(history)
            # The event may come before the state it is in.
            over = history.ended is not None
            if over:
                watch.look(history)
            while history.fresh:
                now = history.fresh.popleft()
                if over or now.tick != begun.tick:
                    yield now
            if over:
                raise AwaitedError(f"the run came to its end\n{self.now.describe()}")
            if time.monotonic() > deadline:
                raise AwaitedError(f"the simulated time does not go on\n{self.now.describe()}")

    def _step(self) -> Moment:
        try:
            result = self._watched().control("step", Step(count=1), DEADLINE)
        except ConnectionError as error:
            # The reason is in its log, once it is gone.
            self.processes.wait(lambda: self.processes.ended(self._simulator), f"answer of the simulator ({error})")
            self._check()
            raise
        if result.code == "failed":
            # It may be about to end; then its own words say why.
            with suppress(AwaitedError):
                self.processes.exit(self._simulator, GRACE)
        self._check()
        self._history.fresh.clear()
        self._look()
        if result.code != "ok":
            raise AwaitedError(f"the world does not go on: {result.text or result.code}\n{self._newest().describe()}")
        return self._newest()

    def ctl(self, verb: Verb, **fields: Any) -> Result:
        """Ask the simulator for a control verb, such as `ctl("delete", agent="chair1")`; return its answer.

        Args:
            verb: The verb.
            fields: Its fields by their names in `intellwheels_schemas.messages`.

        Raises:
            ConnectionError: There was no answer.
        """
        return self._watched().control(verb, VERB_CLASSES[verb](**fields), DEADLINE)

    # ------------------------------------------------------------ what is seen

    @property
    def now(self) -> Moment:
        """The world as it is, asked for."""
        self._look()
        return self._newest()

    @property
    def events(self) -> tuple[Event, ...]:
        """All events of the newest run, in order."""
        return self.now.events

    @property
    def contacts(self) -> list[tuple[str, str]]:
        """Who touched whom in the newest run, in order: two bodies, or a body and `wall`."""
        return self.now.contacts

    def pose(self, name: str) -> Point:
        """Return where a body is now.

        Raises:
            AbsentError: It is not there.
        """
        now = self.now
        body = now[name]
        return Point(now.time, body.x, body.y, body.heading)

    def path(self, name: str) -> list[Point]:
        """Return where a body was in the newest run: in lockstep at every tick, else as far as published.

        Raises:
            AbsentError: It was never there.
        """
        self._look()
        if name not in self._history.paths:
            there = ", ".join(self._history.paths) or "nobody"
            raise AbsentError(f"expected a body that was there ({there}), got {name!r}")
        return list(self._history.paths[name])

    # ------------------------------------------------------------ within, and what others do to it

    def restart_simulator(self) -> None:
        """Kill the simulator and start it anew; wait until all agents that live joined the new run.

        Raises:
            AwaitedError: One did not.
        """
        self._session.close()
        self._kill_simulator()
        self._history = History()
        awake = self._awake()
        # Who joins before the new world stands would make it go on by a chance number of ticks.
        with self._held(awake if self.pace == "lockstep" else ()):
            self._begin()
        self._await_joined(awake, 0)

    @contextmanager
    def _held(self, names: Iterable[str]) -> Iterator[None]:
        held = [self._child(name) for name in names]

        def signal_all(number: signal.Signals) -> None:
            for child in held:
                # One that is gone is not held; `_check` will say so.
                with suppress(ProcessLookupError):
                    self.processes.signal(child, number)

        signal_all(signal.SIGSTOP)
        try:
            yield
        finally:
            signal_all(signal.SIGCONT)

    def _watched(self) -> WorldWatch:
        if self._watch is None:
            raise ValueError("expected a rig that was entered with `with`")
        return self._watch

    def _look(self) -> None:
        self._watched().look(self._history)

    def _newest(self) -> Moment:
        if self._history.newest is None:
            raise AwaitedError(f"the simulator does not say how the world is\n{self.processes.report()}")
        return self._history.newest
