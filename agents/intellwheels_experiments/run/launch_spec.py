"""How a run is started: the command line of each of its processes. Pure: a plan in, words out."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import msgspec

from intellwheels_schemas import defaults
from intellwheels_schemas.messages import Bridge, Cast, Map, Pace, Scene

SERVER: Final = "server"
"""The simulator among the children."""

VIEWER: Final = "viewer"
"""The viewer among the children."""

LABORATORY: Final = "laboratory"
"""A second simulator among the children, that real chairs are in."""

LAB: Final = "lab"
"""Its world."""

DEADLINE: Final = 60.0
"""Seconds one of two worlds waits for an answer that may be waiting for the other world."""

WALL_LIMIT: Final = 600.0
"""Seconds of wall time a run may take beyond what its pace needs."""


@dataclass(frozen=True, kw_only=True)
class LaunchSpec:
    """A run to be started.

    Attributes:
        scene: The scene, with the pace and the seed of this run.
        source: Its name, or its path, as the simulator is told it.
        folder: Where relative paths in it start from, or None for a shipped scene.
        floor: Its floor.
        world: The world's name.
        listen: Endpoints where the simulator listens; the others connect there.
        connect: Endpoints of a router that all go through; then nobody need listen.
        config: A Zenoh configuration of all, or None.
        logs: The folder of the processes' logs.
        speed: Factor of real time, at pace `realtime`.
        encoding: What the agents speak, `json` or `xml`.
        log: The input log that the simulator writes, if any.
        timeout: Seconds of wall time after which the run is broken off.
        view: The port of the viewer's page, 0 for any free one; None for no viewer.
        laboratory: Where the laboratory of a scene with bridges listens, an endpoint.
    """

    scene: Scene
    source: str
    floor: Map
    logs: Path
    folder: Path | None = None
    world: str = defaults.WORLD
    listen: tuple[str, ...] = ()
    connect: tuple[str, ...] = ()
    config: Path | None = None
    speed: float = 1.0
    encoding: str = "json"
    log: Path | None = None
    timeout: float = WALL_LIMIT
    view: int | None = None
    laboratory: str = ""

    @property
    def pace(self) -> Pace:
        """The pace of this run."""
        return self.scene.pace

    @property
    def meeting(self) -> tuple[str, ...]:
        """The endpoints where everybody but the simulator connects."""
        return self.connect or self.listen

    def server_command(self, lifeline: int) -> list[str]:
        """Return the command of the simulator; it goes on after the end, so that it can be asked how it was."""
        words = ["--scene", self.source, *self._link_words(self.listen, self.connect)]
        return self._simulator(words, self.log, lifeline)

    def laboratory_command(self, lifeline: int) -> list[str]:
        """Return the command of the laboratory; its log is beside the other, with `-lab` behind its name."""
        words = [*link_words(self.lab, [self.laboratory]), "--miss", self.scene.miss]
        words += laboratory_words(self.scene, self.bridges, self.folder)
        log = None if self.log is None else self.log.with_stem(f"{self.log.stem}-lab")
        return self._simulator(words, log, lifeline)

    def bridge_command(self, cast: Cast, lifeline: int) -> list[str]:
        """Return the command of the bridge of one of the cast that has one."""
        laboratory = self.lab, self.laboratory
        return bridge_command(cast, self.bridges[cast.name], self.folder, laboratory, self._agent_words(lifeline))

    def agent_command(self, cast: Cast, lifeline: int) -> list[str]:
        """Return the command of one of the cast; of one with a bridge, of its mind."""
        words = self._agent_words(lifeline)
        if cast.name in self.bridges:
            return mind_command(cast, self.folder, words)
        return agent_command(cast, self.folder, words)

    @property
    def bridges(self) -> Mapping[str, Bridge]:
        """The bridges by their agents."""
        return {bridge.agent: bridge for bridge in self.scene.bridge}

    @property
    def lab(self) -> str:
        """The laboratory's world."""
        return LAB if self.world != LAB else f"{LAB}2"

    def _agent_words(self, lifeline: int) -> list[str]:
        words = [*self._link_words((), self.meeting), "--encoding", self.encoding, "--lifeline", str(lifeline)]
        # It may have to wait for the laboratory first.
        return [*words, "--retry-for", f"{DEADLINE:g}"] if self.scene.bridge else words

    def _simulator(self, words: list[str], log: Path | None, lifeline: int) -> list[str]:
        words += ["--seed", self.scene.seed, "--pace", self.pace, "--lifeline", str(lifeline)]
        if self.scene.bridge:
            words += ["--deadline", f"{DEADLINE:g}"]
        if self.pace == "realtime":
            words += ["--speed", repr(self.speed)]
        if self.pace == "free":
            words += ["--open-loop"]
        if log is not None:
            words += ["--log", str(log.absolute())]
        return [sys.executable, "-m", "intellwheels_server", *words]

    def viewer_command(self, lifeline: int) -> list[str]:
        """Return the command of the viewer."""
        words = ["--port", str(self.view or 0), *self._link_words((), self.meeting), "--lifeline", str(lifeline)]
        return [sys.executable, "-m", "intellwheels_viewer", *words]

    def _link_words(self, listen: tuple[str, ...], connect: tuple[str, ...]) -> list[str]:
        words = link_words(self.world, listen, connect)
        return words if self.config is None else [*words, "--config", str(self.config.absolute())]


def agent_command(cast: Cast, folder: Path | None, words: Sequence[str]) -> list[str]:
    """Return the command of an agent.

    Args:
        cast: Who, with which mind and body, where. An empty robot: the mind's own.
        folder: Where its relative paths start from; None: the working directory.
        words: The rest of the command line.
    """
    command = [sys.executable, "-m", "intellwheels_agents", resolved(cast.mind, folder), "--name", cast.name]
    if cast.robot:
        command += ["--robot", resolved(cast.robot, folder)]
    if cast.place is not None:
        command += ["--place", cast.place]
    for option in cast.option:
        command += ["--option", f"{option.name}={option.value}"]
    return [*command, *words]


def mind_command(cast: Cast, folder: Path | None, words: Sequence[str]) -> list[str]:
    """Return the command of the mind of an agent whose body is a bridge's; arguments as of `agent_command`."""
    own = tuple(one for one in cast.option if not one.name[0].isupper())
    mind = msgspec.structs.replace(cast, robot="", place=None, option=own)
    return agent_command(mind, folder, ["--role", "mind", *words])


def bridge_command(
    cast: Cast, bridge: Bridge, folder: Path | None, laboratory: tuple[str, str], words: Sequence[str]
) -> list[str]:
    """Return the command of a bridge.

    Args:
        cast: Whose body it is in the simulation, and where.
        bridge: The chair as built, and how it is reported.
        folder: Where relative paths start from; None: the working directory.
        laboratory: The world that the chair is in, and where it listens.
        words: The rest of the command line.
    """
    told = ["world", "--name", cast.name, "--robot", resolved(cast.robot, folder)]
    told += ["--lab-world", laboratory[0], "--lab-connect", laboratory[1]]
    told += ["--chair", resolved(bridge.chair, folder)] if bridge.chair is not None else []
    told += ["--place", cast.place] if cast.place is not None else []
    for option in cast.option:
        told += ["--option", f"{option.name}={option.value}"] if option.name[0].isupper() else []
    for option in bridge.option:
        is_field = option.name[0].isupper()
        told += ["--chair-option", f"{option.name}={option.value}"] if is_field else [f"--{option.name}", option.value]
    return [sys.executable, "-m", "intellwheels_agents.bridge", *told, *words]


def laboratory_words(scene: Scene, bridges: Mapping[str, Bridge], folder: Path | None) -> list[str]:
    """Return what makes a simulator the laboratory of a scene: its floor, whom it awaits, that truth stays there."""
    words = ["--expect", ",".join(bridges), "--map", resolved(scene.map, folder), "--hide-truth"]
    return [*words, "--period", repr(scene.period)]


def bridge_child(name: str) -> str:
    """Return the name of an agent's bridge among the children."""
    return f"bridge-{name}"


def link_words(world: str, listen: Sequence[str] = (), connect: Sequence[str] = ()) -> list[str]:
    """Return how a command is told its world and whom it meets where."""
    words = ["--world", world]
    for option, endpoints in (("--listen", listen), ("--connect", connect)):
        for endpoint in endpoints:
            words += [option, endpoint]
    return words


def resolved(name_or_path: str, folder: Path | None) -> str:
    """Return a path from a folder on as an absolute one, and the name of something shipped as it is."""
    is_path = "/" in name_or_path or name_or_path.endswith((".xml", ".py"))
    return str((folder or Path()).absolute() / name_or_path) if is_path else name_or_path


def filled(word: str, values: Mapping[str, str]) -> str:
    """Return a word of a command with each `{name}` replaced by its value; other braces stay."""
    for name, value in values.items():
        word = word.replace(f"{{{name}}}", value)
    return word


def wall_limit(scene: Scene, speed: float) -> float:
    """Return how many seconds of wall time a run of the scene may take."""
    if scene.pace != "realtime":
        return WALL_LIMIT
    simulated = scene.end.timeout.seconds if scene.end and scene.end.timeout else 0.0
    return WALL_LIMIT + simulated / speed


def agent_child(name: str) -> str:
    """Return the name of an agent among the children; `server` is a good name for an agent too."""
    return f"agent-{name}"


def parse(line: str) -> tuple[str, Mapping[str, str]]:
    """Return the verb and the values of a line a script waits for: `ended tick=812 hash=...`."""
    verb, *words = line.split() or [""]
    return verb, dict(word.split("=", 1) for word in words if "=" in word)
