"""Where clients register, and the viewers: one thread, which waits for datagrams.

A client sends its registration to one port, and gets its reply from another, which is its own from then on.
"""

from __future__ import annotations

import itertools
import queue
import re
import select
import socket
import threading
from collections.abc import Callable, Mapping, Sequence
from typing import Final

from intellwheels_agents.ciber_gateway import simulator_messages
from intellwheels_agents.ciber_gateway.ciber_robot import MOST_POWER, ciber_robot
from intellwheels_agents.ciber_gateway.client_messages import (
    Registration,
    ViewCommand,
    read_command,
    read_registration,
)
from intellwheels_agents.ciber_gateway.client_socket import LARGEST, Address, ClientSocket, Reports, shown_address
from intellwheels_agents.ciber_gateway.lab_frame import Lab
from intellwheels_agents.ciber_gateway.robot_client import RobotClient, Waits
from intellwheels_agents.ciber_gateway.robot_state import RobotState
from intellwheels_agents.ciber_gateway.simulator_messages import Settings
from intellwheels_agents.options import OptionError
from intellwheels_agents.robot_document import equipped, joining
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.link import Link
from intellwheels_schemas.messages import Robot
from intellwheels_schemas.names import new_hex
from intellwheels_schemas.process import SLICE

MOST_VIEWERS: Final = 8
"""Viewers that are served; the oldest goes for another one."""
MOST_ROBOTS: Final = 16
"""Robots on a map without a start grid."""
MOST_COMMANDS: Final = 64
"""Commands of viewers that may wait; more are reported, and left out."""
PORTS_AT_ONCE: Final = 64
"""Datagrams that are read of a port before the others have their turn."""
LONGEST_NAME: Final = 24
"""Characters of the name of an agent that are kept, so that a number fits behind them."""
_OTHER: Final = re.compile(r"[^a-z0-9]+")


class Reception:
    """Registers clients.

    Attributes:
        robots: The robots by the address of their agent.
        commands: Commands of viewers that are about the world, for whoever may send them.
    """

    def __init__(
        self, host: str, port: int, *, where: Link, lab: Lab, settings: Settings, waits: Waits, gps: bool,
        beacons: bool, beacon_height: float, changes: Mapping[str, str], reports: Reports, tell: Callable[[str], None],
    ) -> None:  # fmt: skip
        """Open the port of registrations.

        Args:
            host: Address of the port.
            port: Its number; 0 picks a free one.
            where: The link to the world.
            lab: The lab.
            settings: The parameters that agents are told.
            waits: How long robots wait.
            gps: Whether robots have a GPS.
            beacons: Whether they have sensors for beacons.
            beacon_height: Height of the beacons, m.
            changes: Fields of robots that are changed, by name.
            reports: Takes what is not obeyed.
            tell: Takes the lines that scripts wait for.

        Raises:
            OSError: The port is in use, or the address is not of this machine.
        """
        self.robots: dict[Address, RobotClient] = {}
        self.commands: queue.Queue[ViewCommand] = queue.Queue(MOST_COMMANDS)
        self._host = host
        self._where = where
        self._lab = lab
        self._settings = settings
        self._waits = waits
        self._gps, self._beacons, self._beacon_height = gps, beacons, beacon_height
        self._changes = changes
        self._reports = reports
        self._tell = tell
        self._viewers: list[ClientSocket] = []
        self._removed: queue.SimpleQueue[RobotState] = queue.SimpleQueue()
        self._period = 0.05
        self._lock = threading.RLock()
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.setblocking(False)
            self._socket.bind((host, port))
        except OSError as error:
            self._socket.close()
            raise OSError(f"--port: expected a free port of {host}, got {port}: {error}") from None

    @property
    def port(self) -> int:
        """The port of registrations."""
        return int(self._socket.getsockname()[1])

    def change_lab(self, lab: Lab) -> None:
        """Take another lab, and send it to the viewers."""
        if lab == self._lab:
            return
        self._lab = lab
        for viewer in self._viewers_now():
            self._send_lab(viewer)
            viewer.send(simulator_messages.grid_shown(lab))

    def run(self, stop: threading.Event) -> None:
        """Serve until `stop` is set."""
        while not stop.is_set():
            viewers = self._viewers_now()
            ready, _, _ = select.select([self._socket.fileno(), *(one.fileno() for one in viewers)], [], [], SLICE)
            if self._socket.fileno() in ready:
                self._receive()
            for viewer in viewers:
                # A registration may have closed the oldest.
                if viewer.fileno() in ready:
                    self._serve(viewer)

    def robots_now(self) -> list[RobotClient]:
        """Return all robots that have joined."""
        with self._lock:
            return [robot for robot in self.robots.values() if robot.reply]

    def show(self, messages: Sequence[bytes]) -> None:
        """Send messages to all viewers."""
        for viewer in self._viewers_now():
            for message in messages:
                viewer.send(message)

    def gone(self) -> list[RobotState]:
        """Return the robots that have left since the last call."""
        found = []
        while not self._removed.empty():
            found.append(self._removed.get())
        return found

    def close(self) -> None:
        """Let all robots leave, and close all ports."""
        with self._lock:
            robots = list(self.robots.values())
        for robot in robots:
            robot.stop()
        for robot in robots:
            robot.join()
        for viewer in self._viewers_now():
            viewer.close()
        self._socket.close()

    # ------------------------------------------------------------ registrations

    def _receive(self) -> None:
        for _ in range(PORTS_AT_ONCE):
            try:
                data, sender = self._socket.recvfrom(LARGEST)
            except BlockingIOError:
                return
            except OSError:
                continue
            try:
                registration = read_registration(data)
                if registration.kind == "viewer":
                    self._admit_viewer(sender)
                else:
                    self._admit_robot(registration, sender)
            except (WireError, OptionError, OSError) as error:
                self._reports.tell("registration", shown_address(sender), str(error))
                # Two ports that refuse what the other one says would never end.
                if not data.lstrip().startswith(b"<Reply"):
                    self._refuse(sender)

    def _refuse(self, sender: Address) -> None:
        try:
            self._socket.sendto(simulator_messages.REFUSED, sender)
        except OSError as error:
            self._reports.tell("message to a client", shown_address(sender), str(error))

    def _admit_viewer(self, sender: Address) -> None:
        known = next((viewer for viewer in self._viewers if viewer.client == sender), None)
        if known is None:
            known = ClientSocket(self._host, sender, self._reports)
            with self._lock:
                self._viewers.append(known)
                oldest = self._viewers.pop(0) if len(self._viewers) > MOST_VIEWERS else None
            if oldest is not None:
                self._reports.tell("viewer", shown_address(oldest.client), f"at most {MOST_VIEWERS} viewers")
                oldest.close()
            self._tell(f"viewer client={shown_address(sender)}")
        known.send(simulator_messages.reply(self._settings, None, self._lab, self._period))

    def _admit_robot(self, registration: Registration, sender: Address) -> None:
        with self._lock:
            known = self.robots.get(sender)
            if known is not None:
                # A second try: the reply to the first was lost, or is on its way.
                if known.reply:
                    known.client.send(known.reply)
                return
            numbers = self._free_numbers(registration.number)
            agent = self._agent_of(registration.name, numbers[0])
            base = ciber_robot(
                registration, self._lab, gps=self._gps, beacons=self._beacons, beacon_height=self._beacon_height
            )
            base = equipped(base, self._changes)
            documents = {number: self._document(base, agent, number) for number in numbers}
            state = RobotState(numbers[0], registration.name, agent, self._settings)
            robot = RobotClient(
                state, ClientSocket(self._host, sender, self._reports), documents, where=self._where,
                reports=self._reports, waits=self._waits, lab=lambda: self._lab, numbers=self._numbers,
                claim=self._claim, joined=self._joined, over=self._over, tell=self._tell,
            )  # fmt: skip
            self.robots[sender] = robot
        robot.start()

    def _free_numbers(self, wanted: int) -> list[int]:
        """Return the numbers that a robot may have: of its place in the grid."""
        most = len(self._lab.starts) or MOST_ROBOTS
        taken = set(self._numbers().values())
        free = [number for number in range(1, most + 1) if number not in taken]
        if wanted and wanted not in free:
            raise WireError("value", f"Robot.Id: expected a free place of a grid of {most}, got {wanted}")
        if not free:
            raise WireError("too-many", f"expected at most {most} robots, got another one")
        return [wanted] if wanted else free

    def _document(self, base: Robot, agent: str, number: int) -> Robot:
        place = self._lab.starts[number - 1].name if self._lab.starts else None
        return joining(base, agent=agent, role="both", instance=new_hex(), place=place, barrier=None)

    def _agent_of(self, name: str, number: int) -> str:
        """Return the name in the contract of a robot: that of its agent, with a number if another one has it."""
        plain = _OTHER.sub("-", name.lower())
        if not plain.strip("-")[:1].isalpha():
            plain = f"robot-{plain}"
        plain = plain.strip("-")[:LONGEST_NAME].strip("-")
        taken = {robot.state.agent for robot in self.robots.values()}
        numbered = (f"{plain}-{other}" for other in itertools.count(number))
        return next(one for one in itertools.chain([plain], numbered) if one not in taken)

    def _numbers(self) -> Mapping[str, int]:
        with self._lock:
            return {robot.state.agent: robot.state.number for robot in self.robots.values()}

    def _claim(self, robot: RobotClient, number: int) -> bool:
        """Give a robot a number, unless another one has it."""
        with self._lock:
            if any(other.state.number == number for other in self.robots.values() if other is not robot):
                return False
            robot.state.number = number
            return True

    def _joined(self, robot: RobotClient, accepted: Robot, period: float) -> None:
        self._period = period
        if (fastest := accepted.top_speed * period) < MOST_POWER:
            # Short ticks: the largest power of the simulator is more than the motors have.
            why = (
                f"expected --option TopSpeed={MOST_POWER / period:g} or more at ticks of {period:g} s, got "
                f"{accepted.top_speed:g}: powers above {fastest:g} count as {fastest:g}"
            )
            self._reports.tell("power of a robot", shown_address(robot.client.client), why)
        robot.reply = simulator_messages.reply(self._settings, accepted, self._lab, period)
        robot.client.send(robot.reply)

    def _over(self, robot: RobotClient, had_joined: bool) -> None:
        with self._lock:
            self.robots.pop(robot.client.client, None)
        if had_joined:
            self._removed.put(robot.state)
        else:
            robot.client.send(simulator_messages.REFUSED)
        robot.client.close()

    # ------------------------------------------------------------ viewers

    def _viewers_now(self) -> list[ClientSocket]:
        with self._lock:
            return list(self._viewers)

    def _serve(self, viewer: ClientSocket) -> None:
        for _ in range(PORTS_AT_ONCE):
            data = viewer.receive()
            if data is None:
                return
            try:
                command = read_command(data)
            except WireError as error:
                self._reports.tell("command of a viewer", shown_address(viewer.client), error.text)
                continue
            if command.verb == "lab":
                self._send_lab(viewer)
            elif command.verb == "grid":
                viewer.send(simulator_messages.grid_shown(self._lab))
            else:
                try:
                    self.commands.put_nowait(command)
                except queue.Full:
                    why = f"expected at most {MOST_COMMANDS} that wait, got another one"
                    self._reports.tell("command of a viewer", shown_address(viewer.client), why)

    def _send_lab(self, viewer: ClientSocket) -> None:
        message = simulator_messages.lab_shown(self._lab, self._beacon_height)
        if len(message) > simulator_messages.LARGEST:
            why = f"expected a lab of at most {simulator_messages.LARGEST} bytes, got {len(message)}"
            self._reports.tell("lab for a viewer", shown_address(viewer.client), why)
            return
        viewer.send(message)
