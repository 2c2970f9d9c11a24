"""The command line of `iw-record`: its options and what must hold between them."""

from __future__ import annotations

import argparse
import math
import re
import socket
from pathlib import Path
from typing import Final

from intellwheels_agents.options import OptionError
from intellwheels_schemas import defaults
from intellwheels_schemas.command_parser import CommandParser, add_retry_option, number, port, readable_file
from intellwheels_schemas.output_paths import add_overwrite_option, check_output_file, check_output_folder

EXAMPLES: Final = """\
examples:
  record a world until Ctrl-C
      iw-record run.mcap
  show it to Foxglove: open connection ws://127.0.0.1:8765, and import the layout that --layout printed
      iw-record --live
      iw-record --layout > layout.json
  make a recording of an input log
      iw-record run.mcap --from run.jsonl
  write a bag for `ros2 bag play`, of a world or of an input log
      iw-record --ros2 run
      iw-record --ros2 run --from run.jsonl

A recording has the topics /tf, /scene, /wedges, /grid, /log, /AGENT/pose, /AGENT/truth, /AGENT/goal,
/AGENT/scan/SENSOR and /AGENT/odometry/SENSOR for Foxglove, and every message of the world as JSON under /iw.
Its time is simulated time, plus the time of day at which the recorder first saw the run; with --from it starts at 0.
A bag has the topics of iw-ros for every chair, with /clock and /map, and the time stamps of a recording. Play it with
`ros2 bag play run`; its readers need the parameter use_sim_time. It is complete only when iw-record has ended.
Ticks whose state did not arrive are counted, and reported in /log and in the last line.

In the live view, publish JSON to /user/AGENT, such as {"Forward": 0.5, "Turn": 0.1}, or {"linear": {"x": 0.5},
"angular": {"z": 0.2}} in m/s and rad/s, to drive a chair. Anybody who can connect to the live view can do so.

Standard output has the lines `ready file=... live=...` and `recorded file=... messages=... ticks=... missed=...
refused=...`. `refused` counts the messages that were left out: invalid ones, those of a run that had ended, and those
for which a recording had no room for another topic.
Exit codes: 0 done, 1 refused or failed, 2 wrong usage. The command needs the extra `foxglove`.
"""
PORT: Final = 8765
"""Port of the live view, which Foxglove proposes."""
HOST: Final = "127.0.0.1"
STORAGES: Final = ("mcap", "sqlite3")
"""How a bag can be stored; the first is that of ROS 2 since Iron."""
ROTATE: Final = 1000.0
"""Size of a file, MB."""


def parser() -> argparse.ArgumentParser:
    """Return the parser of this command's own options."""
    result = CommandParser(
        prog="iw-record",
        description="Record a world to MCAP files or a bag of ROS 2, or show it live to Foxglove.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    result.add_argument("file", metavar="FILE.mcap", type=Path, nargs="?", help="the recording (default: none)")
    result.add_argument(
        "--from", dest="log", type=readable_file, metavar="LOG",
        help="record this input log, tick by tick, instead of a world on the network; needs the extra `server`",
    )  # fmt: skip
    result.add_argument(
        "--rotate", type=number("megabytes", 0.1, 1e6), metavar="MB",
        help="begin another file, named FILE-2.mcap and so on, when a file has reached this size in megabytes, in "
        f"[0.1, 1e6] (default: {ROTATE:g})",
    )  # fmt: skip
    add_overwrite_option(result)
    bag = result.add_argument_group("ROS 2")
    bag.add_argument(
        "--ros2", type=Path, metavar="BAG",
        help="write a bag, in addition to FILE.mcap if that is given; BAG is a folder that does not exist yet; needs "
        "the extra `ros`",
    )  # fmt: skip
    bag.add_argument("--storage", choices=STORAGES, help=f"format of the bag (default: {STORAGES[0]})")
    live = result.add_argument_group("live view")
    live.add_argument("--live", action="store_true", help="serve the live view of Foxglove")
    live.add_argument("--host", metavar="ADDRESS", help=f"address to serve it at (default: {HOST}, this machine only)")
    live.add_argument("--port", type=port, metavar="N", help=f"its port; 0 picks a free one (default: {PORT})")
    live.add_argument(
        "--hold", type=number("seconds", 0.1, 2.0), metavar="S",
        help="seconds for which a published input drives a chair, in [0.1, 2] (default: 0.5)",
    )  # fmt: skip
    live.add_argument("--take", action="store_true", help="drive chairs instead of their minds, while input arrives")
    result.add_argument("--layout", action="store_true", help="print the layout for Foxglove, and exit")
    add_retry_option(result)
    return result


def check_together(given: argparse.Namespace) -> None:
    """Check that options fit each other.

    Raises:
        OptionError: They do not; the text names one.
        WireError: The file cannot be written.
    """
    if given.file is None and given.ros2 is None and not given.live:
        raise OptionError("FILE.mcap: expected a file, --ros2 or --live, got none of them")
    if given.file is not None:
        # Those that --rotate would make too: a recording must not end in the middle, nor mix with an older one.
        for file in (given.file, *_parts(given.file)):
            check_output_file(file, "FILE.mcap", overwrite=given.overwrite)
    elif given.overwrite:
        raise OptionError("--overwrite: expected with a FILE.mcap, got none")
    if given.ros2 is not None:
        check_output_folder(given.ros2, "--ros2")
        if given.ros2.exists():
            raise OptionError(f"--ros2: expected a folder that does not exist, got {given.ros2}")
    elif given.storage is not None:
        raise OptionError("--storage: expected with --ros2, got none")
    if given.rotate is not None and given.file is None:
        raise OptionError("--rotate: expected with a FILE.mcap, got none")
    if given.log is not None:
        if given.live or (given.file is None and given.ros2 is None):
            raise OptionError("--from: expected with a FILE.mcap or --ros2 and without --live, got otherwise")
        if given.connect or given.listen or given.config or given.identity or given.world != defaults.WORLD:
            raise OptionError("--from: expected without a world and a connection, got both")
        if given.retry_for != math.inf:
            raise OptionError("--retry-for: expected without --from, got both")
    of_live = (("--host", given.host), ("--port", given.port), ("--hold", given.hold), ("--take", given.take or None))
    for option, value in of_live:
        if value is not None and not given.live:
            raise OptionError(f"{option}: expected with --live, got none")
    if given.host is not None and not _is_here(given.host):
        expected = "an address of this machine, such as 127.0.0.1 or 0.0.0.0"
        raise OptionError(f"--host: expected {expected}, got {given.host!r}")


def _parts(file: Path) -> list[Path]:
    """Return the files that have the name of a further file of a recording, such as `run-2.mcap`."""
    name = re.compile(rf"{re.escape(file.stem)}-[1-9][0-9]*{re.escape(file.suffix)}")
    return sorted(other for other in file.parent.glob("*") if name.fullmatch(other.name))


def _is_here(host: str) -> bool:
    """Return whether a server may be opened at a host: a socket can be bound there."""
    try:
        family, kind, _, _, address = socket.getaddrinfo(host or "?", 0, type=socket.SOCK_STREAM)[0]
        with socket.socket(family, kind) as probe:
            probe.bind(address)
    except (OSError, UnicodeError):
        return False
    return True
