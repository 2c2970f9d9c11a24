"""The command `iw-server`: one simulated world on the network, or an input log run again."""

from __future__ import annotations

import argparse
import gc
import sys
from pathlib import Path

import msgspec

from intellwheels_maps import floor, scene
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.link import DEFAULT_WORLD, Link, add_link_options, link_of
from intellwheels_schemas.messages import Map, Scene
from intellwheels_schemas.names import check_name
from intellwheels_schemas.process import add_process_options, stop_on_signals
from intellwheels_server.log.branch import read_branch
from intellwheels_server.log.input_log import LogError, read_header
from intellwheels_server.log.resimulate import resimulate
from intellwheels_server.service.service_state import Options
from intellwheels_server.world import Setup

EXAMPLES = """\
examples:
  iw-server                                   the floor `room` in real time, at tcp/127.0.0.1:7447
  iw-server --map ward --speed 4              a hospital ward, four times as fast
  iw-server --scene figure6 --log run.jsonl   a scene as it is written, waiting for its cast
  iw-server --resimulate run.jsonl            run that again and compare every tick's hash
  iw-server --play run.jsonl                  show it in world `main-play`: pause, step, speed, seek forth and back

Standard output says `ready ...` when agents may join, `running tick=0 run=R` when those expected are there, and
`ended tick=N hash=H run=R` when the end condition is met. Exit code: 0 done, 1 refused or failed, 2 wrong usage.
"""

LIVE = (
    "scene", "map", "seed", "period", "truth", "hide_truth", "pace", "miss", "expect", "open_loop", "deadline", "log",
    "runs", "branch",
)  # fmt: skip
"""Options of a live run, that a log which is played has no use for."""
PLAYED_FROM = 27
"""Characters of a world's name to which `-play` can be added: a name has at most 32."""
STRICT_DEADLINE = 10.0
"""Seconds a strict lockstep waits for an answer."""
ELASTIC_DEADLINE = 1.0
"""Seconds an elastic lockstep waits for an answer."""


def parser() -> argparse.ArgumentParser:
    """Return the command line's grammar."""
    found = argparse.ArgumentParser(
        prog="iw-server",
        description="Simulate a floor with intelligent wheelchairs, doors and tables. "
        "Each is an agent, a process of its own, that joins over Zenoh.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    what = found.add_argument_group("what is simulated")
    what.add_argument(
        "--scene",
        metavar="NAME|FILE",
        help="take map, seed, period, pace, end, cast and how a say is heard from a scene",
    )
    what.add_argument("--map", metavar="NAME|FILE", help="the floor (default: room)")
    what.add_argument("--seed", metavar="TEXT", help="all noise follows from it (default: 1)")
    what.add_argument("--period", type=_positive, metavar="S", help="simulated seconds of a tick (default: 0.05)")
    what.add_argument("--truth", action="store_true", default=None, help="allow sensors that tell the true pose")
    what.add_argument(
        "--hide-truth",
        action="store_true",
        default=None,
        help="true poses stay in the log, off the network: a laboratory, whose chairs are real to another world",
    )
    what.add_argument("--say-limit", type=_count, default=100, metavar="N", help="characters of one say (default: 100)")
    what.add_argument(
        "--say-range", type=_positive, metavar="M", help="metres a say is heard (default: the scene's, or 8)"
    )
    what.add_argument(
        "--say-walls", action=argparse.BooleanOptionalAction,
        help="walls and closed doors keep a say from being heard (default: the scene's, or not)",
    )  # fmt: skip
    what.add_argument(
        "--say-loss", type=_share, metavar="P",
        help="share of what agents say that a listener misses (default: the scene's, or 0)",
    )  # fmt: skip
    what.add_argument(
        "--say-delay", type=_seconds, metavar="S",
        help="simulated seconds a say takes beyond the next tick (default: the scene's, or 0)",
    )  # fmt: skip
    what.add_argument(
        "--command-timeout", type=_positive, default=0.5, metavar="S",
        help="simulated seconds a command of an agent that asked for none counts (default: 0.5)",
    )  # fmt: skip
    time = found.add_argument_group("time")
    time.add_argument(
        "--pace", choices=("realtime", "free", "lockstep"),
        help="what makes a tick begin: the clock, nothing, or every agent's answer (default: realtime)",
    )  # fmt: skip
    time.add_argument("--speed", type=_positive, default=1.0, metavar="F", help="simulated over real time (default: 1)")
    time.add_argument(
        "--miss", choices=("strict", "elastic"),
        help="lockstep, of an answer that does not come: end the run, or keep the last command (default: strict)",
    )  # fmt: skip
    time.add_argument("--expect", metavar="A,B,C", help="wait at tick 0 until these agents are there")
    time.add_argument("--open-loop", action="store_true", help="running free, allow agents that want to be waited for")
    time.add_argument(
        "--deadline",
        type=_positive,
        metavar="S",
        help="seconds an answer is waited for (default: strict 10, elastic 1)",
    )
    time.add_argument(
        "--grace",
        type=_positive,
        default=3.0,
        metavar="S",
        help="seconds an agent that vanished is waited for (default: 3)",
    )
    run = found.add_argument_group("run")
    run.add_argument("--log", type=Path, metavar="FILE", help="write the input log (JSON Lines)")
    run.add_argument(
        "--runs", type=Path, metavar="DIR", help="write input log and trace (what was true) of each run there"
    )
    run.add_argument("--trace", type=Path, metavar="FILE", help="with --resimulate: write what was true at each tick")
    run.add_argument(
        "--branch", type=Path, metavar="FILE",
        help="begin as the run of this input log went, with its floor, seed, period and end",
    )  # fmt: skip
    run.add_argument(
        "--at", type=_tick, metavar="TICK", default=0, help="with --branch: where what comes is obeyed (0)"
    )
    run.add_argument("--resimulate", type=Path, metavar="FILE", help="run an input log again and compare; nothing else")
    run.add_argument(
        "--play", type=Path, metavar="FILE",
        help="put an input log on the network as a world of its own (default name: the log's, with -play behind); "
        "it waits until a page opens or somebody resumes it, except with --quit-at-end",
    )  # fmt: skip
    run.add_argument(
        "--reported", type=Path, metavar="FILE",
        help="with --play of a laboratory's log: the log of the world that its chairs joined, to show beside the truth "
        "where they said that they were; the two are paired run by run, tick by tick",
    )  # fmt: skip
    run.add_argument("--quit-at-end", action="store_true", help="exit when the end condition is met")
    add_process_options(found)
    add_link_options(found, listens=True)
    found.set_defaults(world=None)  # which name is the default depends on what is run
    return found


def main(arguments: list[str] | None = None) -> int:
    """Run the command and return its exit code."""
    grammar = parser()
    given = grammar.parse_args(arguments)
    if given.trace is not None and given.resimulate is None:
        grammar.error("--trace: it goes with --resimulate")
    if given.reported is not None and given.play is None:
        grammar.error("--reported: it goes with --play")
    if given.resimulate is not None:
        return _resimulate(given.resimulate) if given.trace is None else _trace(given.resimulate, given.trace)
    if given.play is not None:
        for name in LIVE:
            if getattr(given, name):
                grammar.error(f"--play: the log says what is run; --{name.replace('_', '-')} does not go with it")
        return _play(given)
    given.world = given.world or DEFAULT_WORLD
    try:
        options, route = options_of(given)
    except WireError as error:
        print(f"iw-server: {error.text}", file=sys.stderr)
        return 2
    except (LogError, OSError) as error:
        print(f"iw-server: --branch: {error}", file=sys.stderr)
        return 2
    except ValueError as error:
        grammar.error(str(error))
    stop = stop_on_signals(given.lifeline)
    # These import numba and zenoh: `--help` and usage errors come without them.
    from intellwheels_server.service.simulator_peer import WorldTakenError, serve  # noqa: PLC0415
    from intellwheels_server.world.warmup import warm  # noqa: PLC0415

    warm()
    # What lives now lives as long as the process: the collector need not look at it at every pass of the loop.
    gc.collect()
    gc.freeze()
    try:
        return serve(options, route, stop, given.log, runs=given.runs)
    except (ConnectionError, WorldTakenError) as error:
        print(f"iw-server: {error}", file=sys.stderr)
    except OSError as error:
        print(f"iw-server: --log {given.log or given.runs}: {error.strerror}", file=sys.stderr)
    return 1


def _play(given: argparse.Namespace) -> int:
    try:
        with given.play.open("rb") as file:
            world = read_header(file, str(given.play)).world
        if given.reported is not None:
            with given.reported.open("rb") as file:
                read_header(file, str(given.reported))
        given.world = check_name(given.world or f"{world[:PLAYED_FROM]}-play", "--world")
        route = link_of(given)
    except (WireError, LogError) as error:
        print(f"iw-server: {error.text if isinstance(error, WireError) else error}", file=sys.stderr)
        return 2 if isinstance(error, WireError) else 1
    except OSError as error:
        print(f"iw-server: {error.filename}: {error.strerror}", file=sys.stderr)
        return 1
    stop = stop_on_signals(given.lifeline)
    from intellwheels_server.log.seekable_log import SeekableLog  # noqa: PLC0415
    from intellwheels_server.service.simulator_peer import WorldTakenError, serve  # noqa: PLC0415
    from intellwheels_server.world.warmup import warm  # noqa: PLC0415

    def progress(lines: int) -> None:
        print(f"reading lines={lines}", file=sys.stderr, flush=True)
        if stop.is_set():
            raise SystemExit(0)

    def read(log: Path) -> SeekableLog:
        recording = SeekableLog(log, progress)
        if recording.cut:
            print(f"{log}: the last line was cut and is dropped", file=sys.stderr)
        if recording.differs is not None:
            print(f"{log}: what is shown is not what was: {recording.differs}", file=sys.stderr)
        return recording

    warm()
    try:
        recording = read(given.play)
        reported = None if given.reported is None else read(given.reported)
        setup = recording.header.world_setup()
        options = Options(world=given.world, setup=setup, speed=given.speed, quit_at_end=given.quit_at_end)
        return serve(options, route, stop, recording=recording, reported=reported)
    except (ConnectionError, WorldTakenError, LogError) as error:
        print(f"iw-server: {error}", file=sys.stderr)
    return 1


def options_of(given: argparse.Namespace) -> tuple[Options, Link]:
    """Return what the command line asks for.

    Raises:
        WireError: A name or a file is wrong.
        ValueError: Options that do not go together.
    """
    written = scene(given.scene) if given.scene is not None else None
    pace = given.pace or (written.pace if written else "realtime")
    miss = given.miss or (written.miss if written else "strict")
    if given.expect is not None:
        expect = tuple(check_name(name, "--expect") for name in given.expect.split(",") if name)
    else:
        expect = tuple(cast.name for cast in written.cast) if written else ()
    if given.speed != 1.0 and pace != "realtime":
        raise ValueError(f"--speed: the pace is {pace}; only real time has a speed")
    if given.open_loop and pace != "free":
        raise ValueError(f"--open-loop: the pace is {pace}; it is for --pace free")
    if not 0.001 <= (given.period or 0.05) <= 1.0:
        raise ValueError(f"--period: expected seconds in [0.001, 1], got {given.period}")
    if given.hide_truth and (given.truth or (written and written.truth)):
        raise ValueError("--hide-truth: expected a world without truth sensors, got one that allows them")
    strict = pace == "lockstep" and miss == "strict"
    setup = Setup(
        floor=_floor(given, written),
        seed=given.seed if given.seed is not None else (written.seed if written else "1"),
        period=given.period or (written.period if written else 0.05),
        say_limit=given.say_limit,
        command_timeout=given.command_timeout,
        truth=bool(given.truth) or bool(written and written.truth),
        end=written.end if written else None,
        strict=strict,
    )
    setup = _heard(setup, given, written)
    branch = None if given.branch is None else read_branch(given.branch, given.at)
    if branch is not None:
        if pace != "lockstep" or written is not None or given.map is not None or given.seed is not None:
            raise ValueError("--branch: the log says floor and seed; give --pace lockstep and no scene, map or seed")
        setup = branch.setup({"strict": strict})
        expect = expect or branch.agents
    options = Options(
        world=check_name(given.world, "--world"),
        setup=setup,
        pace=pace,
        speed=given.speed,
        expect=expect,
        open_loop=given.open_loop,
        grace=given.grace,
        deadline=given.deadline or (STRICT_DEADLINE if strict else ELASTIC_DEADLINE),
        quit_at_end=given.quit_at_end,
        branch=branch,
        hide_truth=bool(given.hide_truth),
    )
    return options, link_of(given)


def _heard(setup: Setup, given: argparse.Namespace, written: Scene | None) -> Setup:
    """Return a world where a say is heard as the command line tells, else as the scene does."""
    names = ("say_range", "say_walls", "say_loss", "say_delay")
    told = [{name: getattr(source, name) for name in names} for source in (written, given) if source is not None]
    changes = {name: value for source in told for name, value in source.items() if value is not None}
    return msgspec.structs.replace(setup, **changes)


def _floor(given: argparse.Namespace, written: Scene | None) -> Map:
    if given.map is not None or written is None:
        return floor(given.map or "room")
    folder = Path(given.scene).parent if "/" in given.scene or given.scene.endswith(".xml") else None
    return floor(written.map, beside=folder)


def _resimulate(path: Path) -> int:
    try:
        found = resimulate(path, lambda ticks: print(f"resimulating ticks={ticks}", file=sys.stderr, flush=True))
    except LogError as error:
        print(f"iw-server: {error}", file=sys.stderr)
        return 1
    except OSError as error:
        print(f"iw-server: --resimulate {path}: {error.strerror}", file=sys.stderr)
        return 1
    if found.cut:
        print(f"{path}: the last line was cut and is dropped", file=sys.stderr)
    if found.differs is not None:
        print(f"differs {found.differs}", flush=True)
        return 1
    print(f"same ticks={found.ticks} tick={found.tick} hash={found.hash}", flush=True)
    return 0


def _trace(log: Path, target: Path) -> int:
    from intellwheels_server.log.true_trace import trace_lines  # noqa: PLC0415

    try:
        with target.open("wb") as file:
            file.writelines(trace_lines(log))
    except (LogError, OSError) as error:
        print(f"iw-server: {error}", file=sys.stderr)
        return 1
    return 0


def _tick(text: str) -> int:
    value = int(text)
    if not 0 <= value <= 1 << 40:
        raise argparse.ArgumentTypeError(f"expected a tick, got {text}")
    return value


def _positive(text: str) -> float:
    value = float(text)
    if not 0.0 < value < 1e9:
        raise argparse.ArgumentTypeError(f"expected a number above 0, got {text}")
    return value


def _share(text: str) -> float:
    value = float(text)
    if not 0.0 <= value <= 1.0:
        raise argparse.ArgumentTypeError(f"expected a number in [0, 1], got {text}")
    return value


def _seconds(text: str) -> float:
    value = float(text)
    if not 0.0 <= value <= 3600.0:
        raise argparse.ArgumentTypeError(f"expected seconds in [0, 3600], got {text}")
    return value


def _count(text: str) -> int:
    value = int(text)
    if not 0 < value <= 1000:
        raise argparse.ArgumentTypeError(f"expected a number in [1, 1000], got {text}")
    return value


if __name__ == "__main__":
    sys.exit(main())
