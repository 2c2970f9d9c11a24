"""Learn to pass a door, with the evolution strategy CMA-ES of the library `cma` (pip install 'cma>=4,<5').

    python train.py --out policy.json
    python train.py --test policy.json --seeds 200

The first command learns; the second prints how often the policy succeeds with seeds that it was not trained with.
"""

from __future__ import annotations

import argparse
import json
import math
import time
from collections.abc import Sequence
from multiprocessing import get_context
from pathlib import Path

from door_mind import INPUTS, TICKS, WEIGHTS, policy

from intellwheels_experiments.batch.statistics import wilson
from intellwheels_gym import ChairEnv

SCENE = Path(__file__).parent / "door.xml"
REWARD = {"progress": 1.0, "reached": 10.0, "contact": 5.0, "time": 0.1}
FIRST_SEED = 10_000
"""Of training. `--test`, and `iw-run --seeds`, count from 1."""

_environments: list[ChairEnv] = []


def episode(weights: Sequence[float], seed: int) -> tuple[float, bool]:
    """Return the sum of the rewards of an episode, and whether the goal was reached without a contact."""
    if not _environments:
        _environments.append(ChairEnv(SCENE, reward=REWARD, ticks=TICKS))
    (env,) = _environments
    observation, info = env.reset(seed=seed)
    total, over = 0.0, False
    while not over:
        observation, reward, terminated, truncated, info = env.step(policy(weights, observation.tolist()))
        total, over = total + reward, terminated or truncated
    return total, info["is_success"]


def cost(task: tuple[Sequence[float], Sequence[int]]) -> float:
    """Return the negative mean of the rewards over seeds."""
    weights, seeds = task
    return -math.fsum(episode(weights, seed)[0] for seed in seeds) / len(seeds)


def learn(generations: int, population: int, episodes: int, jobs: int) -> list[float]:
    """Return the weights of the policy after so many generations."""
    import cma  # noqa: PLC0415 - `--test` needs no library

    start = [0.0] * WEIGHTS
    start[INPUTS - 1] = 0.3  # drive slowly at first
    options = {"popsize": population, "seed": 1, "verbose": -9}
    search = cma.CMAEvolutionStrategy(start, 0.3, options)
    began = time.monotonic()
    with get_context("spawn").Pool(jobs) as pool:
        for generation in range(generations):
            # New seeds for each generation, the same for all its candidates.
            seeds = range(FIRST_SEED + generation * episodes, FIRST_SEED + (generation + 1) * episodes)
            candidates = search.ask()
            costs = pool.map(cost, [(candidate.tolist(), seeds) for candidate in candidates], chunksize=1)
            search.tell(candidates, costs)
            print(f"generation {generation + 1}: best {-min(costs):.2f}, {time.monotonic() - began:.0f} s", flush=True)  # noqa: T201
    weights: list[float] = search.result.xfavorite.tolist()
    return weights


def main() -> None:
    """Learn, or test a policy."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--out", type=Path, default=Path("policy.json"), metavar="FILE", help="where to write the policy"
    )
    parser.add_argument("--generations", type=int, default=40, metavar="COUNT")
    parser.add_argument("--population", type=int, default=16, metavar="COUNT")
    parser.add_argument("--episodes", type=int, default=8, metavar="COUNT", help="episodes of each candidate")
    parser.add_argument("--jobs", type=int, default=2, metavar="COUNT", help="processes")
    parser.add_argument("--test", type=Path, metavar="FILE", help="test this policy instead")
    parser.add_argument("--seeds", type=int, default=200, metavar="COUNT", help="seeds of a test (default: 200)")
    options = parser.parse_args()
    if options.test is not None:
        weights = json.loads(options.test.read_text())["weights"]
        good = [episode(weights, seed)[1] for seed in range(1, options.seeds + 1)].count(True)
        low, high = wilson(good, options.seeds)
        print(f"{good} of {options.seeds} succeeded, 95 % interval {low:.3f} to {high:.3f}")  # noqa: T201
        return
    weights = learn(options.generations, options.population, options.episodes, options.jobs)
    options.out.write_text(json.dumps({"weights": weights}) + "\n")


if __name__ == "__main__":
    main()
