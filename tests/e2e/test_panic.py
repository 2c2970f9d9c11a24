"""A put whose key has 80,000 bytes makes Zenoh 1.10.2 panic in the process that forwards it. That process is replaced.

The sender declares half of the key first, so that its own message is short enough. The forwarder writes the whole key.
"""

from __future__ import annotations

import os
import signal
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.e2e.stage import Peer, Stage

pytestmark = pytest.mark.process

HALF = 40_000


def attack(peer: Peer) -> None:
    """Send the key, and return when the sender's session has let go of it."""
    prefix = f"{peer.prefix}in/{'a' * HALF}"
    declared: Any = peer.session.declare_subscriber(prefix, lambda _: None)
    peer.session.put(f"{prefix}/{'a' * HALF}", b"x")
    declared.undeclare()


def real_chair(stage: Stage, folder: Path, *link: str) -> None:
    """Start a real chair with its mind, and wait until its motors turn."""
    port, ask = folder / "tty", folder / "ask"
    os.mkfifo(ask)
    stage.start("firmware", "intellwheels_agents.bridge.firmware_stand_in", "--link", str(port), "--ask", str(ask))
    stage.line("firmware", "ready")
    bridge = ("serial", "--port", str(port), "--name", "real1", "--robot", "intellwheels", "--resume", "auto")
    stage.line(stage.start("bridge", "intellwheels_agents.bridge", *bridge, *link), "joined")
    spin = ("--option", "left=0.2", "--option", "right=-0.2")
    mind = ("drive", "--name", "real1", "--role", "mind", *spin)
    stage.line(stage.start("mind", "intellwheels_agents", *mind, *link), "joined")
    stage.line("firmware", "moving")


def test_router_begins_again_and_motors_stop_meanwhile(tmp_path: Path) -> None:
    with Stage(tmp_path, "panic") as stage:
        stage.line(stage.start("router", "intellwheels_server.service.router", "--listen", stage.endpoint), "ready")
        link = ("--connect", stage.endpoint, "--world", stage.world)
        stage.line(stage.start("server", "intellwheels_server", *link, "--map", "room", "--pace", "realtime"), "ready")
        real_chair(stage, tmp_path, *link)
        with stage.peer() as peer:
            attack(peer)
            stage.line("firmware", "stopped")
            stage.line("router", "ready")
            assert "iw-router: restarted why=" in stage.log("router")
        stage.line("firmware", "moving")
        # The run goes on, and others can join it.
        stage.agent("late")
        stage.signal("router", signal.SIGTERM)
        assert stage.exit("router") == 0


def test_simulator_that_forwards_ends_to_be_started_again(tmp_path: Path) -> None:
    with Stage(tmp_path, "panic") as stage:
        child = stage.server("--map", "room", "--pace", "realtime")
        with stage.peer() as listener, stage.peer() as peer:
            heard: Any = listener.session.declare_subscriber(f"{listener.prefix}in/**", lambda _: None)
            listener.clock()  # the simulator knows the subscription now
            attack(peer)
            assert stage.exit(child) == 1
            assert "start it again" in stage.log(child)
            heard.undeclare()


def test_run_whose_simulator_ends_by_a_panic_says_so_and_motors_stop(tmp_path: Path) -> None:
    with Stage(tmp_path, "panic") as stage:
        link = ("--world", stage.world)
        floor = ("--floor", "room", "--pace", "realtime", "--logs", str(tmp_path / "run"))
        words = [sys.executable, "-m", "intellwheels_experiments", *floor, *link, "--listen", stage.endpoint]
        run = stage.launch("run", lambda _lifeline: words, merge_errors=True)
        real_chair(stage, tmp_path, *link, "--connect", stage.endpoint)
        with stage.peer() as listener, stage.peer() as peer:
            heard: Any = listener.session.declare_subscriber(f"{listener.prefix}in/**", lambda _: None)
            listener.clock()  # the simulator knows the subscription now
            attack(peer)
            stage.line("firmware", "stopped")
            assert stage.exit(run) == 1
            assert "server: exit 1" in stage.log(run)
            assert "start it again" in stage.log(run)
            heard.undeclare()
