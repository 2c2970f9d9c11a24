"""The processes of a test's world: a simulator, perhaps a router, and agents, with the faults that can hit them.

It does not use the network. `rig` observes who joined and what the world does.
"""

from __future__ import annotations

import signal
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Final

from intellwheels_experiments.run.child_processes import READY_LIMIT, REPORT_LINES, ChildProcesses, WaitError
from intellwheels_experiments.run.endpoints import free_endpoint
from intellwheels_experiments.run.foreign_program import check_program, check_programs, launch_agent, launch_program
from intellwheels_experiments.run.launch_spec import SERVER, agent_child, agent_command, link_arguments
from intellwheels_experiments.run.program_restarts import ProgramRestarts
from intellwheels_experiments.run.start_watch import await_ready
from intellwheels_schemas.command_line import check_placeholders, filled
from intellwheels_schemas.messages import Cast, Option
from intellwheels_schemas.names import check_agent

WORLD: Final = "test"
"""The name of a test's world."""
ROUTER: Final = "router"
"""The router's name among the children."""
GRACE: Final = 2.0
"""Seconds that a process has to end by itself when the test is over."""


class ProcessGroup:
    """A simulator, perhaps a router, and agents, each by its name. The simulator is called `simulator`.

    Args:
        logs: The folder of their logs.
        arguments: The simulator's arguments besides its world and endpoints.
        router: Whether the agents connect to the simulator through a router.
        folder: Where relative paths start; None: the working directory.

    Attributes:
        endpoint: Where the simulator listens.
        processes: The child processes.
    """

    def __init__(self, logs: Path, arguments: Sequence[str], *, router: bool, folder: Path | None) -> None:
        self.endpoint = free_endpoint()
        self._router = free_endpoint() if router else None
        link = link_arguments(WORLD, [self.endpoint], [self._router] if self._router else ())
        self._arguments = [*link, *arguments]
        self._folder = folder
        self.processes = ChildProcesses(logs)
        self._simulator = SERVER
        self._router_child = ROUTER
        self._agents: dict[str, str] = {}
        self._folders: dict[str, Path | None] = {}
        self._restarts = ProgramRestarts(
            self.processes, lambda cast: self._launch_cast(cast, self._folders[cast.name], "json")
        )
        self._may_end: set[str] = set()
        self._frozen: set[str] = set()

    def close(self) -> None:
        """End all processes, the agents first, so that the simulator learns that they leave.

        A second call does nothing.
        """
        running = set(self.processes.running)
        self.processes.end([child for child in self._agents.values() if child in running], GRACE)
        self.processes.close(GRACE)

    @property
    def has_router(self) -> bool:
        """Whether the agents connect to the simulator through a router."""
        return self._router is not None

    def log(self, name: str) -> str:
        """Return everything that an agent printed. The names `simulator` and `router` work too.

        Raises:
            LookupError: No process of this name was started.
        """
        return self.processes.log(self._child(name))

    def sections(self) -> list[tuple[str, str]]:
        """Return for each process a title, its name and state, and the last lines of its log."""
        self.processes.receive()
        return self.processes.sections()

    # ------------------------------------------------------------ faults

    def kill(self, name: str) -> None:
        """Kill an agent's process with SIGKILL and wait until it is gone. It cannot say that it leaves.

        Raises:
            LookupError: No process of this name was started.
            WaitError: It is gone already.
        """
        child = self._child(name)
        self._may_end.add(child)
        self._signal(child, signal.SIGKILL)
        self._frozen.discard(name)
        self.processes.exit(child)

    def exit(self, name: str) -> int:
        """Wait until an agent's process ends by itself.

        Returns:
            Its exit code, or the negative number of the signal that ended it.

        Raises:
            LookupError: No process of this name was started.
            WaitError: It did not end.
        """
        child = self._child(name)
        self._may_end.add(child)
        return self.processes.exit(child)

    def freeze(self, name: str) -> None:
        """Stop an agent's process with SIGSTOP, until `thaw`.

        Raises:
            LookupError: No process of this name was started.
            WaitError: It is gone already.
        """
        self._signal(self._child(name), signal.SIGSTOP)
        self._frozen.add(name)

    def thaw(self, name: str) -> None:
        """Let a frozen agent's process continue.

        Raises:
            LookupError: No process of this name was started.
            WaitError: It is gone already.
        """
        self._signal(self._child(name), signal.SIGCONT)
        self._frozen.discard(name)

    def end_simulator(self) -> int:
        """Send the simulator SIGTERM and wait until it has ended and written its log; return its exit code.

        Raises:
            WaitError: It is gone already, or it did not end.
        """
        self._may_end.add(self._simulator)
        self._signal(self._simulator, signal.SIGTERM)
        return self.processes.exit(self._simulator)

    def cut_router(self) -> None:
        """Kill the router. Agents and simulator no longer reach each other.

        In lockstep the world then waits for the agents, so test a cut at pace `realtime`, or with miss `elastic`.

        Raises:
            ValueError: The world has no router.
            WaitError: The router is gone already.
        """
        self._check_router()
        self._may_end.add(self._router_child)
        self._signal(self._router_child, signal.SIGKILL)
        self.processes.exit(self._router_child)

    def mend_router(self) -> None:
        """Start the router again and wait until it is ready. Agents and simulator reconnect by themselves.

        Raises:
            ValueError: The world has no router.
            WaitError: It did not get ready.
        """
        meeting = self._check_router()
        self._router_child = self.processes.start(ROUTER, "intellwheels_server.service.router", "--listen", meeting)
        self.processes.line(self._router_child, "ready")

    # ------------------------------------------------------------ internals

    def _start_simulator(self) -> None:
        self._simulator = self.processes.start(SERVER, "intellwheels_server", *self._arguments)
        await_ready(self.processes, self._simulator, READY_LIMIT)

    def _kill_simulator(self) -> None:
        self._may_end.add(self._simulator)
        if self.processes.exited(self._simulator) is None:
            self._signal(self._simulator, signal.SIGKILL)
        self.processes.exit(self._simulator)

    def _start_agent(
        self,
        name: str,
        mind: str | Sequence[str],
        robot: str | None,
        place: str | None,
        encoding: str,
        options: Mapping[str, object],
    ) -> None:
        check_agent(name, "name")
        given = tuple(Option(name=option, value=_text(value)) for option, value in options.items())
        if isinstance(mind, str):
            cast = Cast(name=name, robot=robot or "", mind=mind, place=place, option=given)
            self._start_cast(cast, self._folder, encoding)
            return
        if robot or place or given:
            raise ValueError(
                f"agent {name!r}: expected no robot, place or options with a command; put them into the command"
            )
        check_placeholders(mind, "mind")
        folder = (self._folder or Path()).absolute()
        check_program(filled(mind[0], {"name": name}), folder, "mind")
        self._agents[name] = launch_program(
            self.processes, agent_child(name), mind, {"name": name, **self._values}, folder
        )

    def _start_cast(self, cast: Cast, folder: Path | None, encoding: str) -> None:
        check_programs([cast], folder)
        self._folders[cast.name] = folder
        self._restarts.add(cast, self._launch_cast(cast, folder, encoding))

    def _launch_cast(self, cast: Cast, folder: Path | None, encoding: str) -> str:
        arguments = [*link_arguments(WORLD, connect=[self._meeting]), "--encoding", encoding]
        command = agent_command(cast, folder, arguments)
        child = launch_agent(
            self.processes, cast, lambda lifeline: [*command, "--lifeline", str(lifeline)], self._values, folder
        )
        self._agents[cast.name] = child
        return child

    @property
    def _values(self) -> dict[str, str]:
        """What replaces the placeholders in a command, besides the name."""
        return {"endpoint": self._meeting, "world": WORLD}

    @property
    def _meeting(self) -> str:
        """The endpoint to which the agents connect."""
        return self._router or self.endpoint

    def _awake(self) -> list[str]:
        """Return the agents whose processes run and are not frozen."""
        self.processes.receive()
        running = {name for name, child in self._agents.items() if self.processes.exited(child) is None}
        return sorted(running - self._frozen)

    @contextmanager
    def _stopped(self, names: Iterable[str]) -> Iterator[None]:
        """Stop the processes of agents while the `with` runs."""
        children = [self._child(name) for name in names]

        def signal_all(number: signal.Signals) -> None:
            for child in children:
                # `_check` reports a process that has ended.
                with suppress(ProcessLookupError):
                    self.processes.signal(child, number)

        signal_all(signal.SIGSTOP)
        try:
            yield
        finally:
            signal_all(signal.SIGCONT)

    def _child(self, name: str) -> str:
        special = {"simulator": self._simulator} | ({"router": self._router_child} if self._router else {})
        if name not in self._agents and name not in special:
            started = ", ".join(self._agents) or "none"
            raise LookupError(f"expected one of the agents that were started ({started}), got {name!r}")
        return self._agents.get(name) or special[name]

    def _check_router(self) -> str:
        """Return the router's endpoint."""
        if self._router is None:
            raise ValueError("expected a world with router=True")
        return self._router

    def _signal(self, child: str, number: signal.Signals) -> None:
        """Send a signal to a process that must still run."""
        with suppress(ProcessLookupError):
            self.processes.receive()
            if self.processes.exited(child) is None:
                self.processes.signal(child, number)
                return
        exited = self.processes.wait(lambda: self.processes.exited(child), f"end of {child}")
        raise WaitError(f"{child}: expected a running process, got {exited.how}; {self._last_lines(child)}")

    def _check(self, timeout: float = 0.0) -> None:
        """Fail if a process ended that should not have. Wait up to `timeout` seconds for output or exits."""
        self.processes.receive(timeout)
        for child in (self._simulator, *self._agents.values()):
            exited = self.processes.exited(child)
            if exited is not None and child not in self._may_end and (exited.code != 0 or child == self._simulator):
                raise WaitError(f"{child}: {exited.how}; {self._last_lines(child)}")

    def _last_lines(self, child: str) -> str:
        return "its last lines:\n" + "\n".join(self.processes.tail(child, REPORT_LINES))


def _text(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)
