"""The processes of a world under test by the names of its agents, and what may happen to them.

It knows no network: who joined and what the world does is `rig`'s.
"""

from __future__ import annotations

import signal
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Final

from intellwheels_experiments.run.launch_spec import SERVER, agent_child, agent_command, filled, link_words
from intellwheels_experiments.run.run_processes import AwaitedError, RunProcesses, free_port
from intellwheels_schemas.messages import Cast, Option
from intellwheels_schemas.names import check_agent

WORLD: Final = "test"
ROUTER: Final = "router"
GRACE: Final = 2.0
"""Seconds a process has to end by itself when the test is over."""
READY_LIMIT: Final = 180.0
"""Seconds for the simulator to be ready: a first start compiles its kernels, on a small machine slowly."""


class ProcessGroup:
    """A simulator, perhaps a router, and agents.

    Args:
        logs: The folder of their logs.
        words: What the simulator is told beside world and endpoints.
        router: Whether the agents meet the simulator at a router.
        folder: Where relative paths start from; None: the working directory.

    Attributes:
        endpoint: Where the simulator listens.
        processes: The processes.
    """

    def __init__(self, logs: Path, words: Sequence[str], *, router: bool, folder: Path | None) -> None:
        self.endpoint = f"tcp/127.0.0.1:{free_port()}"
        self._router = f"tcp/127.0.0.1:{free_port()}" if router else None
        self._words = [*link_words(WORLD, [self.endpoint], [self._router] if self._router else ()), *words]
        self._folder = folder
        self.processes = RunProcesses(logs)
        self._simulator = SERVER
        self._router_child = ROUTER
        self._agents: dict[str, str] = {}
        self._may_end: set[str] = set()
        self._frozen: set[str] = set()

    def close(self) -> None:
        """End all processes, the agents first: they leave in words. More than once does nothing."""
        living = set(self.processes.children.living)
        self.processes.children.end([child for child in self._agents.values() if child in living], GRACE)
        self.processes.close(GRACE)

    @property
    def has_router(self) -> bool:
        """Whether the agents meet the simulator at a router."""
        return self._router is not None

    def log(self, name: str) -> str:
        """Return what an agent printed; of `simulator` and `router` what they did."""
        return self.processes.log(self._child(name))

    def sections(self) -> list[tuple[str, str]]:
        """Return the last lines of all logs, each behind its name, for a report."""
        self.processes.hear()
        return self.processes.sections()

    # ------------------------------------------------------------ faults

    def kill(self, name: str) -> None:
        """Kill an agent's process at once and wait until it is gone; it says no word to anybody.

        Raises:
            AwaitedError: It is gone already, as of every fault.
        """
        child = self._child(name)
        self._may_end.add(child)
        self._signal(child, signal.SIGKILL)
        self._frozen.discard(name)
        self.processes.exit(child)

    def exit(self, name: str) -> int:
        """Wait for an agent's process to end by itself and return its exit code; negative: by which signal."""
        child = self._child(name)
        self._may_end.add(child)
        return self.processes.exit(child)

    def freeze(self, name: str) -> None:
        """Stop an agent's process where it is, until `thaw`."""
        self._signal(self._child(name), signal.SIGSTOP)
        self._frozen.add(name)

    def thaw(self, name: str) -> None:
        """Let a frozen agent's process go on."""
        self._signal(self._child(name), signal.SIGCONT)
        self._frozen.discard(name)

    def end_simulator(self) -> int:
        """Tell the simulator to end, wait until it did, its log written, and return its exit code."""
        self._may_end.add(self._simulator)
        self._signal(self._simulator, signal.SIGTERM)
        return self.processes.exit(self._simulator)

    def cut_router(self) -> None:
        """Kill the router: agents and simulator no longer hear one another.

        In lockstep the world then waits for the agents: a test of a cut is one at pace `realtime`, or `elastic`.
        """
        self._check_router()
        self._may_end.add(self._router_child)
        self._signal(self._router_child, signal.SIGKILL)
        self.processes.exit(self._router_child)

    def mend_router(self) -> None:
        """Start the router again and wait until it is ready; agents and simulator find it by themselves."""
        self._check_router()
        self._router_child = self.processes.start(
            ROUTER, "intellwheels_server.service.router", "--listen", self._meeting
        )
        self.processes.line(self._router_child, "ready")

    # ------------------------------------------------------------ within

    def _start_simulator(self) -> None:
        self._simulator = self.processes.start(SERVER, "intellwheels_server", *self._words)
        self.processes.line(self._simulator, "ready", READY_LIMIT)

    def _kill_simulator(self) -> None:
        self._may_end.add(self._simulator)
        if self.processes.ended(self._simulator) is None:
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

    @property
    def _meeting(self) -> str:
        return self._router or self.endpoint

    def _awake(self) -> list[str]:
        """Return the agents whose processes run."""
        self.processes.hear()
        running = {name for name, child in self._agents.items() if self.processes.ended(child) is None}
        return sorted(running - self._frozen)

    def _child(self, name: str) -> str:
        special = {"simulator": self._simulator} | ({"router": self._router_child} if self._router else {})
        if name not in self._agents and name not in special:
            raise LookupError(f"expected an agent that was started ({', '.join(self._agents) or 'none'}), got {name!r}")
        return self._agents.get(name) or special[name]

    def _check_router(self) -> None:
        if self._router is None:
            raise ValueError("expected a world with router=True")

    def _signal(self, child: str, number: signal.Signals) -> None:
        """Send a process that must still be there a signal."""
        with suppress(ProcessLookupError):
            self.processes.hear()
            if self.processes.ended(child) is None:
                self.processes.signal(child, number)
                return
        gone = self.processes.wait(lambda: self.processes.ended(child), f"end of {child}")
        tail = self.processes.tail(child)
        raise AwaitedError(f"{child}: expected a process that runs, got {gone.how}; its last lines:\n{tail}")

    def _check(self, timeout: float = 0.0) -> None:
        """Fail when a process ended that should not have."""
        self.processes.hear(timeout)
        for child in (self._simulator, *self._agents.values()):
            gone = self.processes.ended(child)
            if gone is not None and child not in self._may_end and (gone.code != 0 or child == self._simulator):
                raise AwaitedError(f"{child}: {gone.how}; its last lines:\n{self.processes.tail(child)}")


def _text(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)
