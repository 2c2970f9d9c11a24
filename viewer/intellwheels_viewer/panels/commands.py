"""The commands that the page prints. Each runs unchanged, with the endpoint and the world of this viewer. Pure."""

from __future__ import annotations

import re
import shlex
from typing import Final

from intellwheels_schemas import defaults
from intellwheels_viewer.snapshot import Snapshot

_ENDPOINT: Final = re.compile(r"[a-z][a-z-]*/\S+")
_LOCAL: Final = re.compile(r"[a-z][a-z-]*/(localhost|127\.[\d.]+|\[::1\]|0\.0\.0\.0|\[::\])(:\d+)?")
_PORT: Final = re.compile(r"[a-z][a-z-]*/.*:(\d+)")


def agent_command(snapshot: Snapshot) -> str:
    """Return a command that adds an agent to the world of a snapshot."""
    words = ["iw-agent", "avoid", "--name", "chair1"]
    if snapshot.endpoint != defaults.ENDPOINT:
        words += _link("--connect", snapshot)
    return shlex.join(words + _world(snapshot))


def run_command(snapshot: Snapshot) -> str:
    """Return a command that starts a scene which this viewer shows.

    With a router the scene connects to it. Without one the scene's simulator listens at the endpoint of the viewer.
    """
    words = ["iw-run", "figure6", "--pace", "realtime"]
    if snapshot.phase != "no-router":
        words += _link("--connect", snapshot)
    elif is_local(snapshot):
        words += _link("--listen", snapshot)
    else:
        port = _PORT.fullmatch(snapshot.endpoint)
        words += ["--listen", f"tcp/0.0.0.0:{port[1]}" if port else "tcp/0.0.0.0:7447"]
    return shlex.join(words + _world(snapshot))


def is_local(snapshot: Snapshot) -> bool:
    """Return whether the viewer looks for worlds on this machine only."""
    return all(_LOCAL.fullmatch(one) for one in snapshot.endpoint.split(", "))


def _link(option: str, snapshot: Snapshot) -> list[str]:
    endpoints = snapshot.endpoint.split(", ")
    if not all(_ENDPOINT.fullmatch(one) for one in endpoints):
        return ["--config", snapshot.endpoint]
    if option == "--connect":
        # Nobody can connect to the address that stands for all of a machine's.
        endpoints = [one.replace("/0.0.0.0:", "/127.0.0.1:").replace("/[::]:", "/[::1]:") for one in endpoints]
    return [word for one in endpoints for word in (option, one)]


def _world(snapshot: Snapshot) -> list[str]:
    return ["--world", snapshot.world] if snapshot.world not in ("", defaults.WORLD) else []
