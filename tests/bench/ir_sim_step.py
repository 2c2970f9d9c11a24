"""A step of ir-sim (PyPI), in a Python of its own that has it: prints the seconds of the quickest round.

PYTHON tests/bench/ir_sim_step.py WORLD.yaml STEPS ROUNDS
"""

from __future__ import annotations

import os
import sys
import time

os.environ["MPLBACKEND"] = "Agg"

import irsim
import numpy as np


def main(file: str, steps: int, rounds: int) -> None:
    """Make steps of one robot that drives in a circle."""
    env = irsim.make(file, display=False, log_level="ERROR")
    found = []
    for _ in range(rounds):
        start = time.perf_counter()
        for _ in range(steps):
            env.step(np.array([[0.3], [0.3]]))
        found.append((time.perf_counter() - start) / steps)
    assert len(env.get_lidar_scan()["ranges"]) == 8
    print(min(found))


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))
