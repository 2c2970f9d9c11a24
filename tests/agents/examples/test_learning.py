"""The policy of the learning example: the same drive as in training, the kept result, and a run on the network."""

from __future__ import annotations

import csv
import importlib.util
import json
import subprocess
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from intellwheels_agents.mind import Context
from intellwheels_agents.options import Options
from intellwheels_experiments.batch.statistics import wilson
from intellwheels_gym.scene_world import SceneWorld
from intellwheels_gym.task import load_task
from intellwheels_schemas import defaults
from intellwheels_schemas.messages import Parameters
from tests.commands import MODULES

FOLDER = Path(__file__).parents[3] / "agents" / "examples" / "learning"
WEIGHTS = json.loads((FOLDER / "policy.json").read_text())["weights"]
PARAMETERS = Parameters(
    world="main", period=defaults.PERIOD, pace="lockstep", say_limit=defaults.SAY_LIMIT, say_range=defaults.SAY_RANGE,
    command_timeout=defaults.COMMAND_TIMEOUT, grace=defaults.GRACE,
)  # fmt: skip


@pytest.fixture
def example(monkeypatch: pytest.MonkeyPatch) -> dict[str, ModuleType]:
    """The files of the example, as its folder runs them."""
    monkeypatch.syspath_prepend(str(FOLDER))
    found = {}
    for name in ("door_mind", "train"):
        spec = importlib.util.spec_from_file_location(name, FOLDER / f"{name}.py")
        assert spec is not None
        assert spec.loader is not None
        found[name] = importlib.util.module_from_spec(spec)
        monkeypatch.setitem(sys.modules, name, found[name])
        spec.loader.exec_module(found[name])
    return found


def test_policy_succeeds_with_seeds_that_it_was_not_trained_with(example: dict[str, ModuleType]) -> None:
    assert all(example["train"].episode(WEIGHTS, seed)[1] for seed in range(1, 6))


def test_mind_drives_as_in_training_to_the_bit(example: dict[str, ModuleType]) -> None:
    train, mind_file = example["train"], example["door_mind"]
    env = train.ChairEnv(FOLDER / "door.xml", ticks=train.TICKS)
    observation, _ = env.reset(seed=3)
    world = SceneWorld(load_task(FOLDER / "door.xml"))
    world.reset("3")
    body = world.learners["chair"]
    mind: Any = mind_file.Mind(
        Context(
            agent="chair", robot=body.robot, position=body.position, parameters=PARAMETERS,
            options=Options({"to": "goal"}), fetch_map=lambda: world.state.setup.floor,
        )
    )  # fmt: skip
    over = False
    while not over:
        observation, _, terminated, truncated, info = env.step(train.policy(WEIGHTS, observation.tolist()))
        over = terminated or truncated
    assert info["is_success"]
    for _ in range(info["tick"]):
        answer = mind.decide(world.measures("chair"))
        world.advance({"chair": (answer.left_motor, answer.right_motor)})
    assert world.state.numbers.tolist() == env.unwrapped._world.state.numbers.tolist()


def test_kept_result_has_the_intervals_of_its_counts_and_the_network_succeeds_as_often() -> None:
    rows = {row["where"]: row for row in csv.DictReader((FOLDER / "result.csv").read_text().splitlines())}
    assert set(rows) == {"environment", "network"}
    limits = {}
    for where, row in rows.items():
        found = wilson(int(row["succeeded"]), int(row["seeds"]))
        limits[where] = float(row["low"]), float(row["high"])
        assert limits[where] == pytest.approx(tuple(found), abs=5e-4)
    rate = int(rows["network"]["succeeded"]) / int(rows["network"]["seeds"])
    low, high = limits["environment"]
    assert low <= rate <= high


@pytest.mark.process
def test_training_runs_and_returns_weights(example: dict[str, ModuleType]) -> None:
    pytest.importorskip("cma")
    weights = example["train"].learn(generations=1, population=4, episodes=1, jobs=1)
    assert len(weights) == example["train"].WEIGHTS


@pytest.mark.process
def test_policy_succeeds_on_the_network(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", MODULES["iw-run"], str(FOLDER / "door.xml"), "--seed", "3"],
        cwd=tmp_path, capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    assert "held scene=learned-door" in done.stdout
