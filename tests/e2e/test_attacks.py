"""What a stranger may not do in a world without access rules, and the rightful twin of each attack.

One simulator, a virtual chair, and a real chair on a firmware stand-in serve all cases. They end as they began.
"""

from __future__ import annotations

import json
import math
import os
import signal
from collections import deque
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import zenoh

from tests.e2e.stage import JSON, Peer, Stage

LAST = 2**53 - 1
STRANGER = "f" * 16
FULL_TURN = {"LeftMotor": 1.0, "RightMotor": -1.0, "State": "drive"}


class World:
    """The processes of all cases."""

    def __init__(self, stage: Stage, peer: Peer) -> None:
        self.stage, self.peer = stage, peer

    def run(self) -> str:
        return str(self.peer.clock()["Run"])

    def turns_on(self, name: str = "chair1") -> None:
        """Wait until a chair has turned on: its mind hears and its simulator obeys."""
        before = self.peer.entity(name, lambda entity: True)["Heading"]
        self.peer.entity(name, lambda entity: abs(math.remainder(entity["Heading"] - before, math.tau)) > 0.01)

    def starts_of_motors(self) -> int:
        """Return how often the motors of the real chair have started."""
        return self.stage.log("firmware").count("moving ")

    def is_said(self, child: str, text: str) -> None:
        self.stage.wait(lambda: text in self.stage.log(child) or None, f"{text!r} of {child}")


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> Iterator[World]:
    folder: Path = tmp_path_factory.mktemp("attacks")
    with Stage(folder, "attacks") as stage:
        stage.server("--map", "room", "--pace", "realtime")
        stage.agent("chair1", "drive", "--option", "left=0.2", "--option", "right=-0.2", joined=False)
        stage.agent("chair2", "joystick", joined=False)
        os.mkfifo(folder / "ask")
        stand_in = "intellwheels_agents.bridge.firmware_stand_in"
        stage.start("firmware", stand_in, "--link", str(folder / "tty"), "--ask", str(folder / "ask"))
        stage.line("firmware", "ready")
        link = ["--name", "real1", "--connect", stage.endpoint, "--world", stage.world]
        stage.start("bridge", "intellwheels_agents.bridge", "serial", "--port", str(folder / "tty"), *link)
        for child in ("chair1", "chair2", "bridge"):
            stage.line(child, "joined")
        with stage.peer() as peer:
            yield World(stage, peer)


Attack = Callable[[World], None]


def _drive_without_session(world: World) -> None:
    errors = world.peer.errors("chair2")
    before = world.peer.entities()["chair2"]
    world.peer.put("in/chair2/actions", {"LeftMotor": 1.0, "RightMotor": 1.0})
    assert "Actions.Session" in world.peer.error(errors, "field")["Text"]
    world.peer.ticks_on(5)
    assert world.peer.entities()["chair2"]["X"] == before["X"]


def _leave_in_anothers_name(world: World) -> None:
    for payload in (b"", b"{}", json.dumps({"Session": STRANGER}).encode()):
        (result,) = world.peer.ask("leave/chair1", payload)
        assert "ession" in result["Text"]
    world.turns_on()


def _steer_without_the_agent_in_the_key(world: World) -> None:
    for verb in ("take", "delete", "teleport"):
        (result,) = world.peer.ask(f"ctl/{verb}", {"Agent": "chair1", "Position": {"X": 1, "Y": 1, "Heading": 0}})
        assert result["Code"] == "failed"
    world.turns_on()


def _measures_of_another_run(world: World) -> None:
    world.peer.put("out/chair1/measures", {"Run": STRANGER, "Tick": 0, "Time": 0.0})
    # The 1st, 10th and so on of such messages get a line.
    world.is_said("chair1", "dropped message=Measures why='the simulator said run")
    world.turns_on()


def _tick_far_ahead(world: World) -> None:
    world.peer.put("out/chair1/measures", {"Run": world.run(), "Tick": LAST, "Time": 1.0})
    world.peer.put("out/real1/measures", {"Run": world.run(), "Tick": LAST, "Time": 1.0})
    world.turns_on()
    world.peer.ticks_on(10)
    # A deaf bridge would report no pose any more. On a busy machine a pose may be late.
    fresh = lambda: world.peer.entities()["real1"].get("State", "drive") != "stale" or None  # noqa: E731
    world.stage.wait(fresh, "poses of a bridge that is not deaf")


def _ticks_far_ahead_at_each_tick(world: World) -> None:
    """While the run stands, no tick passes but those that are asked for: each is answered before the next one."""
    peer, run = world.peer, world.run()
    assert peer.ctl("pause")["Code"] == "ok"
    heard = {"real1": peer.hear("in/real1/pose"), "chair1": peer.hear("in/chair1/actions")}
    for _ in range(3):
        for name in heard:
            for false in (run, STRANGER):
                peer.put(f"out/{name}/measures", {"Run": false, "Tick": LAST, "Time": 1.0})
        assert peer.ctl("step")["Code"] == "ok"
        (clock,) = peer.ask("clock")
        for name, answers in heard.items():

            def answered(answers: deque[Any] = answers, tick: int = clock["Tick"]) -> bool | None:
                return any(json.loads(data).get("Tick") == tick for _, data in list(answers)) or None

            world.stage.wait(answered, f"answer of {name} to tick {clock['Tick']}")
        assert peer.ask("clock")[0]["Tick"] == clock["Tick"]
    assert peer.ctl("resume")["Code"] == "ok"
    world.turns_on()


def _news_of_a_deletion(world: World) -> None:
    said = {"Run": world.run(), "Tick": 1, "Code": "deleted", "Text": "deleted"}
    world.peer.put("out/chair1/error", said)
    world.is_said("chair1", "it says deleted, but the body is here")
    world.turns_on()


def _power_for_the_motors(world: World) -> None:
    run, before = world.run(), world.starts_of_motors()
    for seq in range(100):
        world.peer.put("out/real1/power", {"Run": run, "Tick": LAST, "Seq": LAST, **FULL_TURN, "Code": f"{seq:032x}"})
        world.peer.put("out/real1/power", {"Run": run, "Tick": seq, **FULL_TURN})
    world.is_said("bridge", "Power.Code: expected the code that our key makes")
    world.peer.ticks_on(5)
    assert world.starts_of_motors() == before


def _copied_power(world: World) -> None:
    heard, before = world.peer.hear("out/real1/power", 1), world.starts_of_motors()
    _, copy = world.stage.wait(lambda: next(iter(heard), None), "power")
    world.peer.put("out/real1/power", copy)
    world.peer.put("out/real1/power", json.loads(copy) | FULL_TURN)
    world.peer.ticks_on(5)
    assert world.starts_of_motors() == before


def _pose_of_a_real_chair(world: World) -> None:
    errors, before = world.peer.errors("real1"), world.peer.entities()["real1"]
    poses = world.peer.hear("in/real1/pose", 1)
    _, copy = world.stage.wait(lambda: next(iter(poses), None), "pose")
    for moved in (json.loads(copy) | {"X": before["X"] + 3.0, "Seq": LAST}, {"X": 1.0, "Y": 1.0, "Heading": 0.0}):
        world.peer.put("in/real1/pose", {"Session": json.loads(copy)["Session"], **moved})
    world.peer.error(errors, "forged")
    world.peer.ticks_on(5)
    # It may still roll from an attack before, by centimetres; the forged pose is 3 m away.
    assert abs(world.peer.entities()["real1"]["X"] - before["X"]) < 0.3


def _join_in_the_name_of_a_bridge(world: World) -> None:
    tokens = world.peer.session.liveliness().get(f"{world.peer.prefix}in/real1/alive/*/*")
    instance = next(str(reply.ok.key_expr).rpartition("/")[2] for reply in tokens if reply.ok is not None)
    (body,) = world.peer.ask("body/real1")
    robot = {key: value for key, value in body["Robot"].items() if key != "Position"} | {"Instance": instance}
    for joined in world.peer.ask("join/real1", robot):
        assert "Key" not in joined


def _answer_to_a_join(world: World) -> None:
    (body,) = world.peer.ask("body/chair1")
    (clock,) = world.peer.ask("clock")
    false = {
        "Run": STRANGER, "Tick": 0, "Session": STRANGER, "Position": {"X": 0.0, "Y": 0.0, "Heading": 0.0},
        "Parameters": {"World": world.stage.world, "Period": 0.05, "Pace": clock["Pace"], "SayLimit": 9,
                       "SayRange": 9.0, "CommandTimeout": 0.5, "Grace": 3.0},
        "Robot": body["Robot"],
    }  # fmt: skip

    def answer(query: zenoh.Query) -> None:
        with query:
            query.reply(str(query.key_expr), json.dumps(false), encoding=JSON)

    queryable: Any = world.peer.session.declare_queryable(f"{world.peer.prefix}join/*", answer)
    try:
        child = world.stage.agent("chair3", "drive", "--option", "left=0.2", "--option", "right=-0.2", joined=False)
        assert world.stage.line(child, "joined")["run"] == world.run()
        world.turns_on("chair3")
    finally:
        queryable.undeclare()
        world.peer.ctl("delete", Agent="chair3")


ATTACKS: dict[str, Attack] = {
    "drive a chair without its session": _drive_without_session,
    "make a chair leave": _leave_in_anothers_name,
    "a verb about an agent without it in the key": _steer_without_the_agent_in_the_key,
    "measures of another run": _measures_of_another_run,
    "a tick far ahead": _tick_far_ahead,
    "a tick far ahead at each tick": _ticks_far_ahead_at_each_tick,
    "the news of a deletion": _news_of_a_deletion,
    "power for the motors of a real chair": _power_for_the_motors,
    "a copy of a power, and a changed copy": _copied_power,
    "a pose of a real chair": _pose_of_a_real_chair,
    "a join in the name of a bridge": _join_in_the_name_of_a_bridge,
    "an answer to a join in the simulator's name": _answer_to_a_join,
}


@pytest.mark.process
@pytest.mark.parametrize("attack", ATTACKS)
def test_stranger_in_an_open_world_achieves_nothing(world: World, attack: str) -> None:
    ATTACKS[attack](world)


@pytest.mark.process
def test_who_may_does_the_same(world: World) -> None:
    peer = world.peer
    lease = peer.ctl("take", Agent="chair2", Seconds=30.0)["Lease"]
    peer.put("user/chair2", {"Lease": lease, "Forward": 0.0, "Turn": 0.5, "Seq": 1})
    assert peer.ctl("take", Agent="chair2", Lease=lease, Seconds=0.0)["Code"] == "ok"
    world.stage.agent("chair4", "drive", "--option", "left=0.2", "--option", "right=-0.2")
    (result,) = peer.ask("leave/chair4", {"Session": peer.session_of("chair4")})
    assert result["Code"] == "ok"
    peer.event("left", "chair4")
    world.stage.signal("chair4", signal.SIGKILL)
    # The mind of the real chair drives it; its simulator's powers reach the motors.
    stage = world.stage
    child = stage.start(
        "mind", "intellwheels_agents", "drive", "--name", "real1", "--role", "mind", "--connect", stage.endpoint,
        "--world", stage.world, "--option", "left=0.1", "--option", "right=0.1",
    )  # fmt: skip
    stage.line(child, "joined")
    stage.line("firmware", "moving")
    stage.signal(child, signal.SIGTERM)
    stage.line("firmware", "stopped")
