"""The options of `iw-run` for a batch of runs, and for a branch of a recorded run."""

from __future__ import annotations

import argparse
import re
from pathlib import Path
from typing import Final

from intellwheels_experiments.batch.batch_parts import WHOLE, part
from intellwheels_schemas import messages
from intellwheels_schemas.command_parser import readable_file, whole

LINES_HELP: Final = """
a batch's lines, where standard output is no terminal:
  progress  how many runs are done, and how long the rest will take, as hours:minutes:seconds
  row       succeeded, and low and high: the 95 % interval of the success rate (Wilson); died: runs that ended early;
            missing: runs that were not done
  compare   second is `-` if one row is judged alone; difference of the success rates, first minus second; found is
            `as-expected`, `otherwise` (the expectation does not hold), `undecided` (too few runs to tell), `not-asked`
            (there is no expectation) or `incomplete` (runs are missing)
"""
"""What the lines mean, for the help of the command."""
MOST_RUNS: Final = 100_000
"""Largest number of --seeds and --jobs."""
_ADDRESS: Final = re.compile(r"(?:(?:tcp|tls)://)?(?:\[[0-9a-fA-F:]+\]|[\w.-]+):([1-9]\d{0,4})")


def scheduler_address(text: str) -> str:
    """Return the address of a Dask scheduler, such as `tcp://head:8786`, from its text. For argparse.

    Raises:
        argparse.ArgumentTypeError: The text is no address with a port.
    """
    found = _ADDRESS.fullmatch(text)
    if found is None or int(found[1]) > 65535:
        raise argparse.ArgumentTypeError(
            f"expected HOST:PORT, such as head:8786, or tcp:// or tls:// before it, got {text!r}"
        )
    return text if "://" in text else f"tcp://{text}"


def add_batch_options(parser: argparse.ArgumentParser) -> None:
    """Add the groups `batch` and `branch` to a parser."""
    batch = parser.add_argument_group(
        "batch",
        "run every row (combination of settings) of the scene's experiment with every seed; needs the extra "
        "`experiments`",
    )
    batch.add_argument(
        "--seeds", type=whole(1, MOST_RUNS), metavar="N",
        help="run with the seeds 1 to N, in [1, 100000], and write a report",
    )  # fmt: skip
    batch.add_argument(
        "--jobs", type=whole(1, MOST_RUNS), metavar="N", default=1,
        help="number of runs at a time, in [1, 100000] (default: 1)",
    )  # fmt: skip
    batch.add_argument(
        "--row",
        metavar="ROW",
        action="append",
        help="run only this row; may be repeated (default: all rows; with --branch, the first one)",
    )
    batch.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="folder of the runs and the report; a batch does not repeat runs finished there (default: SCENE-runs, in "
        "the working directory)",
    )
    batch.add_argument(
        "--part", type=part, metavar="I/N", default=WHOLE,
        help="do only the I-th of N shares of the runs, and write no report: for job arrays and several machines",
    )  # fmt: skip
    batch.add_argument(
        "--merge", type=Path, metavar="DIR", action="append", default=[],
        help="do no runs, but copy those of another part's folder into --out, and write the report; may be repeated",
    )  # fmt: skip
    batch.add_argument(
        "--cluster", type=scheduler_address, metavar="ADDRESS",
        help="do the runs on the workers of the Dask scheduler at this address, such as tcp://host:8786, as many at "
        "a time as the workers have threads; anyone who can reach a scheduler can run programs on its workers, so keep "
        "it in a network that you trust",
    )  # fmt: skip
    branch = parser.add_argument_group(
        "branch",
        "what if: repeat a recorded run up to a tick, continue with changes, and write a report of both runs to --out",
    )
    branch.add_argument(
        "--branch",
        type=readable_file,
        metavar="LOG",
        help="input log of a run of this scene; with --row, of a run of that row",
    )
    branch.add_argument(
        "--at",
        type=whole(0, messages.MAX_INTEGER, "a tick"),
        metavar="TICK",
        default=0,
        help="tick up to which the log is followed (default: 0)",
    )
