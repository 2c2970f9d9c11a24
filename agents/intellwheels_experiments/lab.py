"""`python -m intellwheels_experiments.lab`: two real and two virtual chairs in one floor, supervised together.

Eleven processes, each started as anybody would start it. World `lab` is the building with the real chairs in it: their
wheels are not quite what their data sheets say, and where they truly are stays in its log. In world `main` they meet
two virtual chairs and a virtual table. `real1` is reported by its encoders alone, `real2` is corrected by a position
once a second; both are driven by the same mind as the virtual ones, by virtual sensors and the chair's own sonars.

Watch it with `iw-viewer`; play both logs afterwards (`iw-server --play`) to see truth beside report. To put a chair of
metal in: `iw-bridge serial --port ... --name real1` in place of its `iw-bridge world`.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from intellwheels_experiments.plan import link_words
from intellwheels_experiments.processes import SLICE, AwaitedError, Processes, free_port
from intellwheels_schemas.link import DEFAULT_ENDPOINT
from intellwheels_schemas.process import add_process_options, stop_on_signals

READY_LIMIT: Final = 180.0
"""Seconds for a simulator to be ready: a first start compiles its kernels."""
GRACE: Final = 3.0
MIND: Final = ("avoid", "--option", "speed=0.4")

REAL: Final = {
    # Name: place, then what is wrong with it and how it is reported.
    "real1": ("start1", "--chair-option", "WheelRatio=1.002"),
    "real2": ("start3", "--chair-option", "WheelRatio=0.998", "--pose", "corrected"),
}
VIRTUAL: Final = {"virtual1": "start2", "virtual2": "spare1"}


def start(processes: Processes, endpoint: str, logs: Path, floor: str = "room") -> None:
    """Start all of it and wait until everybody has joined.

    Args:
        processes: Those of the run.
        endpoint: Where world `main` listens; `lab` has a port of its own.
        logs: The folder of both worlds' input logs.
        floor: Of both worlds.

    Raises:
        AwaitedError: Somebody did not.
    """
    there = f"tcp/127.0.0.1:{free_port()}"
    here = link_words("main", connect=[endpoint])
    for world, listens, more in (("lab", there, ["--hide-truth"]), ("main", endpoint, [])):
        words = ["--map", floor, "--pace", "realtime", "--log", str(logs / f"{world}.jsonl"), *more]
        processes.start(world, "intellwheels_server", *link_words(world, [listens]), *words)
    for world in ("lab", "main"):
        processes.line(world, "ready", READY_LIMIT)
    agent = "intellwheels_agents"
    processes.start("table", agent, "table", "--name", "table", "--place", "table", *here)
    for name, place in VIRTUAL.items():
        processes.start(name, agent, *MIND, "--name", name, "--robot", "mid-wheel", "--place", place, *here)
    for name, (place, *words) in REAL.items():
        laboratory = ["--lab-connect", there, "--place", place, "--sensors", "both"]
        processes.start(name, f"{agent}.bridge", "world", "--name", name, *laboratory, *words, *here)
        processes.line(name, "joined")
        processes.start(f"{name}-mind", agent, *MIND, "--name", name, "--role", "mind", *here)
    for child in ("table", *VIRTUAL, *(f"{name}-mind" for name in REAL)):
        processes.line(child, "joined")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code: 0 done, 1 somebody ended or did not come."""
    parser = argparse.ArgumentParser(prog="lab", description=(__doc__ or "").partition("\n\n")[2].partition("\n\n")[0])
    parser.add_argument("--listen", default=DEFAULT_ENDPOINT, metavar="ENDPOINT", help="of world main")
    parser.add_argument("--seconds", type=float, default=float("inf"), metavar="S", help="end after so long")
    parser.add_argument("--logs", type=Path, default=Path("lab-logs"), metavar="DIR", help="(default: lab-logs)")
    add_process_options(parser)
    given = parser.parse_args(arguments)
    stop = stop_on_signals(given.lifeline)
    given.logs.mkdir(parents=True, exist_ok=True)
    processes = Processes(given.logs)
    try:
        start(processes, given.listen, given.logs)
        _say(f"ready at={given.listen} world=main logs={given.logs}")
        until = time.monotonic() + given.seconds
        while not stop.is_set() and time.monotonic() < until:
            processes.hear(SLICE)
            _check(processes)
    except AwaitedError as error:
        sys.stderr.write(f"lab: {error}\n")
        return 1
    finally:
        processes.close(GRACE)
    _say("ended")
    return 0


def _check(processes: Processes) -> None:
    for child in ("lab", "main", *REAL, *VIRTUAL):
        if processes.ended(child):
            raise AwaitedError(f"{child} ended\n{processes.report()}")


def _say(line: str) -> None:
    print(line, flush=True)  # noqa: T201 - what a script waits for


if __name__ == "__main__":
    sys.exit(main())
