"""How a run is started: the command line of each of its processes. Pure: a plan in, words out."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from intellwheels_schemas.messages import Cast, Map, Pace, Scene

SERVER: Final = "server"
"""The simulator among the children."""

VIEWER: Final = "viewer"
"""The viewer among the children."""

WALL_LIMIT: Final = 600.0
"""Seconds of wall time a run may take beyond what its pace needs."""


@dataclass(frozen=True, kw_only=True)
class Plan:
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
    """

    scene: Scene
    source: str
    floor: Map
    logs: Path
    folder: Path | None = None
    world: str = "main"
    listen: tuple[str, ...] = ()
    connect: tuple[str, ...] = ()
    config: Path | None = None
    speed: float = 1.0
    encoding: str = "json"
    log: Path | None = None
    timeout: float = WALL_LIMIT
    view: int | None = None

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
        words += ["--seed", self.scene.seed, "--pace", self.pace, "--lifeline", str(lifeline)]
        if self.pace == "realtime":
            words += ["--speed", repr(self.speed)]
        if self.pace == "free":
            words += ["--open-loop"]
        if self.log is not None:
            words += ["--log", str(self.log.absolute())]
        return [sys.executable, "-m", "intellwheels_server", *words]

    def agent_command(self, cast: Cast, lifeline: int) -> list[str]:
        """Return the command of one of the cast."""
        words = [*self._link_words((), self.meeting), "--encoding", self.encoding, "--lifeline", str(lifeline)]
        return agent_command(cast, self.folder, words)

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
