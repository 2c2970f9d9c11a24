"""Sends the input of pages to chairs, and keeps the leases of `--take`. Lease requests wait on threads of their own."""

from __future__ import annotations

import queue
from collections.abc import Callable, Mapping
from typing import Any, Final

import msgspec

from intellwheels_agents.joystick.lease_client import LeaseClient
from intellwheels_agents.record_gateway.publish_panel import PublishPanel
from intellwheels_schemas import link
from intellwheels_schemas.channels import CHANNELS
from intellwheels_schemas.codec import Encoding, decode, encode, encoding_of
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import Result, Robot, Take, UserInput
from intellwheels_schemas.process import start_network_thread

ANSWER_TIMEOUT: Final = 1.5
"""Seconds to wait for a lease: less than a lease lasts."""


class PanelDriver:
    """Drives chairs by what pages publish.

    Args:
        session: An open session.
        keys: The keys of the world.
        panel: What pages publish.
        take: Whether chairs are taken from their minds while input comes.
        log: Takes lines for the log of the process.
    """

    def __init__(
        self, session: Any, keys: Keys, panel: PublishPanel, *, take: bool, log: Callable[[str], None]
    ) -> None:
        self._session = session
        self._keys = keys
        self._panel = panel
        self._take = take
        self._log = log
        self._publishers: dict[str, Any] = {}
        self._leases: dict[str, LeaseClient] = {}
        self._answers: queue.SimpleQueue[tuple[str, Result | None]] = queue.SimpleQueue()

    def work(self, robots: Mapping[str, Robot], now: float) -> None:
        """Send what is due."""
        while not self._answers.empty():
            agent, result = self._answers.get()
            if agent in self._leases:
                self._leases[agent].answered(result, now)
        inputs, wrong = self._panel.inputs(robots, now)
        for text in wrong:
            self._log(f"ignored why={text!r}")
        for agent, user in inputs:
            self._send(agent, user, robots[agent], now) if agent in robots else None

    def _send(self, agent: str, user: UserInput, robot: Robot, now: float) -> None:
        if self._take:
            lease = self._leases.setdefault(agent, LeaseClient(agent))
            if lease.failure:
                self._log(f"not taken agent={agent} why={lease.failure!r}")
                self._leases.pop(agent)
                return
            request = lease.request(now)
            if request is not None:
                self._ask(agent, request)
            if lease.lease is None:
                return
            user = msgspec.structs.replace(user, lease=lease.lease)
        elif agent not in self._publishers and not {"drive", "words"}.intersection(robot.user_input):
            self._log(f"ignored agent={agent} why='its robot declares no user input; --take drives it anyway'")
        publisher = self._publishers.get(agent)
        if publisher is None:
            publisher = link.declare(self._session, self._keys.user(agent), CHANNELS["user"], Encoding.JSON)
            self._publishers[agent] = publisher
        publisher.put(encode(user))

    def _ask(self, agent: str, request: Take) -> None:
        def ask() -> None:
            try:
                answer = link.query(
                    self._session, self._keys.ctl_of("take", request), encode(request), timeout=ANSWER_TIMEOUT
                )[0]
                result = decode(Result, answer.data, encoding_of(answer.encoding, answer.data), strict=False)
            except (ConnectionError, WireError) as error:
                self._log(f"unanswered verb=take why={str(error)!r}")
                self._answers.put((agent, None))
            else:
                self._answers.put((agent, result))

        start_network_thread("take", ask)
