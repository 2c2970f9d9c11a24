"""A simulator, agents and faults for a test, as real processes. It knows no test framework; `plugin` is for pytest.

In lockstep the world stands between calls and goes one step at a time within them: every tick is looked at, and none
is made beyond the one at which a condition held. At the other paces it goes on by itself and what it publishes is
looked at. Nothing is waited for by sleeping, and every wait has a deadline.
"""

from __future__ import annotations

import importlib.util
import signal
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack
from itertools import chain
from pathlib import Path
from typing import Any, Final, Self

from intellwheels_experiments.children import Exited
from intellwheels_experiments.film import AbsentError, Film, Moment, Point
from intellwheels_experiments.plan import SERVER, agent_child, agent_command, filled, link_words, resolved
from intellwheels_experiments.processes import DEADLINE, SLICE, AwaitedError, Processes, free_port
from intellwheels_experiments.watch import Watch, watching
from intellwheels_maps import scene as scene_file
from intellwheels_schemas.channels import VERB_CLASSES
from intellwheels_schemas.keys import Verb
from intellwheels_schemas.link import Link
from intellwheels_schemas.messages import Cast, Event, Miss, Option, Pace, Result, Step
from intellwheels_schemas.names import check_agent

WORLD: Final = "test"
ROUTER: Final = "router"
GRACE: Final = 2.0
"""Seconds a process has to end by itself when the test is over."""
READY_LIMIT: Final = 180.0
"""Seconds for the simulator to be ready: a first start compiles its kernels, on a small machine slowly."""
HALF: Final = 1e-9
"""Seconds by which a simulated time may be short of what was asked for: sums of periods round."""


class Rig:
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
        self._folder = folder
        self._source = None if scene is None else resolved(scene, folder)
        self._scene = None if self._source is None else scene_file(self._source)
        self.pace: Pace = pace or (self._scene.pace if self._scene else "lockstep")
        self._speed = speed
        self.endpoint = f"tcp/127.0.0.1:{free_port()}"
        self._router = f"tcp/127.0.0.1:{free_port()}" if router else None
        self._words = [*link_words(WORLD, [self.endpoint], [self._router] if self._router else ()), "--pace", self.pace]
        if self._source is not None:
            self._words += ["--scene", self._source]
        for option, value in (("--map", floor and resolved(floor, folder)), ("--seed", seed), ("--miss", miss)):
            self._words += [option, value] if value is not None else []
        if self.pace == "realtime":
            self._words += ["--speed", repr(speed)]
        if self.pace == "free":
            self._words += ["--open-loop"]
        self._words += words
        self.processes = Processes(logs)
        self._simulator = SERVER
        self._router_child = ROUTER
        self._agents: dict[str, str] = {}
        self._may_end: set[str] = set()
        self._frozen: set[str] = set()
        self._film = Film()
        self._watch: Watch | None = None
        self._session = ExitStack()

    # ------------------------------------------------------------ start and end

    def __enter__(self) -> Self:
        try:
            if self._router is not None:
                self.mend_router()
            self._start_simulator()
        except BaseException:
            self.close()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End everything: the agents first, for they leave in words. More than once does nothing."""
        self._session.close()
        living = set(self.processes.children.living)
        self.processes.children.end([child for child in self._agents.values() if child in living], GRACE)
        self.processes.close(GRACE)

    def _start_simulator(self) -> None:
        if importlib.util.find_spec("numba") is None:
            raise AwaitedError(
                "the simulator is not installed: expected the extra of `pip install intellwheels[server]`"
            )
        self._simulator = self.processes.start(SERVER, "intellwheels_server", *self._words)
        self.processes.line(self._simulator, "ready", READY_LIMIT)
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
        self._watched().look(self._film)
        since = self._film.wanted
        self._start_agent(name, mind, robot, place, encoding, options)
        if may_end:
            self._may_end.add(self._agents[name])
        self._await_joined([name], since)

    def cast(self, *names: str) -> None:
        """Start agents of the scene, by default all, and wait until all of them joined.

        Raises:
            AwaitedError: One did not join, or there is no scene.
        """
        if self._scene is None or self._source is None:
            raise AwaitedError("cast: expected a scene, got a floor only")
        folder = Path(self._source).parent if Path(self._source).is_absolute() else None
        wanted = [cast for cast in self._scene.cast if not names or cast.name in names]
        self._watched().look(self._film)
        since = self._film.wanted
        for cast in wanted:
            self._start_agent_of(cast, folder, "json")
        self._await_joined([cast.name for cast in wanted], since)

    def _start_agent(
        self,
        name: str,
        mind: str | Sequence[str],
        robot: str | None,
        place: str | None,
        encoding: str,
        options: dict[str, object],
    ) -> None:
        given = tuple(Option(name=option, value=_text(value)) for option, value in options.items())
        if isinstance(mind, str):
            cast = Cast(name=check_agent(name, "name"), robot=robot or "", mind=mind, place=place, option=given)
            self._start_agent_of(cast, self._folder, encoding)
            return
        if robot or place or given:
            raise ValueError(
                f"agent {name!r}: a command has neither robot, place nor options; give it words of its own"
            )
        values = {"endpoint": self._meeting, "world": WORLD, "name": name}
        command = [filled(word, values) for word in mind]
        environment = {f"IW_{key.upper()}": value for key, value in values.items()}
        self._agents[name] = self.processes.launch(agent_child(name), lambda _: command, environment)

    def _start_agent_of(self, cast: Cast, folder: Path | None, encoding: str) -> None:
        words = [*link_words(WORLD, connect=[self._meeting]), "--encoding", encoding]
        command = agent_command(cast, folder, words)
        self._agents[cast.name] = self.processes.launch(
            agent_child(cast.name), lambda lifeline: [*command, "--lifeline", str(lifeline)]
        )

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

    @property
    def _meeting(self) -> str:
        return self._router or self.endpoint

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
        """
        __tracebackhide__ = True
        begun = self.now
        until = begun.time + seconds - HALF
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
        watch, film = self._watched(), self._film
        film.fresh.clear()
        while True:
            self._check(SLICE)
            watch.pour(film)
            while film.fresh:
                now = film.fresh.popleft()
                if (now.tick, now.time) != (begun.tick, begun.time):
                    yield now
            if film.ended is not None and not film.fresh:
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
        self._check()
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
        if name not in self._film.paths:
            there = ", ".join(self._film.paths) or "nobody"
            raise AbsentError(f"expected a body that was there ({there}), got {name!r}")
        return list(self._film.paths[name])

    def log(self, name: str) -> str:
        """Return what an agent printed; of `simulator` and `router` what they did."""
        return self.processes.log(self._child(name))

    def sections(self) -> list[tuple[str, str]]:
        """Return the last lines of all logs, each behind its name, for a report."""
        self.processes.hear()
        return self.processes.sections()

    # ------------------------------------------------------------ faults

    def kill(self, name: str) -> None:
        """Kill an agent's process at once and wait until it is gone; it says no word to anybody."""
        child = self._child(name)
        self._may_end.add(child)
        self.processes.signal(child, signal.SIGKILL)
        self.processes.exit(child)

    def exit(self, name: str) -> int:
        """Wait for an agent's process to end by itself and return its exit code; negative: by which signal."""
        child = self._child(name)
        self._may_end.add(child)
        return self.processes.exit(child)

    def freeze(self, name: str) -> None:
        """Stop an agent's process where it is, until `thaw`."""
        self._frozen.add(name)
        self.processes.signal(self._child(name), signal.SIGSTOP)

    def thaw(self, name: str) -> None:
        """Let a frozen agent's process go on."""
        self.processes.signal(self._child(name), signal.SIGCONT)
        self._frozen.discard(name)

    def restart_simulator(self) -> None:
        """Kill the simulator and start it anew; wait until all agents that live joined the new run.

        Raises:
            AwaitedError: One did not.
        """
        self._session.close()
        self._may_end.add(self._simulator)
        self.processes.signal(self._simulator, signal.SIGKILL)
        self.processes.exit(self._simulator)
        self._film = Film()
        self._start_simulator()
        self.processes.hear()
        living = [
            name
            for name, child in self._agents.items()
            if self.processes.ended(child) is None and name not in self._frozen
        ]
        self._await_joined(living, 0)

    def end_simulator(self) -> int:
        """Tell the simulator to end, wait until it did, its log written, and return its exit code."""
        self._may_end.add(self._simulator)
        self.processes.signal(self._simulator, signal.SIGTERM)
        return self.processes.exit(self._simulator)

    def cut_router(self) -> None:
        """Kill the router: agents and simulator no longer hear one another.

        In lockstep the world then waits for the agents: a test of a cut is one at pace `realtime`, or `elastic`.
        """
        self._may_end.add(self._router_child)
        self.processes.signal(self._router_child, signal.SIGKILL)
        self.processes.exit(self._router_child)

    def mend_router(self) -> None:
        """Start the router again and wait until it is ready; agents and simulator find it by themselves."""
        if self._router is None:
            raise ValueError("expected a world with router=True")
        self._router_child = self.processes.start(ROUTER, "intellwheels_server.router", "--listen", self._router)
        self.processes.line(self._router_child, "ready")

    # ------------------------------------------------------------ within

    def _child(self, name: str) -> str:
        special = {"simulator": self._simulator, "router": self._router_child}
        if name not in self._agents and name not in special:
            raise LookupError(f"expected an agent that was started ({', '.join(self._agents) or 'none'}), got {name!r}")
        return self._agents.get(name) or special[name]

    def _watched(self) -> Watch:
        if self._watch is None:
            raise ValueError("expected a rig that was entered with `with`")
        return self._watch

    def _look(self) -> None:
        self._watched().look(self._film)

    def _newest(self) -> Moment:
        if self._film.newest is None:
            raise AwaitedError(f"the simulator does not say how the world is\n{self.processes.report()}")
        return self._film.newest

    def _check(self, timeout: float = 0.0) -> None:
        """Fail when a process ended that should not have."""
        self.processes.hear(timeout)
        for child in (self._simulator, *self._agents.values()):
            gone: Exited | None = self.processes.ended(child)
            if gone is not None and child not in self._may_end and (gone.code != 0 or child == self._simulator):
                raise AwaitedError(f"{child}: {gone.how}; its last lines:\n{self.processes.tail(child)}")


def _text(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)
