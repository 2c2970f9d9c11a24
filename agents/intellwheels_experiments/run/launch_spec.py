"""The command line of each process of a run. Pure: a `LaunchSpec` in, lists of arguments out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import msgspec

from intellwheels_maps.library import is_path
from intellwheels_schemas.messages import Bridge, Cast, Map, Pace, Scene
from intellwheels_schemas.process import PYTHON

SERVER: Final = "server"
"""The simulator's name among the children."""

VIEWER: Final = "viewer"
"""The viewer's name among the children."""

LABORATORY: Final = "laboratory"
"""The name among the children of a second simulator, which holds the real chairs."""

LAB: Final = "lab"
"""The laboratory's world."""

ANSWER_DEADLINE: Final = 60.0
"""Seconds that a simulator waits for an answer where its agent may be waiting for a second world, or in a batch."""

WALL_LIMIT: Final = 600.0
"""Seconds of wall time that a run may take beyond what its pace needs."""


@dataclass(frozen=True, kw_only=True)
class LaunchSpec:
    """The processes to start for a run, and their settings.

    Attributes:
        scene: The scene, with the pace and the seed of this run.
        source: The scene's name or path, as the simulator gets it.
        folder: Where relative paths in the scene start; None for an included scene.
        floor: The scene's map.
        world: The world's name.
        listen: Endpoints at which the simulator listens. The other processes connect to them.
        connect: Endpoints of a router to which all processes connect. No process needs to listen then.
        config: A Zenoh configuration for all processes, or None.
        identity: The identity file of all processes, or None.
        logs: The folder of the processes' logs.
        speed: Multiple of real time, at pace `realtime`.
        encoding: The encoding of the agents' messages, `json` or `xml`.
        log: The input log that the simulator writes, or None.
        timeout: Seconds of wall time after which the run is aborted.
        view: The port of the viewer's page, 0 for any free port; None for no viewer.
        dark: Whether that page uses the dark theme.
        laboratory: The endpoint at which the laboratory listens, for a scene with bridges.
    """

    scene: Scene
    source: str
    floor: Map
    world: str
    logs: Path
    folder: Path | None = None
    listen: tuple[str, ...] = ()
    connect: tuple[str, ...] = ()
    config: Path | None = None
    identity: Path | None = None
    speed: float = 1.0
    encoding: str = "json"
    log: Path | None = None
    timeout: float = WALL_LIMIT
    view: int | None = None
    dark: bool = False
    laboratory: str = ""

    @property
    def pace(self) -> Pace:
        """The pace of this run."""
        return self.scene.pace

    @property
    def meeting(self) -> tuple[str, ...]:
        """The endpoints to which every process but the simulator connects."""
        return self.connect or self.listen

    @property
    def bridges(self) -> Mapping[str, Bridge]:
        """The scene's bridges by agent."""
        return {bridge.agent: bridge for bridge in self.scene.bridge}

    @property
    def lab(self) -> str:
        """The laboratory's world, which differs from the run's own."""
        return LAB if self.world != LAB else f"{LAB}2"

    def server_command(self, lifeline: int) -> list[str]:
        """Return the simulator's command. It keeps running after the end of the run, so that it can be queried."""
        arguments = ["--scene", self.source, *self._link_arguments(self.listen, self.connect)]
        if self.view is not None:
            arguments += ["--await-page"]
        return self._simulator_command(arguments, self.log, lifeline)

    def laboratory_command(self, lifeline: int) -> list[str]:
        """Return the laboratory's command. Its log is beside the run's, with `-lab` appended to the stem."""
        arguments = [*link_arguments(self.lab, [self.laboratory]), "--miss", self.scene.miss]
        arguments += laboratory_arguments(self.scene, self.bridges, self.folder)
        log = None if self.log is None else laboratory_log(self.log)
        return self._simulator_command(arguments, log, lifeline)

    def bridge_command(self, cast: Cast, lifeline: int) -> list[str]:
        """Return the command of the bridge of an agent that has one."""
        laboratory = self.lab, self.laboratory
        return bridge_command(cast, self.bridges[cast.name], self.folder, laboratory, self._agent_arguments(lifeline))

    def agent_command(self, cast: Cast, lifeline: int) -> list[str]:
        """Return the command of an agent; if a bridge has its body, the command of its mind."""
        arguments = self._agent_arguments(lifeline)
        if cast.name in self.bridges:
            return mind_command(cast, self.folder, arguments)
        return agent_command(cast, self.folder, arguments)

    def viewer_command(self, lifeline: int) -> list[str]:
        """Return the viewer's command."""
        arguments = ["--port", str(self.view or 0), *self._link_arguments((), self.meeting)]
        if self.dark:
            arguments += ["--dark"]
        return [*PYTHON, "-m", "intellwheels_viewer", *arguments, "--lifeline", str(lifeline)]

    def _agent_arguments(self, lifeline: int) -> list[str]:
        arguments = [*self._link_arguments((), self.meeting), "--encoding", self.encoding, "--lifeline", str(lifeline)]
        # With a laboratory the join may have to wait for the other world.
        return [*arguments, "--retry-for", f"{ANSWER_DEADLINE:g}"] if self.scene.bridge else arguments

    def _simulator_command(self, arguments: list[str], log: Path | None, lifeline: int) -> list[str]:
        arguments += ["--seed", self.scene.seed, "--pace", self.pace, "--lifeline", str(lifeline)]
        if self.scene.bridge:
            arguments += ["--deadline", f"{ANSWER_DEADLINE:g}"]
        if self.pace == "realtime":
            arguments += ["--speed", repr(self.speed)]
        if self.pace == "free":
            arguments += ["--open-loop"]
        if log is not None:
            # Whoever made the specification has checked it.
            arguments += ["--log", str(log.absolute()), "--overwrite"]
        return [*PYTHON, "-m", "intellwheels_server", *arguments]

    def _link_arguments(self, listen: tuple[str, ...], connect: tuple[str, ...]) -> list[str]:
        arguments = link_arguments(self.world, listen, connect)
        for option, file in (("--config", self.config), ("--identity", self.identity)):
            arguments += [] if file is None else [option, str(file.absolute())]
        return arguments


def laboratory_log(log: Path) -> Path:
    """Return the input log of the laboratory of a run, which is beside that of the run."""
    return log.with_stem(f"{log.stem}-lab")


def agent_command(cast: Cast, folder: Path | None, arguments: Sequence[str]) -> list[str]:
    """Return the command of an agent.

    Args:
        cast: The agent's name, mind, robot, place and options. An empty robot means the mind's own.
        folder: Where relative paths in it start; None: the working directory.
        arguments: The rest of the command line.
    """
    command = [*PYTHON, "-m", "intellwheels_agents", resolved(cast.mind, folder), "--name", cast.name]
    if cast.robot:
        command += ["--robot", resolved(cast.robot, folder)]
    if cast.place is not None:
        command += ["--place", cast.place]
    for option in cast.option:
        command += ["--option", f"{option.name}={option.value}"]
    return [*command, *arguments]


def mind_command(cast: Cast, folder: Path | None, arguments: Sequence[str]) -> list[str]:
    """Return the command of the mind of an agent whose body is a bridge. The arguments are those of `agent_command`."""
    own = tuple(option for option in cast.option if not is_robot_field(option.name))
    mind = msgspec.structs.replace(cast, robot="", place=None, option=own)
    return agent_command(mind, folder, ["--role", "mind", *arguments])


def bridge_command(
    cast: Cast, bridge: Bridge, folder: Path | None, laboratory: tuple[str, str], arguments: Sequence[str]
) -> list[str]:
    """Return the command of a bridge.

    Args:
        cast: The agent whose body the bridge is, and its place.
        bridge: The chair as built, and how its pose is reported.
        folder: Where relative paths start; None: the working directory.
        laboratory: The laboratory's world and endpoint.
        arguments: The rest of the command line.
    """
    own = ["world", "--name", cast.name, "--robot", resolved(cast.robot, folder)]
    own += ["--lab-world", laboratory[0], "--lab-connect", laboratory[1]]
    own += ["--chair", resolved(bridge.chair, folder)] if bridge.chair is not None else []
    own += ["--place", cast.place] if cast.place is not None else []
    for option in cast.option:
        own += ["--option", f"{option.name}={option.value}"] if is_robot_field(option.name) else []
    for option in bridge.option:
        field = is_robot_field(option.name)
        own += ["--chair-option", f"{option.name}={option.value}"] if field else [f"--{option.name}", option.value]
    return [*PYTHON, "-m", "intellwheels_agents.bridge", *own, *arguments]


def laboratory_arguments(scene: Scene, bridges: Mapping[str, Bridge], folder: Path | None) -> list[str]:
    """Return the arguments that make a simulator the laboratory of a scene: map, agents to expect, hidden truth."""
    arguments = ["--expect", ",".join(bridges), "--map", resolved(scene.map, folder), "--hide-truth"]
    return [*arguments, "--period", repr(scene.period)]


def is_robot_field(option: str) -> bool:
    """Return whether an option of a scene sets a field of the robot, such as `MotorNoise`, and not one of the mind."""
    return option[:1].isupper()


def agent_child(agent: str) -> str:
    """Return an agent's name among the children. The prefix keeps an agent called `server` apart from the simulator."""
    return f"agent-{agent}"


def bridge_child(agent: str) -> str:
    """Return the name among the children of an agent's bridge."""
    return f"bridge-{agent}"


def link_arguments(world: str, listen: Sequence[str] = (), connect: Sequence[str] = ()) -> list[str]:
    """Return the arguments that give a command its world and endpoints."""
    arguments = ["--world", world]
    for option, endpoints in (("--listen", listen), ("--connect", connect)):
        for endpoint in endpoints:
            arguments += [option, endpoint]
    return arguments


def resolved(name_or_path: str, folder: Path | None) -> str:
    """Return a path as an absolute one that starts at `folder`, and the name of something included unchanged."""
    return str((folder or Path()).absolute() / name_or_path) if is_path(name_or_path) else name_or_path


def wall_limit(scene: Scene, speed: float) -> float:
    """Return how many seconds of wall time a run of the scene may take.

    Args:
        scene: The scene, with its pace and its end.
        speed: Multiple of real time, at pace `realtime`.
    """
    if scene.pace != "realtime":
        return WALL_LIMIT
    simulated = scene.end.timeout.seconds if scene.end and scene.end.timeout else 0.0
    return WALL_LIMIT + simulated / speed
