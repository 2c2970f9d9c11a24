"""One `iw-ciber`, from its start to its end: the world that its clients drive in, and what viewers see of it."""

from __future__ import annotations

import argparse
import sys
import threading
import time
from collections.abc import Mapping
from contextlib import ExitStack
from typing import Any, Final

from intellwheels_agents.ciber_gateway.ciber_robot import ciber_robot
from intellwheels_agents.ciber_gateway.client_messages import Registration, ViewCommand
from intellwheels_agents.ciber_gateway.client_socket import Reports
from intellwheels_agents.ciber_gateway.lab_frame import Lab, lab_of
from intellwheels_agents.ciber_gateway.reception import Reception
from intellwheels_agents.ciber_gateway.robot_client import Waits
from intellwheels_agents.ciber_gateway.simulator_messages import Settings
from intellwheels_agents.robot_document import equipped
from intellwheels_schemas import link
from intellwheels_schemas.codec import decode, encode, encoding_of
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import Clock, Map, Pause, Resume, WorldState
from intellwheels_schemas.process import SLICE, THREADS_END
from intellwheels_schemas.simulator_query import ask_simulator
from intellwheels_schemas.zenoh_inbox import Inbox, Presence, Put

ANSWER_TIMEOUT: Final = 5.0
"""Seconds to wait for what the simulator answers at once."""
TRY_EVERY: Final = 1.0
"""Seconds between two requests for the map."""


class CiberProcess:
    """The parts of one gateway.

    Args:
        given: The options.
        where: The link to the world.
        changes: Fields of robots that are changed, by name.
        stop: Set when the process must end.
    """

    def __init__(
        self, given: argparse.Namespace, where: link.Link, changes: Mapping[str, str], stop: threading.Event
    ) -> None:
        self._given = given
        self._where = where
        self._changes = changes
        self._stop = stop
        self._keys = Keys(where.world)
        self._deadline = time.monotonic() + given.retry_for
        self._reports = Reports(_log)
        self._running = True
        self._cycle = 0
        self._map_due = float("inf")
        self._failed = False

    def run(self) -> int:
        """Serve until `stop` is set, and return the exit code: 0, or 1 if registrations could not go on.

        Raises:
            ConnectionError: There is no world.
            OSError: The port is in use.
            OptionError: The robot has no such field.
            WireError: The fields of the robot contradict each other.
        """
        with ExitStack() as stack:
            if self._where.listen:
                # One session can listen at an endpoint. It connects the others, which are clients of it.
                hub = self._open()
                if hub is None:
                    return 0
                stack.enter_context(hub)
                self._where = link.Link(self._where.world, connect=self._where.listen)
            session = self._open()
            if session is None:
                return 0
            stack.enter_context(session)
            lab = self._first_lab(session)
            if lab is None:
                return 0
            reception = self._reception(lab)
            stack.callback(reception.close)
            thread = threading.Thread(target=self._receive, args=(reception,), name="reception", daemon=True)
            thread.start()
            stack.callback(thread.join, THREADS_END)
            stack.callback(self._stop.set)
            _print(
                f"ready port={reception.port} world={self._where.world} starts={len(lab.starts)} "
                f"beacons={len(lab.beacons)} targets={len(lab.targets)}"
            )
            self._follow(session, reception)
        _log(f"ended dropped={self._reports.total}")
        return 1 if self._failed else 0

    def _open(self) -> Any:
        left = self._deadline - time.monotonic()
        return link.open_session(
            self._where, self._stop, timeout=max(left, 0.0) if left < 1e9 else None,
            waiting=lambda why: _log(f"waiting why={why!r}"),
        )  # fmt: skip

    def _reception(self, lab: Lab) -> Reception:
        given = self._given
        # What cannot be joined with is said before anybody registers.
        equipped(ciber_robot(Registration("robot"), lab, gps=given.gps, beacons=given.beacon,
                             beacon_height=given.beacon_height), self._changes)  # fmt: skip
        settings = Settings(
            sim_time=given.sim_time, key_time=given.key_time, requests=given.requests,
            requestable=frozenset(given.requestable), obstacle_noise=given.obstacle_noise,
        )  # fmt: skip
        return Reception(
            given.host, given.port, where=self._where, lab=lab, settings=settings,
            waits=Waits(given.await_answer, given.silence), gps=given.gps, beacons=given.beacon,
            beacon_height=given.beacon_height, changes=self._changes, reports=self._reports, tell=_print,
        )  # fmt: skip

    def _receive(self, reception: Reception) -> None:
        try:
            reception.run(self._stop)
        except BaseException:
            # A gateway that nobody can register at must not look as if it ran.
            self._failed = True
            self._stop.set()
            raise

    # ------------------------------------------------------------ the world

    def _first_lab(self, session: Any) -> Lab | None:
        """Return the lab of the world, as soon as there is one; None if the process must end first."""
        told = False
        while not self._stop.is_set():
            try:
                return self._lab(session)
            except ConnectionError as error:
                if time.monotonic() >= self._deadline:
                    raise
                if not told:
                    told = True
                    _log(f"waiting why={str(error)!r}")
            self._stop.wait(TRY_EVERY)
        return None

    def _lab(self, session: Any) -> Lab:
        answers = ask_simulator(session, self._keys, self._keys.map, timeout=ANSWER_TIMEOUT, stop=self._stop)
        for answer in answers:
            if answer.ok:
                try:
                    return lab_of(decode(Map, answer.data, encoding_of(answer.encoding, answer.data), strict=False))
                except WireError as error:
                    raise ConnectionError(f"expected a map: {error.text}") from None
        raise ConnectionError(f"expected a map, got an error: {answers[0].data[:200]!r}")

    def _follow(self, session: Any, reception: Reception) -> None:
        """Show the world to viewers until the process must end."""
        inbox, keys = Inbox(), self._keys
        with (
            session.declare_subscriber(keys.every_state, inbox.on_sample),
            session.declare_subscriber(keys.clock, inbox.on_sample),
            session.declare_subscriber(keys.map, inbox.on_sample),
            link.watch_tokens(session, keys.alive, inbox),
        ):
            while not self._stop.is_set():
                inbox.wait(SLICE)
                for arrival in inbox.take():
                    if isinstance(arrival, Put):
                        self._take(arrival, reception)
                    elif isinstance(arrival, Presence) and arrival.alive:
                        # Another simulator may have another map.
                        self._map_due = time.monotonic()
                for state in reception.gone():
                    reception.show([state.removed(self._cycle)])
                # Those that wait now: a viewer that goes on sending must not hold up the world, or the end.
                for _ in range(reception.commands.qsize()):
                    if not self._stop.is_set():
                        self._command(session, reception, reception.commands.get())
                if time.monotonic() >= self._map_due:
                    self._map_due = float("inf")
                    try:
                        reception.change_lab(self._lab(session))
                    except ConnectionError:
                        self._map_due = time.monotonic() + TRY_EVERY

    def _take(self, put: Put, reception: Reception) -> None:
        keys = self._keys
        try:
            if put.key == keys.map:
                self._map_due = time.monotonic()
            elif put.key == keys.clock:
                self._clock(decode(Clock, put.data, encoding_of(put.encoding, put.data), strict=False), reception)
            elif keys.parse_state(put.key) is not None:
                state = decode(WorldState, put.data, encoding_of(put.encoding, put.data), strict=False)
                self._cycle = state.tick
                robots = {robot.state.agent: robot.state for robot in reception.robots_now()}
                reception.show([
                    robots[entity.name].show(entity, state.tick, running=self._running)
                    for entity in state.entity if entity.name in robots
                ])  # fmt: skip
        except WireError as error:
            self._reports.tell("message of the world", put.key, error.text)

    def _clock(self, clock: Clock, reception: Reception) -> None:
        """Tell the robots of a world that does not run: it comes twice a second."""
        self._running = clock.state in ("running", "waiting")
        if not self._running:
            for robot in reception.robots_now():
                robot.client.send(robot.state.stopped())

    def _command(self, session: Any, reception: Reception, command: ViewCommand) -> None:
        if not self._given.control:
            self._reports.tell("command of a viewer", command.verb, "expected with --control only, got it without")
        elif command.verb == "remove":
            for robot in reception.robots_now():
                if robot.state.number == command.number:
                    robot.stop()
        else:
            verb: Any = "resume" if command.verb == "start" else "pause"
            try:
                link.query(
                    session, self._keys.ctl(verb), encode(Resume() if verb == "resume" else Pause()),
                    timeout=ANSWER_TIMEOUT, stop=self._stop,
                )  # fmt: skip
            except ConnectionError as error:
                self._reports.tell("command of a viewer", command.verb, str(error))


def _print(line: str) -> None:
    print(line, flush=True)  # noqa: T201 - scripts wait for these lines


def _log(line: str) -> None:
    print(f"iw-ciber: {line}", file=sys.stderr, flush=True)  # noqa: T201 - the log
