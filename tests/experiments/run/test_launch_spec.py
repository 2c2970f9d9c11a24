"""The command lines of a run's processes."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import pytest
from msgspec.structs import replace as replace_struct

from intellwheels_experiments.run.launch_spec import WALL_LIMIT, LaunchSpec, wall_limit
from intellwheels_schemas.messages import Bridge, Cast, End, Map, Option, Scene, Timeout

SCENE = Scene(format="iw.v1", name="test", map="room", seed="a b", end=End(timeout=Timeout(seconds=100.0)))
SPEC = LaunchSpec(
    scene=SCENE,
    source="figure6",
    floor=Map(format="iw.v1", name="room"),
    world="main",
    listen=("tcp/127.0.0.1:7000",),
    logs=Path("logs"),
    folder=Path("/scenes"),
)


def test_server_gets_scene_seed_and_pace() -> None:
    command = SPEC.server_command(5)
    # A file such as queue.py in the working directory replaces no module of Python.
    assert command[:4] == [sys.executable, "-P", "-m", "intellwheels_server"]
    for name, value in (("--scene", "figure6"), ("--seed", "a b"), ("--pace", "lockstep"), ("--lifeline", "5")):
        assert command[command.index(name) + 1] == value
    assert "--speed" not in command


def test_free_pace_is_open_loop() -> None:
    spec = replace(SPEC, scene=Scene(format="iw.v1", name="test", map="room", pace="free"))
    assert "--open-loop" in spec.server_command(5)


def test_paths_of_a_scene_start_from_its_folder_and_names_stay() -> None:
    command = SPEC.agent_command(Cast(name="chair1", robot="own/robot.xml", mind="mind.py"), 5)
    assert command[command.index("intellwheels_agents") + 1] == "/scenes/mind.py"
    assert command[command.index("--robot") + 1] == "/scenes/own/robot.xml"
    assert SPEC.agent_command(Cast(name="chair1", robot="table", mind="table"), 5)[4] == "table"


def test_options_and_place_are_passed_on() -> None:
    cast = Cast(name="c", robot="table", mind="table", place="start1", option=(Option(name="points", value="1 2=3"),))
    command = SPEC.agent_command(cast, 5)
    assert command[command.index("--option") + 1] == "points=1 2=3"
    assert command[command.index("--place") + 1] == "start1"


def test_scene_with_bridges_has_a_laboratory_that_hides_the_truth_and_minds_without_a_body() -> None:
    cast = Cast(
        name="c", robot="intellwheels", mind="avoid", place="start1",
        option=(Option(name="speed", value="0.4"), Option(name="MotorNoise", value="0.1")),
    )  # fmt: skip
    bridge = Bridge(agent="c", option=(Option(name="pose", value="raw"), Option(name="WheelRatio", value="1.002")))
    scene = replace_struct(SCENE, cast=(cast,), bridge=(bridge,))
    spec = replace(SPEC, scene=scene, laboratory="tcp/127.0.0.1:7001", log=Path("a/run.jsonl"))
    laboratory = " ".join(spec.laboratory_command(5)[3:])
    for words in (
        "--world lab --listen tcp/127.0.0.1:7001",
        "--expect c",
        "--hide-truth",
        "--seed a b",
        "run-lab.jsonl",
    ):
        assert words in laboratory
    command = " ".join(spec.bridge_command(cast, 5)[3:])
    for words in ("--lab-world lab --lab-connect tcp/127.0.0.1:7001", "--pose raw", "--connect tcp/127.0.0.1:7000"):
        assert words in command
    assert "--option MotorNoise=0.1" in command
    assert "--chair-option WheelRatio=1.002" in command
    mind = " ".join(spec.agent_command(cast, 5)[3:])
    assert "--role mind" in mind
    assert "--option speed=0.4" in mind
    assert "MotorNoise" not in mind
    assert "--place" not in mind


def test_laboratory_of_world_lab_has_another_name() -> None:
    assert (SPEC.lab, replace(SPEC, world="lab").lab) == ("lab", "lab2")


@pytest.mark.parametrize(("pace", "limit"), [("lockstep", WALL_LIMIT), ("realtime", WALL_LIMIT + 50.0)])
def test_wall_limit_leaves_room_for_real_time(pace: str, limit: float) -> None:
    scene = Scene(format="iw.v1", name="t", map="room", pace=pace, end=SCENE.end)  # type: ignore[arg-type]
    assert wall_limit(scene, 2.0) == limit


def test_agents_connect_where_the_simulator_listens() -> None:
    cast = Cast(name="c", robot="table", mind="table")
    server, agent = SPEC.server_command(5), SPEC.agent_command(cast, 5)
    assert server[server.index("--listen") + 1] == agent[agent.index("--connect") + 1] == "tcp/127.0.0.1:7000"
    assert "--listen" not in agent


def test_all_connect_to_a_router() -> None:
    spec = replace(
        SPEC, listen=(), connect=("tcp/router:7447",), config=Path("/secure.json5"), identity=Path("/me.iwid")
    )
    server, agent = spec.server_command(5), spec.agent_command(Cast(name="c", robot="table", mind="table"), 5)
    for command in (server, agent):
        assert command[command.index("--connect") + 1] == "tcp/router:7447"
        assert command[command.index("--config") + 1] == "/secure.json5"
        assert command[command.index("--identity") + 1] == "/me.iwid"
        assert "--listen" not in command


def test_the_page_is_dark_if_that_is_wanted() -> None:
    assert "--dark" not in replace(SPEC, view=0).viewer_command(3)
    assert "--dark" in replace(SPEC, view=0, dark=True).viewer_command(3)
