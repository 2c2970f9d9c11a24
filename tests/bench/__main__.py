"""Measure the speed: print a table of results and append them to a CSV file."""

from __future__ import annotations

import argparse
from pathlib import Path

from tests.bench import (
    bystanders,
    ciber,
    crews,
    drivers,
    imports,
    inputs,
    joins,
    lab,
    learning,
    loads,
    network,
    record,
    ros,
    tick,
    viewer,
    worlds,
)  # fmt: skip
from tests.bench.rows import append, show

ABOUT = f"{__doc__} The default benchmarks take about 6 minutes; `bystanders` also counts late ticks with ten pages."
DEFAULT = (
    "tick", "network", "crews", "viewer", "loads", "imports", "inputs", "joins", "ros", "record", "ciber", "drivers",
    "learning", "worlds",
)  # fmt: skip
"""The benchmarks that run if none is named."""


def main() -> None:
    """Run the named benchmarks, or the default ones; print the table and append the rows."""
    parser = argparse.ArgumentParser(prog="python -m tests.bench", description=ABOUT)
    parser.add_argument(
        "benches",
        nargs="*",
        metavar="BENCH",
        help="tick: the cost of a tick, part by part; network: whole processes; crews: those of many chairs each; "
        "viewer: a page; loads: loading maps; imports: floors of other programs; inputs: from an input to the motors; "
        "joins: many at once; ros, record and ciber: gateways; drivers: those of real chairs; learning: steps of "
        "learning environments; worlds: many small worlds at once; lab: chairs through routers with and without "
        "rules, 15 minutes; bystanders: late ticks beside a frozen viewer, 25 minutes (default: all but lab and "
        "bystanders)",
    )
    parser.add_argument(
        "--quick",
        action="store_true",
        help="run short versions, to check that the benchmarks work; their figures mean nothing",
    )
    parser.add_argument(
        "--csv", type=Path, default=Path(__file__).parent / "results.csv", metavar="FILE",
        help="the CSV file (default: tests/bench/results.csv of the checkout)",
    )  # fmt: skip
    options = parser.parse_args()
    wanted = options.benches or list(DEFAULT)
    rows = []
    if "tick" in wanted:
        rows += tick.bench((1, 10), quick=True) if options.quick else tick.bench()
    if "network" in wanted:
        rows += network.bench(seconds=2.0, lockstep_seconds=1.0, small=True) if options.quick else network.bench()
    if "crews" in wanted:
        rows += crews.bench(seconds=1.0, small=True) if options.quick else crews.bench()
    if "viewer" in wanted:
        rows += viewer.bench((2,), seconds=1.0, settle=2.0, frames=1) if options.quick else viewer.bench()
    if "loads" in wanted:
        rows += loads.bench(corners=500, shapes=("circle",), settle=0.3) if options.quick else loads.bench()
    if "imports" in wanted:
        rows += imports.bench(side=200) if options.quick else imports.bench()
    if "inputs" in wanted:
        rows += inputs.bench(rounds=3) if options.quick else inputs.bench()
    if "joins" in wanted:
        rows += joins.bench((3,)) if options.quick else joins.bench()
    if "ros" in wanted:
        rows += ros.bench(rounds=5, seconds=1.0) if options.quick else ros.bench()
    if "record" in wanted:
        rows += record.bench(rounds=20) if options.quick else record.bench()
    if "ciber" in wanted:
        rows += ciber.bench(rounds=20, seconds=0.0) if options.quick else ciber.bench()
    if "drivers" in wanted:
        rows += drivers.bench(rounds=50, powers=4) if options.quick else drivers.bench()
    if "learning" in wanted:
        rows += learning.bench(steps=8, rounds=2) if options.quick else learning.bench()
    if "lab" in wanted:
        short = {"sessions": 2, "ticks": 10, "rounds": 1}
        rows += lab.bench((2,), ("rules", lab.FLOOD), **short, settle=0.2) if options.quick else lab.bench()
    if "worlds" in wanted:
        rows += worlds.bench((1, 10), rounds=2) if options.quick else worlds.bench()
    if "bystanders" in wanted:
        quick = {"chairs": 2, "count": 1, "pages": 2}
        rows += bystanders.bench(**quick, seconds=0.3, settle=0.3) if options.quick else bystanders.bench()
    show(rows)
    append(rows, options.csv)


if __name__ == "__main__":
    main()
