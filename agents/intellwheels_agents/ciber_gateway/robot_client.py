"""A robot in the world that an agent drives with datagrams: a mind of the contract, and the thread that runs it.

At each tick the agent gets its measures, and the mind waits a moment for what the agent answers. Its powers count until
it sends others. An agent that is silent for long leaves.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping
from typing import Final, NamedTuple

from intellwheels_agents.agent_peer import run_agent
from intellwheels_agents.ciber_gateway.client_messages import read_orders
from intellwheels_agents.ciber_gateway.client_socket import ClientSocket, Reports, shown_address
from intellwheels_agents.ciber_gateway.lab_frame import Lab
from intellwheels_agents.ciber_gateway.robot_state import RobotState
from intellwheels_agents.harness import PLACE_TAKEN
from intellwheels_agents.mind import Context
from intellwheels_agents.mind_error import USER_ERRORS
from intellwheels_schemas.codec import Encoding
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.link import Link
from intellwheels_schemas.messages import Actions, Measures, Robot
from intellwheels_schemas.process import SLICE, THREADS_END

MOST_A_TICK: Final = 64
"""Datagrams of a robot that are read in a tick."""
JOIN_WITHIN: Final = 10.0
"""Seconds to look for a simulator before an agent is refused."""
_GAP: Final = 1.0
"""Longest time between two ticks, s, that counts as silence of an agent: not a pause of the world."""


class Waits(NamedTuple):
    """How long things wait, in wall seconds.

    Attributes:
        answer: At each tick, for what the agent answers.
        silence: Until an agent that says nothing leaves.
    """

    answer: float = 0.02
    silence: float = 60.0


class CiberMind:
    """Drives one robot in one run."""

    def __init__(
        self, state: RobotState, client: ClientSocket, reports: Reports, waits: Waits,
        numbers: Callable[[], Mapping[str, int]], stop: threading.Event,
    ) -> None:  # fmt: skip
        """Begin a run.

        Args:
            state: The robot.
            client: Its agent.
            reports: Takes what is not obeyed.
            waits: How long it waits.
            numbers: Returns the numbers of all robots by agent.
            stop: Ends a wait.
        """
        self._state = state
        self._client = client
        self._reports = reports
        self._waits = waits
        self._numbers = numbers
        self._stop = stop
        self._silent = 0.0
        self._last = time.monotonic()

    def decide(self, measures: Measures) -> Actions:
        """Send the measures, and return the powers that the agent wants."""
        now = time.monotonic()
        self._silent += min(now - self._last, _GAP)
        self._last = now
        # What came before these measures does not answer them, but counts.
        self._take()
        self._client.send(self._state.sense(measures, self._numbers()))
        deadline = now + self._waits.answer
        while (left := deadline - time.monotonic()) > 0.0 and not self._stop.is_set():
            if self._client.wait(min(left, SLICE)) and self._take():
                break
        actions = self._state.actions()
        if self._silent > self._waits.silence:
            self._reports.tell("silent agent", shown_address(self._client.client), "it leaves")
            self._stop.set()
        return actions

    def _take(self) -> bool:
        """Read what has arrived; return whether any of it were orders."""
        orders = False
        for _ in range(MOST_A_TICK):
            data = self._client.receive()
            if data is None:
                break
            self._silent = 0.0
            who = shown_address(self._client.client)
            try:
                taken = read_orders(data)
            except WireError as error:
                self._reports.tell("actions", who, error.text)
                continue
            orders = True
            refused = self._state.obey(taken)
            if taken.unsaid:
                self._reports.tell("message of a robot", who, taken.unsaid)
            if refused:
                self._reports.tell("sensor requests", who, f"{refused} too many, or of no sensor")
        return orders


class RobotClient:
    """A robot with its agent, from its registration to its end.

    Attributes:
        state: The robot.
        client: Its agent.
        reply: What its agent was told when it joined; empty before.
    """

    def __init__(
        self, state: RobotState, client: ClientSocket, documents: Mapping[int, Robot], *, where: Link,
        reports: Reports, waits: Waits, lab: Callable[[], Lab], numbers: Callable[[], Mapping[str, int]],
        claim: Callable[[RobotClient, int], bool], joined: Callable[[RobotClient, Robot, float], None],
        over: Callable[[RobotClient, bool], None], tell: Callable[[str], None],
    ) -> None:  # fmt: skip
        """Take a robot that an agent has registered.

        Args:
            state: The robot.
            client: Its agent.
            documents: What to join with, by number; the next is tried if the place of one is taken.
            where: The link to the world.
            reports: Takes what is not obeyed.
            waits: How long it waits.
            lab: Returns the lab.
            numbers: Returns the numbers of all robots by agent.
            claim: Called before a number is tried; returns whether no other robot has it.
            joined: Called once when it has joined, with the robot as it was accepted and the seconds of a cycle.
            over: Called at its end, with whether it had joined.
            tell: Takes the lines that scripts wait for.
        """
        self.state = state
        self.client = client
        self.reply = b""
        self._documents = documents
        self._where = where
        self._reports = reports
        self._waits = waits
        self._lab = lab
        self._numbers = numbers
        self._claim = claim
        self._joined = joined
        self._over = over
        self._tell = tell
        self._is_in = False
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name=f"robot {state.agent}", daemon=True)

    def start(self) -> None:
        """Join in a thread of its own."""
        self._thread.start()

    def stop(self) -> None:
        """Let it leave."""
        self._stop.set()

    def join(self) -> None:
        """Wait for its end."""
        self._thread.join(THREADS_END)

    def _run(self) -> None:
        try:
            for number, document in self._documents.items():
                if not self._claim(self, number):
                    continue
                code = run_agent(
                    document, self._make, {}, where=self._where, encoding=Encoding.JSON, retry_for=JOIN_WITHIN,
                    stop=self._stop, tell=self._tell,
                )  # fmt: skip
                if self._is_in or code != PLACE_TAKEN or self._stop.is_set():
                    break
        except (*USER_ERRORS, WireError, ConnectionError) as error:
            self._reports.tell("robot", shown_address(self.client.client), str(error))
        finally:
            self._over(self, self._is_in)

    def _make(self, context: Context) -> CiberMind:
        self.state.begin(context.robot, context.parameters.period, context.run, self._lab())
        if not self._is_in:
            self._is_in = True
            self._joined(self, context.robot, context.parameters.period)
        return CiberMind(self.state, self.client, self._reports, self._waits, self._numbers, self._stop)
