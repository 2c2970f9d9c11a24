"""What survives when a process is killed, frozen, stuck, late, doubled or hostile, and what is reported.

Everything here is real processes on loopback; each test says what goes on and with which code.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.e2e.minds import SLOW_ONCE, STUCK, write
from tests.e2e.stage import DEADLINE, XML, Peer, Stage, children_of, is_gone, resident

AHEAD = ("--option", "left=0.2", "--option", "right=0.2")
ELASTIC = ("--map", "room", "--pace", "lockstep", "--miss", "elastic", "--deadline", "0.3")
REALTIME = ("--map", "corridor15m", "--pace", "realtime")


def moves(peer: Peer, name: str = "chair1") -> None:
    """Wait until a body is seen to move ahead."""
    x = peer.entity(name, lambda entity: True)["X"]
    peer.entity(name, lambda entity: entity["X"] > x + 0.005)


def stands(peer: Peer, name: str = "chair1") -> None:
    """Wait until a body has come to rest."""
    peer.entity(name, lambda entity: abs(entity.get("Speed", 0.0)) < 1e-3)


def wake(pipe: Path) -> None:
    """Let a mind go on that waits for this pipe; an error if none does."""
    os.close(os.open(pipe, os.O_WRONLY | os.O_NONBLOCK))


# ---------------------------------------------------------------- kill


def test_successor_of_a_killed_agent_drives_on_in_its_body(stage: Stage) -> None:
    stage.server(*REALTIME)
    first = stage.agent("chair1", "drive", *AHEAD)
    with stage.peer() as peer:
        moves(peer)
        stage.signal(first, signal.SIGKILL)
        lost = peer.event("lost", "chair1")
        assert stage.exit(first) == -signal.SIGKILL
        before = peer.entities()["chair1"]["X"]
        stage.agent("chair1", "drive", *AHEAD)
        peer.event("returned", "chair1", since=lost["Number"])
        moves(peer)
        assert peer.entities()["chair1"]["X"] >= before
        assert not [event for event in peer.events() if event["Code"] == "left"]


def test_killed_agent_without_a_successor_is_taken_out_after_the_grace_time(stage: Stage) -> None:
    stage.server(*REALTIME, "--grace", "1")
    first = stage.agent("chair1", "drive", *AHEAD)
    with stage.peer() as peer:
        moves(peer)
        stage.signal(first, signal.SIGKILL)
        lost = peer.event("lost", "chair1")
        left = peer.event("left", "chair1", since=lost["Number"])
        assert 15 <= left["Tick"] - lost["Tick"] <= 40  # 1 s at 20 Hz, on a busy machine
        assert "chair1" not in peer.entities()
        stage.agent("chair1", "drive", *AHEAD)
        moves(peer)


# ---------------------------------------------------------------- freeze


def test_frozen_agent_wakes_as_a_stale_twin_and_gives_way(stage: Stage) -> None:
    stage.server(*REALTIME)
    twin = stage.agent("chair1", "drive", "--option", "left=-0.5", "--option", "right=-0.5")
    with stage.peer() as peer:
        peer.ticks_on(5)
        stage.signal(twin, signal.SIGSTOP)
        # The token of a process that does not answer goes with its transport's lease.
        peer.event("timeout", "chair1")
        peer.event("lost", "chair1")
        stage.agent("chair1", "drive", *AHEAD)
        moves(peer)
        stage.signal(twin, signal.SIGCONT)
        assert stage.exit(twin) == 1
        assert "already-here" in stage.log(twin)
        moves(peer)


# ---------------------------------------------------------------- stuck, late


def test_agent_stuck_in_its_own_code_times_out_and_is_there(stage: Stage) -> None:
    stage.server(*REALTIME)
    stage.agent("chair1", write(stage.folder, "stuck", STUCK))
    with stage.peer() as peer:
        peer.event("timeout", "chair1")
        stands(peer)
        assert peer.entities()["chair1"]["State"] == "timeout"
        assert not [event for event in peer.events() if event["Code"] in ("lost", "left")]
        peer.ticks_on(10)


def test_agent_stuck_in_a_lockstep_is_put_to_rest_and_the_others_go_on(stage: Stage) -> None:
    stage.server(
        "--map", "room", "--pace", "lockstep", "--miss", "elastic", "--deadline", "0.3", "--expect", "chair1,chair2"
    )
    stage.agent("chair1", write(stage.folder, "stuck", STUCK), joined=False)
    stage.agent("chair2", "drive", joined=False)
    with stage.peer() as peer:
        assert peer.event("late", "chair1")["Tick"] >= 20
        rested = peer.event("rested", "chair1")
        peer.tick(rested["Tick"] + 50)
        stands(peer)
        assert peer.entities()["chair1"]["State"] == "rested"


def test_agent_stuck_in_a_strict_lockstep_ends_the_run(stage: Stage) -> None:
    server = stage.server("--map", "room", "--pace", "lockstep", "--deadline", "0.5", "--expect", "chair1")
    stage.agent("chair1", write(stage.folder, "stuck", STUCK), joined=False)
    assert stage.line(server, "miss") == {"agent": "chair1", "tick": "20"}
    assert stage.exit(server) == 1


def test_late_agent_is_reported_and_answers_again(stage: Stage) -> None:
    stage.server(
        "--map", "room", "--pace", "lockstep", "--miss", "elastic", "--deadline", "0.3", "--expect", "chair1,chair2"
    )
    stage.agent("chair2", "drive", joined=False)
    with stage.peer() as peer:
        errors = peer.errors("chair1")
        stage.agent("chair1", write(stage.folder, "slow", SLOW_ONCE), joined=False)
        peer.event("late", "chair1")
        rested = peer.event("rested", "chair1")
        wake(stage.folder / "slow.pipe")
        back = peer.event("back", "chair1", since=rested["Number"])
        assert peer.error(errors, "late")["Code"] == "late"
        peer.tick(back["Tick"] + 50)
        assert peer.entity("chair1", lambda entity: entity.get("Speed", 0.0) > 0.05)


# ---------------------------------------------------------------- two of one name


def test_second_agent_of_one_name_is_refused_in_words(stage: Stage) -> None:
    stage.server(*REALTIME)
    stage.agent("chair1", "drive", *AHEAD)
    second = stage.agent("chair1", "drive", joined=False)
    assert stage.exit(second) == 1
    assert "agent 'chair1' is already here" in stage.log(second)
    with stage.peer() as peer:
        moves(peer)


def test_second_simulator_of_a_world_refuses_to_start(stage: Stage) -> None:
    stage.server(*REALTIME)
    second = stage.start("second", "intellwheels_server", "--connect", stage.endpoint, "--world", stage.world)
    assert stage.exit(second) == 1
    assert stage.world in stage.log(second)
    with stage.peer() as peer:
        peer.ticks_on(5)


def test_second_simulator_on_a_port_says_that_it_is_in_use(stage: Stage) -> None:
    stage.server(*REALTIME)
    second = stage.start("second", "intellwheels_server", "--listen", stage.endpoint, "--world", "other")
    assert stage.exit(second) == 1
    assert "the port is in use" in stage.log(second)


# ---------------------------------------------------------------- hostile bytes


def test_flood_of_commands_is_bounded_and_the_others_drive_on(stage: Stage) -> None:
    server = stage.server("--map", "room", "--pace", "realtime")
    stage.agent("chair1", "drive", *AHEAD)
    stage.agent("chair2", "drive", *AHEAD)
    with stage.peer() as peer:
        errors = peer.errors("chair2")
        before = peer.clock()
        memory = resident(stage.pid(server))
        drive = {"Session": peer.session_of("chair2"), "LeftMotor": 0.1, "RightMotor": 0.1}
        for number in range(20_000):
            peer.put("in/chair2/actions", {**drive, "Seq": number})
        assert peer.error(errors, "too-many")
        after = peer.tick(before["Tick"] + 20)
        # 5 a second to one agent and 10 at once: what was kept back is counted, not sent.
        assert len(errors) <= 10 + 5 * (after["Stamp"] - before["Stamp"]) + 1
        assert resident(stage.pid(server)) - memory < 32 << 20
        moves(peer)


def test_wildcard_put_moves_nobody(stage: Stage) -> None:
    stage.server("--map", "room", "--pace", "realtime", "--command-timeout", "0.2")
    stage.agent("chair1", "table", "--option", "TopSpeed=1.0")
    with stage.peer() as peer:
        peer.entity("chair1", lambda entity: True)
        before = peer.entities()["chair1"]
        drive = {"Session": peer.session_of("chair1"), "LeftMotor": 1.0, "RightMotor": 1.0}
        for _ in range(20):
            peer.put("in/*/actions", drive)
            peer.put("in/**", drive)
        peer.ticks_on(10)
        # On a busy machine its own commands may be late.
        other = {"State": "", "CommandAge": 0.0}
        assert peer.entities()["chair1"] | other == before | other


def test_delete_sample_is_dropped(stage: Stage) -> None:
    server = stage.server(*REALTIME)
    stage.agent("chair1", "drive", *AHEAD)
    with stage.peer() as peer:
        for key in ("in/chair1/actions", "in/*/actions", "user/chair1", "in/chair1/say"):
            peer.session.delete(peer.prefix + key)
        moves(peer)
    assert "Traceback" not in stage.log(server)


def test_message_of_2_megabytes_hurts_nobody_else(stage: Stage) -> None:
    server = stage.server(*REALTIME)
    stage.agent("chair1", "drive", *AHEAD)
    with stage.peer() as peer:
        memory = resident(stage.pid(server))
        for _ in range(5):
            peer.put("in/chair1/actions", b'{"Say":"' + b"a" * (2 << 20) + b'"}')
    with stage.peer() as peer:
        moves(peer)
        assert resident(stage.pid(server)) - memory < 16 << 20


def test_json_and_xml_meet_in_one_world(stage: Stage) -> None:
    stage.server("--map", "room", "--pace", "realtime")
    stage.agent("chair1", "drive", "--encoding", "xml")
    stage.agent("chair2", "drive", "--encoding", "json")
    with stage.peer() as peer:
        heard = peer.hear("out/chair2/measures")
        raw: list[bytes] = []
        listener = peer.session.declare_subscriber(
            f"{peer.prefix}out/chair1/measures", lambda sample: raw.append(bytes(sample.payload))
        )
        ours = peer.session_of("chair1")
        said = f'<Say Session="{ours}"><![CDATA[plain words]]></Say>'
        peer.put("in/chair1/say", said.encode(), XML)

        def hears() -> list[Any] | None:
            found = [json.loads(data).get("Message") for _, data in list(heard)]
            return next((messages for messages in found if messages), None)

        (message,) = stage.wait(hears, "words of chair1")
        assert (message["From"], message["Text"]) == ("chair1", "plain words")
        peer.put("in/chair2/say", {"Session": peer.session_of("chair2"), "Text": "<&> in JSON"})
        stage.wait(lambda: next((data for data in list(raw) if b"<&> in JSON" in data), None), "words of chair2 in XML")
        listener.undeclare()  # type: ignore[no-untyped-call]


# ---------------------------------------------------------------- the simulator begins anew


def test_reset_begins_a_new_run_for_living_agents(stage: Stage) -> None:
    stage.server(*REALTIME)
    agent = stage.agent("chair1", "drive", *AHEAD)
    with stage.peer() as peer:
        moves(peer)
        start = peer.clock()["Run"]
        result = peer.ctl("reset")
        assert result["Code"] == "ok"
        assert result["Run"] != start
        assert stage.line(agent, "run")["run"] == result["Run"]
        moves(peer)


@pytest.mark.parametrize("end", [signal.SIGKILL, signal.SIGTERM], ids=["killed", "terminated"])
def test_agents_join_again_when_the_simulator_comes_back(stage: Stage, end: signal.Signals) -> None:
    first = stage.server(*REALTIME)
    agent = stage.agent("chair1", "drive", *AHEAD)
    stage.signal(first, end)
    stage.exit(first)
    stage.server(*REALTIME)
    stage.line(agent, "joined")
    with stage.peer() as peer:
        moves(peer)


# ---------------------------------------------------------------- SIGTERM of each


def test_sigterm_ends_the_simulator_cleanly_with_agents_on_it(stage: Stage) -> None:
    server = stage.server(*REALTIME)
    stage.agent("chair1", "drive", *AHEAD)
    stage.signal(server, signal.SIGTERM)
    assert stage.exit(server, timeout=5.0) == 0
    assert "Traceback" not in stage.log(server)


def test_sigterm_ends_an_agent_which_leaves_in_words(stage: Stage) -> None:
    stage.server(*REALTIME)
    agent = stage.agent("chair1", "drive", *AHEAD)
    with stage.peer() as peer:
        moves(peer)
        stage.signal(agent, signal.SIGTERM)
        assert stage.exit(agent, timeout=5.0) == 0
        stage.line(agent, "left")
        peer.event("left", "chair1")
        assert "chair1" not in peer.entities()


def test_sigterm_ends_an_agent_that_waits_for_its_simulator(stage: Stage) -> None:
    agent = stage.agent("chair1", "drive", joined=False)
    stage.wait(lambda: "waiting" in stage.log(agent) or None, "the agent that waits")
    stage.signal(agent, signal.SIGTERM)
    stage.exit(agent, timeout=5.0)


# ---------------------------------------------------------------- iw-run

_SCENE = """<Scene Format="iw.v1" Name="long" Map="room" Pace="realtime">
  <Cast Name="chair1" Robot="rear-wheel" Mind="drive" Place="start1"/>
  <Cast Name="chair2" Robot="mid-wheel" Mind="{mind}" Place="start2"/>
  <End><Timeout Seconds="300.0"/></End>
</Scene>"""


def _iw_run(stage: Stage, mind: str = "drive") -> subprocess.Popen[str]:
    scene = stage.folder / "long.xml"
    scene.write_text(_SCENE.format(mind=mind))
    return subprocess.Popen(
        [sys.executable, "-m", "intellwheels_experiments", str(scene), "--json", str(stage.folder / "result.json"),
         "--logs", str(stage.folder / "logs"), "--world", stage.world, "--listen", stage.endpoint],
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    )  # fmt: skip


def _running(stage: Stage, process: subprocess.Popen[str]) -> list[int]:
    """Wait until the run goes; return the processes it started."""
    assert process.stdout is not None
    for line in process.stdout:
        if line.startswith("started"):
            break
    log = stage.folder / "logs" / "server.log"
    stage.wait(lambda: True if "running tick=0" in log.read_text() else None, "running")
    return children_of(process.pid)


def test_kill_of_iw_run_leaves_no_children(stage: Stage) -> None:
    # One of the cast is stuck in its own code, and cannot notice that its parent is gone by itself.
    with _iw_run(stage, write(stage.folder, "stuck", STUCK)) as process:
        children = _running(stage, process)
        assert len(children) == 3
        process.kill()
        process.wait(DEADLINE)
        assert [child for child in children if not is_gone(child, DEADLINE)] == []


@pytest.mark.parametrize("end", [signal.SIGTERM, signal.SIGINT], ids=["sigterm", "ctrl-c"])
def test_interrupted_iw_run_ends_all_and_says_what_happened(stage: Stage, end: signal.Signals) -> None:
    with _iw_run(stage) as process:
        children = _running(stage, process)
        process.send_signal(end)
        text, _ = process.communicate(timeout=DEADLINE)
        assert process.returncode == 1, text
        assert [child for child in children if not is_gone(child)] == []
    assert "finish=interrupted" in text
    result = json.loads((stage.folder / "result.json").read_text())
    assert result["finish"] == "interrupted"
    assert [row["seen"] for row in result["agents"]] == [True, True]


DIES = """class Mind:
    def __init__(self, context):
        raise RuntimeError("no such wheel")

    def decide(self, measures):
        return None
"""


def test_iw_run_names_the_child_that_died(stage: Stage) -> None:
    mind = Path(write(stage.folder, "dies", DIES))
    with _iw_run(stage, str(mind)) as process:
        text, _ = process.communicate(timeout=DEADLINE)
    assert process.returncode == 1
    assert "agent-chair2: exit 1" in text
    assert "no such wheel" in text


def test_iw_run_of_no_scene_is_wrong_usage(stage: Stage) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "intellwheels_experiments", "nowhere"], capture_output=True, text=True, timeout=DEADLINE,
        check=False,
    )  # fmt: skip
    assert done.returncode == 2
    assert "figure6" in done.stderr


# ---------------------------------------------------------------- a mind's mistakes

MIND = """class Mind:
    def __init__(self, context):
        pass

    def decide(self, measures):
"""


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ("pass\n", "dies.py:5: decide: expected Actions, got None; is a `return` missing?"),
        ("return 5\n", "dies.py:5: decide: expected Actions, got 5 (int)"),
        ("return 1 / 0\n", "dies.py:6: decide: ZeroDivisionError: division by zero"),
    ],
)
def test_mistake_of_a_mind_is_named_at_once_and_in_one_line(stage: Stage, body: str, words: str) -> None:
    stage.server(*REALTIME)
    mind = stage.folder / "dies.py"
    mind.write_text(f"{MIND}        {body}")
    child = stage.agent("chair1", str(mind), joined=False)
    assert stage.exit(child) == 1
    assert words in stage.log(child)
    assert "Traceback" not in stage.log(child)


def test_endless_loop_of_a_mind_is_named_with_its_line(stage: Stage) -> None:
    stage.server(*REALTIME)
    mind = stage.folder / "loops.py"
    mind.write_text(f"{MIND}        while True:\n            pass\n")
    child = stage.agent("chair1", str(mind), joined=False)
    stage.wait(lambda: True if "slow decide=3s at=" in stage.log(child) else None, "the report of the loop", 5.0 * 3.0)
    assert "loops.py:" in stage.log(child)
    stage.signal(child, signal.SIGKILL)
