"""Starts programs again when a new run begins, if the scene says so, because they do not follow a new `Run`.

The world is paused meanwhile and then begins once more, so that every agent starts at the same tick. After a restore
there is no other beginning: a program that was started again takes over the body where it is.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, Protocol

from intellwheels_experiments.run.child_processes import ChildProcesses
from intellwheels_experiments.run.launch_spec import agent_child
from intellwheels_experiments.run.run_record import RunRecord
from intellwheels_schemas.keys import Verb
from intellwheels_schemas.messages import Cast, Delete, Pause, Record, Reset, Result, Resume

ANSWER_LIMIT: Final = 10.0
"""Seconds for the simulator to answer a control verb."""


class Controls(Protocol):
    """Receives what a world publishes, and asks its simulator for control verbs."""

    def query_all(self, record: RunRecord) -> None:
        """Ask the simulator for its clock, the present state and the events that were missed."""

    def control(self, verb: Verb, message: Record, timeout: float) -> Result:
        """Ask the simulator for a control verb and return its answer."""


class ProgramRestarts:
    """The programs of a run that are started again when its world begins a new run.

    Args:
        children: All processes.
        start: Starts an agent and returns the name of its child.
    """

    def __init__(self, children: ChildProcesses, start: Callable[[Cast], str]) -> None:
        self._children = children
        self._start = start
        self._started: dict[str, tuple[Cast, str]] = {}
        self._ended: tuple[str, ...] = ()
        self._seen: set[str] = set()

    def add(self, cast: Cast, child: str) -> None:
        """Take note of an agent that was started."""
        if cast.new_run == "restart":
            self._started[cast.name] = cast, child

    def child_of(self, agent: str) -> str:
        """Return the name of the child that is this agent now."""
        _, child = self._started.get(agent, (None, agent_child(agent)))
        return child

    def follow(self, record: RunRecord, controls: Controls) -> bool:
        """Start the programs again if the record shows another run than before; return whether they were.

        Raises:
            ConnectionError: The simulator does not answer.
        """
        if not self._started or record.run is None or record.run in self._seen:
            return False
        self._seen.add(record.run)
        if len(self._seen) == 1:
            return False
        was_paused = record.clock is not None and record.clock.state == "paused"
        controls.control("pause", Pause(), ANSWER_LIMIT)
        controls.query_all(record)
        ended = self.end()
        texts = [event.text or "" for event in record.events.values() if event.code == "reset"]
        # The queries may have brought a newer run; its programs are those that start now.
        self._seen.add(record.run)
        if not any(text.startswith("restored") for text in texts):
            for name in ended:
                controls.control("delete", Delete(agent=name), ANSWER_LIMIT)
            begun = controls.control("reset", Reset(), ANSWER_LIMIT).run
            if begun is not None:
                self._seen.add(begun)
        self.start_ended()
        if not was_paused:
            controls.control("resume", Resume(), ANSWER_LIMIT)
        return True

    def end(self) -> tuple[str, ...]:
        """End the programs and return their agents."""
        self._children.dismiss([child for _, child in self._started.values()])
        self._ended = tuple(self._started)
        return self._ended

    def start_ended(self) -> None:
        """Start the programs that were ended."""
        for name in self._ended:
            cast, _ = self._started[name]
            self._started[name] = cast, self._start(cast)
        self._ended = ()
