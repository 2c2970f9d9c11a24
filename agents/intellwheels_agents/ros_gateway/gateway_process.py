"""One `iw-ros`, from its start to its end: its sessions, its nodes, and the thread of the world's topics."""

from __future__ import annotations

import argparse
import sys
import threading
import time
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any

import msgspec

from intellwheels_agents.agent_peer import run_agent
from intellwheels_agents.mind import Context
from intellwheels_agents.options import OptionError
from intellwheels_agents.robot_document import joining
from intellwheels_agents.ros_gateway.chair_goal import POSE_STAMPED
from intellwheels_agents.ros_gateway.chair_messages import has_odometry
from intellwheels_agents.ros_gateway.ros_mind import RosMind
from intellwheels_agents.ros_gateway.ros_names import ros_name
from intellwheels_agents.ros_gateway.ros_node import RosNode, RosSession
from intellwheels_agents.ros_gateway.simulation_control import SimulationControl
from intellwheels_agents.ros_gateway.velocity_command import TWIST, TWIST_STAMPED
from intellwheels_agents.ros_gateway.watched_chair import WatchedChair
from intellwheels_agents.ros_gateway.world_link import WorldQueries, WorldTopics
from intellwheels_schemas import link, own_rights
from intellwheels_schemas.codec import Encoding
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import Robot, Truth
from intellwheels_schemas.names import new_hex
from intellwheels_schemas.process import THREADS_END, start_network_thread
from intellwheels_schemas.session_closing import closing

NODE = "intellwheels"
"""Name of the gateway's nodes: `/intellwheels` for the world, `/<name>/intellwheels` for a chair."""
OTHER_ROUTER = (
    "the router of a lab denies the keys of ROS; start a router for the ROS nodes too, such as iw-router --listen "
    "tcp/127.0.0.1:7448, and name it with --ros-connect"
)
"""What a gateway says whose nodes would be heard by nobody."""


class GatewayProcess:
    """The parts of one gateway."""

    def __init__(
        self, given: argparse.Namespace, agent: str | None, body: Robot | None, where: link.Link, ros: link.Link,
        domain: int, stop: threading.Event,
    ) -> None:  # fmt: skip
        """Take what the options say.

        Args:
            given: The options.
            agent: The agent of the chair, or None for none.
            body: Its robot, with the role both.
            where: The link to the world.
            ros: The link to the ROS nodes.
            domain: Domain of ROS.
            stop: Set when the process must end.
        """
        self._given = given
        self._agent = agent
        self._body = body
        self._where = where
        self._ros = ros
        self._domain = domain
        self._stop = stop
        self._keys = Keys(where.world)
        self._deadline = time.monotonic() + given.retry_for
        self._tell_clock: Callable[[str, float, float], None] = _ignore

    def run(self) -> int:
        """Run until `stop` is set or the simulator refuses the chair, and return the exit code."""
        with ExitStack() as stack:
            if self._where.listen:
                # One session can listen at an endpoint. It connects the others, which are clients of it.
                hub = self._open(self._where)
                if hub is None:
                    return 0
                stack.enter_context(hub)
                inner = link.Link(self._where.world, connect=self._where.listen)
                self._ros = inner if self._ros == self._where else self._ros
                self._where = inner
            opened = self._open(self._ros)
            if opened is None:
                return 0
            if own_rights.own_rights(opened, sure=True) is not None:
                opened.close()
                raise ConnectionError(OTHER_ROUTER)
            graph = stack.enter_context(RosSession(opened, self._domain, humble=self._given.humble, log=_log))
            self._check_names(graph)
            world_session = None
            if not self._given.no_world or self._given.role == "watch":
                world_session = self._open(self._where)
                if world_session is None:
                    return 0
                stack.enter_context(closing(world_session))
            if not self._given.no_world:
                stack.enter_context(self._world_topics(world_session, graph))
            node = None if self._agent is None else graph.node(f"/{ros_name(self._agent)}", NODE)
            _print(f"ready domain={self._domain} world={self._where.world}")
            if node is None:
                while not self._stop.wait(0.2):
                    pass
                return 0
            if self._given.role == "watch":
                return self._watch(world_session, node)
            return self._drive(node)

    def _open(self, where: link.Link) -> Any:
        left = self._deadline - time.monotonic()
        return link.open_session(
            where, self._stop, timeout=max(left, 0.0) if left < 1e9 else None,
            waiting=lambda why: _log(f"waiting why={why!r}"),
        )  # fmt: skip

    def _check_names(self, graph: RosSession) -> None:
        """Refuse to be a node that is there already.

        Raises:
            ConnectionError: Another gateway has its name.
        """
        if self._agent is not None and graph.has_node(f"/{ros_name(self._agent)}", NODE):
            node = f"/{ros_name(self._agent)}/{NODE}"
            raise ConnectionError(f"--name: expected a chair that no other iw-ros has, got {node}, which is there")
        if not self._given.no_world and graph.has_node("/", NODE):
            raise ConnectionError(f"expected --no-world, as another iw-ros has the node /{NODE}, got a world")

    def _world_topics(self, session: Any, graph: RosSession) -> _Running:
        node = graph.node("/", NODE)
        world = WorldQueries(session, self._keys, self._stop)
        topics = WorldTopics(session, self._keys, world, node, resolution=self._given.resolution, log=_log)
        node.serve(SimulationControl(world).services())
        self._tell_clock = topics.clock.tell
        return _Running(topics, self._stop)

    def _drive(self, node: RosNode) -> int:
        chair = ros_name(self._agent or "")
        commands = node.subscribe(f"/{chair}/cmd_vel", (TWIST, TWIST_STAMPED))

        def make(context: Context) -> RosMind:
            if self._given.localisation == "truth" and not context.robot.truth:
                raise OptionError("--localisation: expected start or none for a robot without truth sensor, got truth")
            if not has_odometry(context.robot):
                _log(f"no odom of agent={self._agent}: the robot has neither odometry nor encoders")
            return RosMind(
                context, node, commands, localisation=self._given.localisation,
                await_command=self._given.await_command, tell_clock=self._tell_clock, stop=self._stop,
            )  # fmt: skip

        robot = self._body or Robot()
        if self._given.localisation == "truth" and self._body is not None and not robot.truth:
            robot = msgspec.structs.replace(robot, truth=(Truth(id="truth"),))
        document = joining(
            robot, agent=self._agent or "", role="mind" if self._given.role == "mind" else "both",
            instance=new_hex(), place=self._given.place, barrier=None,
        )  # fmt: skip
        left = self._deadline - time.monotonic()
        return run_agent(document, make, {}, where=self._where, encoding=Encoding.JSON, retry_for=left, stop=self._stop)

    def _watch(self, session: Any, node: RosNode) -> int:
        agent = self._agent or ""
        if denied := own_rights.denied(session, self._keys.user(agent), "put"):
            _log(f"not driven agent={agent} why={denied!r}")
        goals = node.subscribe(f"/{ros_name(agent)}/goal_pose", (POSE_STAMPED,))
        world = WorldQueries(session, self._keys, self._stop)
        chair = WatchedChair(
            session, self._keys, world, agent, node, goals, localisation=self._given.localisation,
            tell_clock=self._tell_clock, log=_log,
        )  # fmt: skip
        chair.run(self._stop, _print)
        return 0


class _Running:
    """The thread of the world's topics, in a `with` statement."""

    def __init__(self, topics: WorldTopics, stop: threading.Event) -> None:
        self._over = threading.Event()
        self._topics = topics
        self._stop = stop
        self._thread: threading.Thread | None = None

    def __enter__(self) -> None:
        self._thread = start_network_thread("world", self._run)

    def __exit__(self, *_: object) -> None:
        self._over.set()
        if self._thread is not None:
            self._thread.join(THREADS_END)

    def _run(self) -> None:
        try:
            self._topics.run(self._over)
        except BaseException:
            # A gateway without its clock must not look as if it ran.
            self._stop.set()
            raise


def _ignore(_run: str, _seconds: float, _now: float) -> None:
    """Do nothing: another gateway publishes `/clock`."""


def _print(line: str) -> None:
    print(line, flush=True)  # noqa: T201 - scripts wait for these lines


def _log(line: str) -> None:
    print(f"iw-ros: {line}", file=sys.stderr, flush=True)  # noqa: T201 - the log
