"""Measure the speed: print a table of results and append them to a CSV file."""

from __future__ import annotations

import argparse
from pathlib import Path

from tests.bench import (
    beside,
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
from tests.bench.rows import Row, append, show

ABOUT = f"{__doc__} The default benchmarks take about 6 minutes; `bystanders` also counts late ticks with ten pages."
DEFAULT = (
    "tick", "network", "crews", "viewer", "loads", "imports", "inputs", "joins", "ros", "record", "ciber", "drivers",
    "learning", "worlds",
)  # fmt: skip
"""The benchmarks that run if none is named."""
KEPT = Path(__file__).parent / "results.csv"


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
        help="run short versions, to check that the benchmarks work; their figures mean nothing and are kept only with "
        "--csv",
    )
    parser.add_argument(
        "--csv", type=Path, metavar="FILE",
        help="the CSV file (default: tests/bench/results.csv of the checkout)",
    )  # fmt: skip
    parser.add_argument(
        "--beside",
        metavar="COMMIT",
        help="run each benchmark of this commit too, right after the checkout's, and print the ratios",
    )
    options = parser.parse_args()
    file = options.csv or (None if options.quick else KEPT)
    if options.beside:
        for one in options.benches or DEFAULT:
            rows = run([one], quick=options.quick)
            others = beside.rows_of(options.beside, one, quick=options.quick)
            show([*rows, *beside.ratios(rows, others)])
            if file is not None:
                append(rows, file)
                append(others, file, options.beside)
        return
    rows = run(options.benches or list(DEFAULT), quick=options.quick)
    show(rows)
    if file is not None:
        append(rows, file)


def run(wanted: list[str], *, quick: bool) -> list[Row]:
    """Return the rows of the named benchmarks."""
    rows: list[Row] = []
    if "tick" in wanted:
        rows += tick.bench((1, 10), quick=True) if quick else tick.bench()
    if "network" in wanted:
        rows += network.bench(seconds=2.0, lockstep_seconds=0.4, small=True) if quick else network.bench()
    if "crews" in wanted:
        rows += crews.bench(seconds=1.0, small=True) if quick else crews.bench()
    if "viewer" in wanted:
        rows += viewer.bench((2,), seconds=1.0, settle=1.0, frames=1) if quick else viewer.bench()
    if "loads" in wanted:
        rows += loads.bench(corners=500, shapes=("circle",), settle=0.3) if quick else loads.bench()
    if "imports" in wanted:
        rows += imports.bench(side=200) if quick else imports.bench()
    if "inputs" in wanted:
        rows += inputs.bench(rounds=1) if quick else inputs.bench()
    if "joins" in wanted:
        rows += joins.bench((3,)) if quick else joins.bench()
    if "ros" in wanted:
        rows += ros.bench(rounds=5, seconds=1.0) if quick else ros.bench()
    if "record" in wanted:
        rows += record.bench(rounds=20) if quick else record.bench()
    if "ciber" in wanted:
        rows += ciber.bench(rounds=20, seconds=0.0) if quick else ciber.bench()
    if "drivers" in wanted:
        rows += drivers.bench(rounds=50, powers=4) if quick else drivers.bench()
    if "learning" in wanted:
        rows += learning.bench(steps=8, rounds=2) if quick else learning.bench()
    if "lab" in wanted:
        few = ("rules", lab.FLOOD)
        rows += lab.bench((2,), few, sessions=2, ticks=10, rounds=1, settle=0.2) if quick else lab.bench()
    if "worlds" in wanted:
        rows += worlds.bench((1, 10), rounds=2) if quick else worlds.bench()
    if "bystanders" in wanted:
        rows += bystanders.bench(chairs=2, count=1, pages=2, seconds=0.3, settle=0.3) if quick else bystanders.bench()
    return rows


if __name__ == "__main__":
    main()
