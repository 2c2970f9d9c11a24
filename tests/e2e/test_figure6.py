"""The paper's main scene as processes: what must hold holds, and a run is a function of its seed."""

from __future__ import annotations

import json
import math
import threading
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from intellwheels_agents import minds
from intellwheels_agents.crew_harness import CrewMember
from intellwheels_agents.crew_peer import run_crew
from intellwheels_agents.options import Options
from intellwheels_agents.robot_document import equipped, joining, split_options
from intellwheels_maps import robot, scene
from intellwheels_schemas.codec import Encoding
from intellwheels_schemas.link import Link
from intellwheels_schemas.messages import Entity
from intellwheels_schemas.names import new_hex
from intellwheels_server.log.input_log import read_header, read_lines
from intellwheels_server.world import advance, apply, begin, digest, entities, measures
from tests.e2e.stage import Stage, run


def play(folder: Path, *words: str, **environment: str) -> dict[str, Any]:
    """Run figure6 and return its result."""
    file = folder / "result.json"
    done = run("intellwheels_experiments", "figure6", "--json", str(file), "--logs", str(folder / "logs"), *words,
               timeout=180.0, **environment)  # fmt: skip
    logs = "".join(f"--- {log}\n{log.read_text()[-2000:]}" for log in (folder / "logs").glob("*.log"))
    assert done.returncode == 0, done.stdout + done.stderr + logs
    result = json.loads(file.read_text())
    assert isinstance(result, dict)
    return result


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("figure6")


@pytest.fixture(scope="module")
def first(folder: Path) -> dict[str, Any]:
    return play(folder, "--log", str(folder / "run.log"))


def test_chairs_reach_their_goals_without_a_contact(first: dict[str, Any]) -> None:
    assert first["held"] is True
    assert first["contacts"] == 0
    rows = {row["name"]: row for row in first["agents"]}
    assert [rows[name]["reached"] for name in ("chair1", "chair2", "chair3")] == [True, True, True]
    assert [row["contacts"] for row in first["agents"]] == [0, 0, 0, 0, 0]


@dataclass(frozen=True)
class Moment:
    """A tick of the run, made again from its log."""

    hash: str
    bodies: dict[str, Entity]
    door_sees: dict[str, float]


@pytest.fixture(scope="module")
def moments(folder: Path, first: dict[str, Any]) -> list[Moment]:
    path = folder / "run.log"
    found = []
    with path.open("rb") as file:
        header = read_header(file, str(path))
        state = begin(header.world_setup(), header.run)
        for line in read_lines(file, str(path)):
            assert line is not None
            if not line.stepped:
                state, _ = apply(state, line.inputs.changes)
                continue
            state, _ = advance(state, line.inputs)
            sensors = measures(state, "door").sensors
            assert sensors is not None
            sees = {reading.id: math.inf if reading.value is None else reading.value for reading in sensors.proximity}
            found.append(Moment(digest(state), {entity.name: entity for entity in entities(state)}, sees))
    return found


@pytest.mark.process
@pytest.mark.parametrize("encoding", list(Encoding))
def test_cast_in_one_crew_ends_with_the_same_hash(first: dict[str, Any], tmp_path: Path, encoding: Encoding) -> None:
    instance, members, stop = new_hex(), [], threading.Event()
    for one in scene("figure6").cast:
        of_robot, of_mind = split_options({each.name: each.value for each in one.option})
        source = minds.find(one.mind or "")
        body = source.equip(equipped(robot(one.robot or ""), of_robot), Options(of_mind))
        document = joining(body, agent=one.name, role="both", instance=instance, place=one.place, barrier=None)
        members.append(CrewMember(document, source.make, of_mind))
    with Stage(tmp_path, "crew") as stage:
        stage.server("--scene", "figure6", "--seed", str(first["seed"]), "--quit-at-end", ready=False)
        stage.line("server", "ready", 120.0)
        where = Link(world="crew", connect=(stage.endpoint,))
        host = partial(
            run_crew, "cast", instance, members, where=where, encoding=encoding, retry_for=60.0, stop=stop
        )  # fmt: skip
        thread = threading.Thread(target=host, daemon=True)
        thread.start()
        try:
            ended = stage.line("server", "ended", 120.0)
        finally:
            stop.set()
            thread.join(30.0)
    assert (ended["tick"], ended["hash"]) == (str(first["ticks"]), first["hash"])


def test_hash_of_the_result_is_that_of_the_last_step_run_again(first: dict[str, Any], moments: list[Moment]) -> None:
    assert (len(moments), moments[-1].hash) == (first["ticks"], first["hash"])


def test_table_was_never_moved(moments: list[Moment]) -> None:
    assert len({(m.bodies["table"].x, m.bodies["table"].y, m.bodies["table"].heading) for m in moments}) == 1


def test_door_opened_and_closed_by_what_its_sensors_saw(moments: list[Moment]) -> None:
    closed = moments[0].bodies["door"].heading
    turns = [abs(math.degrees(math.remainder(m.bodies["door"].heading - closed, math.tau))) for m in moments]
    opens = next(tick for tick, turn in enumerate(turns) if turn > 1.0)
    assert max(turns) > 85.0
    assert turns[-1] < 3.0
    # Before the leaf moved somebody was in sight of its frame, and nobody was before that, nor when it closed.
    background = moments[0].door_sees
    in_sight = [any(m.door_sees[name] < background[name] - 0.05 for name in background) for m in moments]
    assert True in in_sight[opens - 20 : opens]
    assert True not in in_sight[: opens - 20]
    closes = max(tick for tick, turn in enumerate(turns) if turn > 85.0)
    assert closes - max(tick for tick in range(closes) if in_sight[tick]) >= 90  # 5 s of hold, less the lag
    chair = [m.bodies["chair1"].x for m in moments]
    assert chair[opens] < 9.0 < chair[closes]


def test_log_of_the_run_is_run_again_to_the_same_hashes(folder: Path, first: dict[str, Any]) -> None:
    done = run("intellwheels_server", "--resimulate", str(folder / "run.log"))
    assert done.returncode == 0, done.stdout + done.stderr


def test_other_seed_gives_another_hash(tmp_path: Path, first: dict[str, Any]) -> None:
    assert play(tmp_path, "--seed", "2")["hash"] != first["hash"]


def test_cast_that_speaks_xml_gives_the_same_hash(tmp_path: Path, first: dict[str, Any]) -> None:
    assert play(tmp_path, "--encoding", "xml")["hash"] == first["hash"]


def test_same_seed_gives_the_same_hash_on_a_generic_processor_too(tmp_path: Path, first: dict[str, Any]) -> None:
    again = play(tmp_path, NUMBA_CPU_NAME="generic")
    assert (again["hash"], again["ticks"]) == (first["hash"], first["ticks"])


@pytest.mark.soak
def test_same_seed_gives_the_same_hash_on_this_processor(tmp_path: Path, first: dict[str, Any]) -> None:
    again = play(tmp_path)
    assert (again["hash"], again["ticks"]) == (first["hash"], first["ticks"])
