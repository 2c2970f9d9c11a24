"""A held key moves a chair; releasing it, or killing the joystick, stops the chair. Real processes, simulated time.

The motors obey at once (`AccelerationCurve=0`), so the chair stands as soon as its power is zero.
"""

from __future__ import annotations

import json
import math
import os
import signal
import sys
from collections import deque
from typing import Any

import pytest

from tests.e2e.stage import Peer, Stage

PERIOD = 0.05
STOPPED = 0.3 + PERIOD
"""Most simulated seconds from the last input that the mind got to a standing chair: the time-out, and a tick for the
mind's answer."""
AT_ONCE = ("--option", "AccelerationCurve=0")


def joystick(stage: Stage, script: str, *words: str) -> str:
    file = stage.folder / "script.txt"
    file.write_text(script)
    return stage.start(
        "joystick", "intellwheels_agents.joystick", "chair1", "--source", "script", "--script", str(file),
        "--connect", stage.endpoint, "--world", stage.world, *words,
    )  # fmt: skip


class Watch:
    """Everything heard of the chair."""

    def __init__(self, peer: Peer) -> None:
        self.peer = peer
        self.states = peer.hear("state/*")
        self.inputs = peer.hear("user/chair1")
        self.measures = peer.hear("out/chair1/measures")

    def speeds(self) -> list[tuple[int, float]]:
        """Return tick and speed of every state so far."""
        return [
            (state["Tick"], entity.get("Speed", 0.0))
            for state in _documents(self.states)
            for entity in state.get("Entity", [])
            if entity["Name"] == "chair1"
        ]

    def moves(self) -> int:
        """Wait until the chair moves; return the tick."""

        def found() -> int | None:
            return next((tick for tick, speed in self.speeds() if speed > 0.1), None)

        return self.peer.stage.wait(found, "a chair that moves", unless=self.peer.stage.simulator)

    def stands(self, after: int) -> int:
        """Wait until the chair stands for good; return the first tick at which it stands."""

        def found() -> int | None:
            speeds = [entry for entry in self.speeds() if entry[0] > after]
            last = max((tick for tick, speed in speeds if abs(speed) > 1e-6), default=after)
            rest = [tick for tick, _ in speeds if tick > last]
            # A second: the state of a world in which nothing moves comes twice in it.
            return rest[0] if rest and rest[-1] - rest[0] >= 20 else None

        return self.peer.stage.wait(found, "a chair that stands", unless=self.peer.stage.simulator)

    def last_heard(self) -> int:
        """Return the tick of the first measures that have the last input with a forward value."""
        users: list[tuple[int, dict[str, Any]]] = [
            (m["Tick"], m.get("UserInput") or {}) for m in _documents(self.measures)
        ]
        wanted = [(tick, user["Seq"]) for tick, user in users if user.get("Forward")]
        last = wanted[-1][1]
        return next(tick for tick, seq in wanted if seq == last)


def _documents(heard: deque[Any]) -> list[dict[str, Any]]:
    return [json.loads(data) for _, data in list(heard)]


HELD = "0 0.5 0\n600 0 0\n"


@pytest.mark.parametrize("mind", ["joystick", "aided"])
def test_a_held_key_moves_the_chair_and_its_release_stops_it(stage: Stage, mind: str) -> None:
    stage.server("--map", "corridor15m", "--pace", "realtime")
    stage.agent("chair1", mind, *AT_ONCE)
    with stage.peer() as peer:
        watch = Watch(peer)
        child = joystick(stage, "0 0.5 0\n1.5 0 0\n600 0 0\n", "--clock", "simulated")
        began = watch.moves()
        rest = watch.stands(began)
        assert (rest - watch.last_heard()) * PERIOD <= STOPPED + 1e-9
        # The script's own seconds are the simulation's: 1.5 s held.
        assert (rest - began) * PERIOD == pytest.approx(1.5, abs=STOPPED)
        zeros = [user for user in _documents(watch.inputs) if not user.get("Forward")]
        assert len(zeros) == 3
        stage.signal(child, signal.SIGTERM)
        assert stage.exit(child) == 0


@pytest.mark.parametrize("how", ["mind", "lease"])
def test_a_killed_joystick_stops_the_chair_within_0_3_s_and_a_tick(stage: Stage, how: str) -> None:
    stage.server("--map", "corridor15m", "--pace", "realtime")
    stage.agent("chair1", "joystick", *AT_ONCE)
    with stage.peer() as peer:
        watch = Watch(peer)
        child = joystick(stage, HELD, *(["--take"] if how == "lease" else []))
        began = watch.moves()
        stage.signal(child, signal.SIGKILL)
        assert stage.exit(child) == -signal.SIGKILL
        rest = watch.stands(began)
        assert (rest - watch.last_heard()) * PERIOD <= STOPPED + 1e-9
        # Nobody repeats its input.
        assert all(user["Forward"] == 0.5 for user in _documents(watch.inputs))


def test_keys_of_a_terminal_drive_while_they_repeat(stage: Stage) -> None:
    stage.server("--map", "corridor15m", "--pace", "realtime")
    stage.agent("chair1", "joystick", *AT_ONCE)
    ours, theirs = os.openpty()
    try:
        command = [
            sys.executable, "-m", "intellwheels_agents.joystick", "chair1", "--source", "terminal",
            "--connect", stage.endpoint, "--world", stage.world,
        ]  # fmt: skip
        terminal = os.ttyname(theirs)
        child = stage.launch(
            "joystick", lambda fd: ["sh", "-c", 'exec "$@" < "$0"', terminal, *command, "--lifeline", str(fd)]
        )
        stage.line(child, "ready", agent="chair1")
        with stage.peer() as peer:
            watch = Watch(peer)

            def driven() -> bool | None:
                os.write(ours, b"W")  # with shift: full power
                return True if [tick for tick, speed in watch.speeds() if speed > 0.9] else None

            stage.wait(driven, "a chair at full speed", unless=child)
            began = watch.moves()
            rest = watch.stands(began)
            # The last key counts for 0.3 s; then its release is sent.
            assert (rest - watch.last_heard()) * PERIOD <= STOPPED + 1e-9
        os.write(ours, b"\x04")
        assert stage.exit(child) == 0
    finally:
        os.close(ours)
        os.close(theirs)


def test_a_lease_outranks_the_mind_and_is_given_back(stage: Stage) -> None:
    stage.server("--map", "corridor15m", "--pace", "realtime")
    stage.agent("chair1", "drive", "--option", "left=-0.1", "--option", "right=-0.1", *AT_ONCE)
    with stage.peer() as peer:
        peer.entity("chair1", lambda entity: entity.get("Speed", 0.0) < -0.05)
        # Longer than a lease: it is renewed.
        child = joystick(stage, "0 0.3 0\n3.5 0 0\n", "--take")
        stage.line(child, "taken", agent="chair1")
        taken = peer.event("taken", "chair1")
        peer.entity("chair1", lambda entity: entity.get("Speed", 0.0) > 0.25)
        assert peer.ctl("take", Agent="chair1")["Code"] == "incorrect-state"
        stage.line(child, "released", agent="chair1")
        assert stage.exit(child) == 0
        released = peer.event("released", "chair1", since=taken["Number"])
        assert released["Tick"] - taken["Tick"] > 2.0 / PERIOD
        codes = [event["Code"] for event in peer.events()]
        assert codes.count("taken") == codes.count("released") == 1
        peer.entity("chair1", lambda entity: entity.get("Speed", 0.0) < -0.05)


def test_the_mind_gets_its_chair_back_when_the_joystick_with_the_lease_dies(stage: Stage) -> None:
    stage.server("--map", "corridor15m", "--pace", "realtime")
    stage.agent("chair1", "drive", "--option", "left=-0.1", "--option", "right=-0.1", *AT_ONCE)
    with stage.peer() as peer:
        child = joystick(stage, HELD, "--take")
        peer.entity("chair1", lambda entity: entity.get("Speed", 0.0) > 0.25)
        stage.signal(child, signal.SIGKILL)
        peer.event("released", "chair1")
        peer.entity("chair1", lambda entity: entity.get("Speed", 0.0) < -0.05)


def test_a_taken_or_missing_chair_is_refused(stage: Stage) -> None:
    stage.server("--map", "corridor15m", "--pace", "realtime")
    with stage.peer() as peer:
        child = joystick(stage, HELD, "--take")
        assert stage.exit(child) == 1
        assert "waiting why='no agent chair1 yet'" in stage.log(child)
        assert "no agent 'chair1' here" in stage.log(child)
        stage.agent("chair1", "joystick")
        assert peer.ctl("take", Agent="chair1", Seconds=60.0)["Code"] == "ok"
        child = joystick(stage, HELD, "--take")
        assert stage.exit(child) == 1
        assert "agent 'chair1' is taken by somebody else" in stage.log(child)


def test_a_mind_in_its_own_process_gets_the_user_input_too(stage: Stage) -> None:
    stage.server("--map", "corridor15m", "--pace", "realtime")
    with stage.peer() as peer:
        robot = {"Name": "chair1", "Kind": "wheelchair", "TopSpeed": 1.0, "Length": 1.0, "Width": 0.6}
        assert peer.ctl("spawn", Robot=robot)["Code"] == "ok"
        stage.start(
            "mind", "intellwheels_agents", "joystick", "--name", "chair1", "--role", "mind",
            "--connect", stage.endpoint, "--world", stage.world,
        )  # fmt: skip
        stage.line("mind", "joined")
        joystick(stage, HELD)
        assert Watch(peer).moves() > 0


@pytest.mark.parametrize("mind", ["waypoints", "seek"])
def test_a_goal_set_under_a_lease_is_where_the_chair_arrives(stage: Stage, mind: str) -> None:
    stage.server("--map", "room", "--pace", "realtime", "--speed", "4")
    stage.agent("chair1", mind, "--place", "start1", "--option", "to=start1", robot="corridor-chair")
    with stage.peer() as peer:
        assert peer.ask("body/chair1")[0]["Robot"]["UserInput"] == ["goal"]
        start = peer.entity("chair1", lambda entity: entity.get("Mode") == "arrived")
        goal = {"X": start["X"] + 2.0, "Y": start["Y"]}
        lease = peer.ctl("take", Agent="chair1", Seconds=6.0)["Lease"]
        peer.put("user/chair1", {"Lease": lease, "Goal": goal})
        peer.entity("chair1", lambda entity: entity.get("Goal") == pytest.approx(goal))
        assert peer.ctl("take", Agent="chair1", Lease=lease, Seconds=0.0)["Code"] == "ok"

        def there(entity: dict[str, Any]) -> bool:
            return math.dist((entity["X"], entity["Y"]), (goal["X"], goal["Y"])) < 0.3

        arrived = peer.entity("chair1", lambda entity: there(entity) and entity.get("Mode") == "arrived")
        assert arrived["Goal"] == pytest.approx(goal)
