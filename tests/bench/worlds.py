"""What a step of many small worlds at once costs, each with one noisy chair with eight cones and odometry.

If the variable `IR_SIM` names a Python that has ir-sim (PyPI), a row has its step beside it: one robot of the same size
between the same walls, with a lidar of eight beams. It has no noise, no wedges and no contact that slides.
"""

from __future__ import annotations

import os
import subprocess
import tempfile
from itertools import count
from pathlib import Path

import numpy as np

from intellwheels_maps import floor
from intellwheels_schemas.file_records import Inputs, Join
from intellwheels_schemas.messages import Actions, Odometry, Robot
from intellwheels_server.world import Setup, State, advance, apply, begin
from intellwheels_server.world.many_worlds import Worlds, advance_many, stack
from tests.bench.rows import Row
from tests.bench.tick import SENSORS, best

GOAL = "<= 2.5"
SEEDS = 20
"""Worlds that differ in seed and place. More worlds repeat them, with commands of their own."""
IR_SIM = """
world: {width: 13, height: 8, step_time: 0.05, sample_time: 0.05, collision_mode: stop}
robot:
  - kinematics: {name: diff}
    shape: {name: rectangle, length: 1.2, width: 0.7}
    state: [4, 4, 0]
    goal: [100, 100, 0]
    vel_max: [1.0, 2.0]
    sensors: [{name: lidar2d, range_min: 0, range_max: 4, angle_range: 5.5, number: 8}]
obstacle:
  - {shape: {name: linestring, vertices: [[0, 0], [13, 0], [13, 8], [0, 8], [0, 0]]}, state: [0, 0, 0]}
  - {shape: {name: linestring, vertices: [[9, 0], [9, 3.45]]}, state: [0, 0, 0]}
  - {shape: {name: linestring, vertices: [[9, 4.55], [9, 8]]}, state: [0, 0, 0]}
"""


def one_world(seed: int) -> State:
    """Return a world of its own seed and place."""
    ground = floor("room")
    assert ground.grid is not None
    places = [spot.name for spot in ground.grid.position if "wheelchair" in spot.kinds]
    chair = Robot(
        kind="wheelchair", length=1.2, width=0.7, center=0.4, top=1.3, top_speed=1.0, track=0.57, motor_noise=0.05,
        acceleration_curve=0.5, place=places[seed % len(places)], proximity=SENSORS, odometry=(Odometry(id="o"),),
    )  # fmt: skip
    state, outputs = apply(begin(Setup(floor=ground, seed=str(seed)), "0" * 16), [Join(agent="chair", robot=chair)])
    assert outputs.outcomes[0].code == "ok"
    return state


def bench(sizes: tuple[int, ...] = (1, 100, 10_000), *, rounds: int = 40) -> list[Row]:
    """Return the rows, µs a world and step."""
    states = [one_world(seed) for seed in range(SEEDS)]
    inputs = Inputs(actions={"chair": Actions(left_motor=0.3, right_motor=0.4)})
    held = [states[0]]

    def alone() -> None:
        held[0], _ = advance(held[0], inputs)

    rows = [Row("worlds", "1 world, one chair, by `advance`", "step", best(alone, 20, rounds) * 1e6, "µs/world")]
    for size in sizes:
        rows += [_together(states, size, threads, rounds) for threads in (1, 2)[: min(size, 2)]]
    worlds = stack([states[k % SEEDS] for k in range(100)])
    rows.append(Row("worlds", "100 worlds, one chair", "memory of the arrays", _bytes(worlds) / 1e5, "kB/world"))
    return rows + _of_ir_sim(rounds)


def _together(states: list[State], size: int, threads: int, rounds: int) -> Row:
    worlds = [stack([states[k % SEEDS] for k in range(size)])]
    draw = np.random.default_rng(1)
    commands = [draw.uniform(-0.2, 1.0, (size, 1, 2)) for _ in range(20)]
    at = count()

    def move() -> None:
        worlds[0], _ = advance_many(worlds[0], commands=commands[next(at) % 20], threads=threads)

    move()
    spent = best(move, max(1, 200 // size), rounds) * 1e6 / size
    case = f"{size} worlds, one chair, {threads} thread{'s' if threads > 1 else ''}"
    return Row("worlds", case, "step", spent, "µs/world", GOAL if (size, threads) == (10_000, 1) else "")


def _bytes(worlds: Worlds) -> float:
    of_sensors = [array for kind in worlds.sensors.stacks for array in getattr(kind, "arrays", ())]
    blocks = [worlds.numbers, worlds.flags, worlds.samples, *worlds.fixed, worlds.sensors.spans, *of_sensors]
    return float(sum(block.nbytes for block in blocks))


def _of_ir_sim(rounds: int) -> list[Row]:
    python = os.environ.get("IR_SIM")
    if not python:
        return []
    with tempfile.NamedTemporaryFile("w", suffix=".yaml") as file:
        file.write(IR_SIM)
        file.flush()
        program = [python, str(Path(__file__).with_name("ir_sim_step.py")), file.name, "20", str(rounds)]
        done = subprocess.run(program, capture_output=True, text=True, timeout=120.0, check=True)
    spent = float(done.stdout.splitlines()[-1]) * 1e6
    return [Row("worlds", "ir-sim, one robot, a lidar of 8 beams", "step", spent, "µs/world")]
