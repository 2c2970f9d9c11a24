"""The command line of `iw-run`."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import get_args

from intellwheels_experiments.batch.batch_options import LINES_HELP as BATCH_LINES
from intellwheels_experiments.batch.batch_options import add_batch_options
from intellwheels_experiments.run.floor_scene import add_scene_options
from intellwheels_experiments.run.launch_spec import WALL_LIMIT
from intellwheels_experiments.run.run_report import LINES_HELP as RUN_LINES
from intellwheels_schemas import command_parser, defaults, messages
from intellwheels_schemas.command_parser import CommandParser, like_field, readable_file
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.identity_option import add_identity_option
from intellwheels_schemas.messages import Pace
from intellwheels_schemas.names import check_name
from intellwheels_schemas.output_paths import add_overwrite_option
from intellwheels_schemas.version import add_version_option

_EPILOG = """\
examples:
  iw-run figure6 --view                      three chairs, a table and a door, on a page in your browser
  iw-run figure6                             the same without a page, as fast as possible
  iw-run figure6 --seed 7 --json result.json
  iw-run --floor clinic.building.yaml --doors --view   a building of Open-RMF, its doors as agents
  iw-run my/scene.xml --encoding xml --logs logs
  iw-run figure6 --command chair1="./mine {name} {endpoint}"
      your program drives chair1
  iw-run table1 --seeds 40 --jobs 2 --out t1
      an experiment: every row with 40 seeds, and a report; after an interruption, run the same command again
  iw-run table1 --seeds 400 --part 2/8 --out p2          the second of eight shares, on one of eight machines
  iw-run table1 --seeds 400 --merge p1 --merge p2 ...    the report of all shares
  iw-run table1 --seeds 400 --cluster tcp://host:8786    the workers of a Dask cluster do the runs
  iw-run table1 --row real-autonomous --branch t1/runs/real-autonomous/3/input.jsonl --at 200 \\
      --option chair.speed=0.3 --out what-if
      what if: repeat that run, but slower from tick 200 on

Exit codes: 0 all conditions of the scene held or, in a batch or branch, every run reached its end; 1 otherwise, also if
the run is interrupted; 2 wrong usage; 130 if interrupted before anything started.

The command needs the extra `server`; with --view also `viewer`, and for a batch or branch also `experiments`,
and with --cluster also `cluster`.
"""


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    found = CommandParser(
        prog="iw-run",
        description="Run a scene: start the simulator and all agents of the scene, show the progress, end all\n"
        "processes, and report whether the conditions of the scene held.",
        epilog=_EPILOG + RUN_LINES + BATCH_LINES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_version_option(found)
    add_scene_options(found)
    found.add_argument(
        "--view", action="store_true",
        help="serve a page that shows and controls the run, until Ctrl-C",
    )  # fmt: skip
    found.add_argument(
        "--view-port", type=command_parser.port, metavar="N", default=8080,
        help="with --view: port of the page; 0 picks a free one (default: 8080)",
    )  # fmt: skip
    found.add_argument(
        "--dark", action="store_true",
        help="with --view: show the page in the dark theme; without it, the page follows its user's system setting",
    )  # fmt: skip
    found.add_argument(
        "--pace", choices=get_args(Pace), help="pace of the run (default: the scene's; realtime with --view)"
    )
    found.add_argument(
        "--speed",
        type=like_field(messages.Factor),
        metavar="F",
        default=1.0,
        help="simulated time over real time, in (0, 1000], at pace realtime (default: 1)",
    )
    found.add_argument(
        "--seed", type=like_field(messages.Seed), metavar="TEXT", help="seed of all noise (default: the scene's)"
    )
    found.add_argument(
        "--mind", action="append", default=[], metavar="AGENT=MIND",
        help="give an agent another mind: its name, or a Python file; may be repeated",
    )  # fmt: skip
    found.add_argument(
        "--command", action="append", default=[], metavar="AGENT=COMMAND",
        help="let your program, in any language, play an agent; {name}, {endpoint} and {world} in COMMAND are "
        "replaced; may be repeated",
    )  # fmt: skip
    found.add_argument(
        "--option", action="append", default=[], metavar="AGENT.NAME=VALUE",
        help="change an option of a mind or, without --branch, a field of a robot; may be repeated",
    )  # fmt: skip
    found.add_argument(
        "--encoding", choices=("json", "xml"), default="json", help="encoding of the agents' messages (default: json)"
    )
    found.add_argument(
        "--json", type=Path, metavar="FILE",
        help="write the result to this file as JSON; its field `hash` is the hash of the final state",
    )  # fmt: skip
    found.add_argument(
        "--log", type=Path, metavar="FILE",
        help="write the input log, for iw-server --resimulate and --play; with FILE run.jsonl, the log of a laboratory "
        "(the second simulation of a scene with Bridge elements) is run-lab.jsonl",
    )  # fmt: skip
    add_overwrite_option(found)
    found.add_argument(
        "--logs", type=Path, metavar="DIR",
        help="keep what the processes print in this folder, and replace what an earlier run left there (default: a "
        "temporary folder, kept only if the run fails)",
    )  # fmt: skip
    found.add_argument(
        "--timeout",
        type=command_parser.positive_seconds,
        metavar="S",
        help=f"seconds of wall time after which a run is aborted (default: {WALL_LIMIT:g}, plus the scene's time "
        "limit at pace realtime; none with --view)",
    )
    add_batch_options(found)
    link = found.add_argument_group(
        "connection",
        "by default the simulator listens at a free port of this machine; a batch or branch takes none of these",
    )
    link.add_argument(
        "--world",
        type=_world,
        metavar="NAME",
        default=defaults.WORLD,
        help=f"name of the world (default: {defaults.WORLD})",
    )
    link.add_argument(
        "--listen",
        action="append",
        default=[],
        metavar="ENDPOINT",
        help="where the simulator listens, such as tcp/127.0.0.1:7447, so that other programs can connect; may be "
        "repeated",
    )
    link.add_argument(
        "--connect", action="append", default=[], metavar="ENDPOINT",
        help="router to which all processes connect; may be repeated",
    )  # fmt: skip
    link.add_argument(
        "--config", type=readable_file, metavar="FILE", help="Zenoh configuration (JSON5) of all processes"
    )
    add_identity_option(link)
    return found


def _world(text: str) -> str:
    try:
        return check_name(text, "--world")
    except WireError as error:
        raise argparse.ArgumentTypeError(error.text) from None
