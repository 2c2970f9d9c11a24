"""The command line of `iw-server`: its options, and the world and service that they ask for."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from intellwheels_maps import floor, scene
from intellwheels_maps import names as included_names
from intellwheels_maps.cast_places import cast_places
from intellwheels_maps.library import folder_of
from intellwheels_schemas import defaults, messages
from intellwheels_schemas.command_parser import (
    CommandParser,
    like_field,
    naming,
    positive_seconds,
    readable_file,
    share,
    whole,
)
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.link import Link, add_link_options, link_of
from intellwheels_schemas.messages import Map, Scene
from intellwheels_schemas.names import check_agent, check_name
from intellwheels_schemas.output_paths import add_overwrite_option
from intellwheels_schemas.process import add_process_options

if TYPE_CHECKING:
    from intellwheels_server.service.service_state import Options
    from intellwheels_server.world import Setup

DEFAULT_FLOOR = "room"
"""The map if neither a map nor a scene is given."""

EXAMPLES = f"""\
examples:
  iw-server                                   the map `{DEFAULT_FLOOR}` in real time, at {defaults.ENDPOINT}
  iw-server --map ward --speed 4              a hospital ward, four times as fast as real time
  iw-server --scene figure6 --log run.jsonl   a scene; the run starts when all its agents have joined
  iw-server --resimulate run.jsonl            run that log again and compare the hash of every tick
  iw-server --resimulate run.jsonl --prove    the same, and print one line that a paper can quote
  iw-server --play run.jsonl                  show that log in world `main-play`: pause, step, speed, seek

Standard output has `ready ...` when agents may join, `running tick=0 run=R` when all expected agents have joined, and
`ended tick=N hash=H run=R` when the end condition is met. --resimulate prints `same ...`, `truncated ...`, or
`differs ...` with the place of the first difference. Exit codes: 0 done, 1 refused or failed, 2 wrong usage.
The command needs the extra `server`.
"""

OF_A_LOG = {
    "scene": None, "map": None, "seed": None, "period": None, "truth": None, "say_limit": defaults.SAY_LIMIT,
    "say_range": None, "say_walls": None, "say_loss": None, "say_delay": None,
    "command_timeout": defaults.COMMAND_TIMEOUT,
}  # fmt: skip
"""Options that the log of `--branch` decides, with their defaults."""
LAST_TICK = 1 << 40
"""Largest tick of `--at`."""

PLAY_SUFFIX = "-play"
"""The suffix that a playback adds to the name of the world in the log."""


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    found = CommandParser(
        prog="iw-server",
        description="Simulate intelligent wheelchairs, doors and tables on a map. "
        "Each of them is an agent,\nwhich joins over Zenoh from another process.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    _add_world_options(found.add_argument_group("world"))
    _add_time_options(found.add_argument_group("time"))
    _add_run_options(found.add_argument_group("run"))
    add_process_options(found)
    add_link_options(found, listens=True, world=f"{defaults.WORLD}; with --play, see there")
    found.set_defaults(world=None)  # a playback has another default
    return found


def _add_world_options(group: argparse._ArgumentGroup) -> None:
    group.add_argument(
        "--scene",
        metavar="NAME|FILE",
        help="take the map, the end condition, the agents to expect and the defaults of --seed, --period, --pace, "
        "--miss, --truth and the options of messages between agents (--say-...) from a scene",
    )
    group.add_argument(
        "--map", metavar="NAME|FILE",
        help="the map: an included one, or a file (a floor plan made for another program needs the extra `floors`, "
        f"or `ifc` if it is .ifc; a lab file of Ciber-Rato needs none) (default: the scene's, or {DEFAULT_FLOOR})",
    )  # fmt: skip
    group.add_argument(
        "--seed", type=like_field(messages.Seed), metavar="TEXT",
        help=f"the seed of all noise (default: the scene's, or {defaults.SEED})",
    )  # fmt: skip
    group.add_argument(
        "--period", type=like_field(messages.Period), metavar="S",
        help=f"simulated seconds per tick, in [0.001, 1] (default: the scene's, or {defaults.PERIOD:g})",
    )  # fmt: skip
    group.add_argument(
        "--truth", action="store_true", default=None,
        help="allow sensors that give the true pose; if the scene allows them, no option forbids them (default: the "
        "scene's, or no)",
    )  # fmt: skip
    group.add_argument(
        "--hide-truth",
        action="store_true",
        default=None,
        help="write true poses to the log only, not to the network; for a laboratory: a world whose simulated chairs "
        "stand in for real ones of another world",
    )
    group.add_argument(
        "--say-limit", type=whole(1, 1000), default=defaults.SAY_LIMIT, metavar="N",
        help="largest number of characters in a message between agents, in [1, 1000] (default: %(default)s)",
    )  # fmt: skip
    group.add_argument(
        "--say-range", type=like_field(messages.SayRange), metavar="M",
        help="distance in metres up to which a message is heard, in (0, 20000] "
        f"(default: the scene's, or {defaults.SAY_RANGE:g})",
    )  # fmt: skip
    group.add_argument(
        "--say-walls", action=argparse.BooleanOptionalAction,
        help="whether walls and closed doors block messages between agents (default: the scene's, or no)",
    )  # fmt: skip
    group.add_argument(
        "--say-loss", type=share, metavar="SHARE",
        help=f"share of messages that a listener misses, in [0, 1] (default: the scene's, or {defaults.SAY_LOSS:g})",
    )  # fmt: skip
    group.add_argument(
        "--say-delay", type=like_field(messages.SayDelay), metavar="S",
        help="simulated seconds by which a message is delayed, in addition to one tick, in [0, 3600] "
        f"(default: the scene's, or {defaults.SAY_DELAY:g})",
    )  # fmt: skip
    group.add_argument(
        "--command-timeout", type=positive_seconds, default=defaults.COMMAND_TIMEOUT, metavar="S",
        help="simulated seconds after which a motor command expires, for robots that do not set a time themselves "
        "(default: %(default)g)",
    )  # fmt: skip


def _add_time_options(group: argparse._ArgumentGroup) -> None:
    group.add_argument(
        "--pace", choices=("realtime", "free", "lockstep"),
        help="what starts a tick: the clock, the end of the previous tick, or the answers of all agents "
        "(default: the scene's, or realtime)",
    )  # fmt: skip
    group.add_argument(
        "--speed", type=like_field(messages.Factor), default=1.0, metavar="F",
        help="simulated time over real time, in (0, 1000], at pace realtime or with --play (default: %(default)g)",
    )  # fmt: skip
    group.add_argument(
        "--miss", choices=("strict", "elastic"),
        help="what lockstep does when an answer is missing: end the run, or keep the last command "
        "(default: the scene's, or strict)",
    )  # fmt: skip
    group.add_argument(
        "--expect", metavar="A,B,C",
        help="wait at tick 0 until these agents have joined (default: those of the scene or of --branch, or none)",
    )  # fmt: skip
    group.add_argument(
        "--reserve", action="append", metavar="AGENT=PLACE",
        help="keep a place of the map for an agent; may be repeated (default: the places of the scene's agents)",
    )  # fmt: skip
    group.add_argument(
        "--await-page",
        action="store_true",
        help="start paused, until a viewer's page opens or somebody resumes the run",
    )
    group.add_argument(
        "--open-loop", action="store_true",
        help="at pace free, accept agents that ask the simulator to wait, without waiting for them "
        "(default: refuse them)",
    )  # fmt: skip
    group.add_argument(
        "--deadline", type=positive_seconds, metavar="S",
        help="seconds of wall time that lockstep waits for an answer "
        f"(default: strict {defaults.STRICT_DEADLINE:g}, elastic {defaults.ELASTIC_DEADLINE:g})",
    )  # fmt: skip
    group.add_argument(
        "--agent-rays", type=whole(0, 10**12, "rays per second"), default=defaults.AGENT_RAYS, metavar="N",
        help="largest number of rays per simulated second that the sensors of an agent may cast at pace realtime; "
        "an agent with more is refused (default: %(default)s)",
    )  # fmt: skip
    group.add_argument(
        "--world-rays", type=whole(0, 10**12, "rays per second"), default=defaults.WORLD_RAYS, metavar="N",
        help="largest number of rays per simulated second that the sensors of all agents together may cast at pace "
        "realtime; an agent that would exceed it is refused (default: %(default)s)",
    )  # fmt: skip
    group.add_argument(
        "--grace", type=positive_seconds, default=defaults.GRACE, metavar="S",
        help="seconds of wall time after which an agent that vanished is removed (default: %(default)g)",
    )  # fmt: skip


def _add_run_options(group: argparse._ArgumentGroup) -> None:
    group.add_argument("--log", type=Path, metavar="FILE", help="write the input log (JSON Lines)")
    add_overwrite_option(group)
    group.add_argument(
        "--runs", type=Path, metavar="DIR",
        help="write the input log and the true trace of each run, up to its end condition, into DIR",
    )  # fmt: skip
    group.add_argument(
        "--branch", type=readable_file, metavar="FILE",
        help="repeat the run of this input log up to tick --at, then let the agents drive; needs --pace lockstep, and "
        "excludes --scene, --map, --seed and the other options of the group `world` except --hide-truth, because the "
        "log decides them",
    )  # fmt: skip
    group.add_argument(
        "--at", type=whole(0, LAST_TICK, "a tick"), metavar="TICK", default=0,
        help="with --branch: the first tick at which the agents' answers count (default: %(default)s)",
    )  # fmt: skip
    group.add_argument(
        "--resimulate",
        type=readable_file,
        metavar="FILE",
        help="run an input log again, compare the hash of the state at every tick, and exit; exit code 1 if a hash "
        "differs, if the log is edited or, without --trace, if it is truncated",
    )
    group.add_argument(
        "--prove", action="store_true",
        help="with --resimulate: if the log is complete and the run repeats exactly, print one line to quote, with "
        "map, seed, versions, checksum and result; otherwise print no such line, and end with exit code 1; not with "
        "--trace",
    )  # fmt: skip
    group.add_argument(
        "--trace",
        type=Path,
        metavar="FILE",
        help="with --resimulate: write the true state at each tick (JSON Lines) instead of printing the result; hashes "
        "are compared all the same; if the log is truncated, the trace ends where the log does, and the exit code is "
        "0; not with --prove",
    )
    group.add_argument(
        "--play", type=readable_file, metavar="FILE",
        help="show an input log on the network, as a world of its own: --world, or by default the name in the log with "
        f"{PLAY_SUFFIX} added; the playback starts when a page opens or somebody resumes it, or at once with "
        "--quit-at-end",
    )  # fmt: skip
    group.add_argument(
        "--reported", type=readable_file, metavar="FILE",
        help="with --play of the log of a laboratory: also show the poses that the chairs reported; FILE is the log of "
        "the world that they joined; both logs must be of a lockstep run, because their runs and ticks are paired "
        "in order",
    )  # fmt: skip
    group.add_argument(
        "--quit-at-end",
        action="store_true",
        help="exit when the end condition is met or, with --play, at the end of the log",
    )


def options_of(given: argparse.Namespace) -> tuple[Options, Link]:
    """Return the options of the service and the link that the command line asks for.

    Raises:
        WireError: A name or a file is wrong.
        LogError: The log of `--branch` cannot be used.
        OSError: It cannot be read.
        ValueError: Two options exclude each other, or a value is out of range.
    """
    # Imported late: they need the extra `server`, and the parser does not.
    from intellwheels_server.log.branch import read_branch  # noqa: PLC0415
    from intellwheels_server.service.service_state import Options  # noqa: PLC0415
    from intellwheels_server.world import Setup  # noqa: PLC0415

    world, link = check_name(given.world, "--world"), link_of(given)
    with naming("--scene"):
        written = scene(given.scene) if given.scene is not None else None
    pace = given.pace or (written.pace if written else "realtime")
    miss = given.miss or (written.miss if written else "strict")
    if given.expect is not None:
        expect = tuple(check_name(name, "--expect") for name in given.expect.split(",") if name)
    else:
        expect = tuple(cast.name for cast in written.cast) if written else ()
    if given.speed != 1.0 and pace != "realtime":
        raise ValueError(f"--speed: expected pace realtime, got {pace}")
    if given.open_loop and pace != "free":
        raise ValueError(f"--open-loop: expected pace free, got {pace}")
    if given.hide_truth and (given.truth or (written and written.truth)):
        raise ValueError(
            "--hide-truth: expected a world without truth sensors, got one that allows them (--truth, or the scene)"
        )
    strict = pace == "lockstep" and miss == "strict"
    setup = Setup(
        floor=_floor(given, written),
        seed=given.seed if given.seed is not None else (written.seed if written else defaults.SEED),
        period=given.period or (written.period if written else defaults.PERIOD),
        say_limit=given.say_limit,
        command_timeout=given.command_timeout,
        truth=bool(given.truth) or bool(written and written.truth),
        end=written.end if written else None,
        strict=strict,
    )
    if not _is_included(setup.floor):
        check_walls(setup.floor)
    setup = _with_speech_rules(setup, given, written)
    branch = None if given.branch is None else read_branch(given.branch, given.at)
    if branch is not None:
        if pace != "lockstep" or any(getattr(given, name) not in (None, default) for name, default in OF_A_LOG.items()):
            options_of_log = ", ".join(f"--{name.replace('_', '-')}" for name in OF_A_LOG)
            raise ValueError(f"--branch: expected --pace lockstep and none of {options_of_log}: the log sets them")
        setup = branch.setup({"strict": strict})
        expect = expect or branch.agents
    options = Options(
        world=world,
        setup=setup,
        pace=pace,
        speed=given.speed,
        expect=expect,
        open_loop=given.open_loop,
        grace=given.grace,
        agent_rays=given.agent_rays,
        world_rays=given.world_rays,
        deadline=given.deadline or (defaults.STRICT_DEADLINE if strict else defaults.ELASTIC_DEADLINE),
        quit_at_end=given.quit_at_end,
        await_page=given.await_page,
        branch=branch,
        hide_truth=bool(given.hide_truth),
        reserved=_reserved(given, written, setup.floor),
    )
    return options, link


def _reserved(given: argparse.Namespace, written: Scene | None, floor: Map) -> dict[str, str]:
    """Return the place that is kept for each agent."""
    if given.reserve is None:
        return cast_places(written.cast, floor, beside=folder_of(given.scene)) if written else {}
    known = [spot.name for spot in floor.grid.position] if floor.grid is not None else []
    found = {}
    for text in given.reserve:
        agent, _, place = text.partition("=")
        check_agent(agent, "--reserve")
        if place not in known:
            places = ", ".join(known) or "none"
            raise ValueError(f"--reserve: expected AGENT=PLACE with a place of the map ({places}), got {text!r}")
        found[agent] = place
    return found


def _with_speech_rules(setup: Setup, given: argparse.Namespace, written: Scene | None) -> Setup:
    """Return the setup with the speech options of the command line, else of the scene."""
    names = ("say_range", "say_walls", "say_loss", "say_delay")
    sources = [source for source in (written, given) if source is not None]
    changes = {name: getattr(source, name) for source in sources for name in names if getattr(source, name) is not None}
    return msgspec.structs.replace(setup, **changes)


def check_walls(floor: Map) -> None:
    """Check that the world can use the walls of a map.

    Raises:
        WireError: It cannot; the text says why.
    """
    # Imported late: `--help` need not wait for numba.
    from intellwheels_server.world.map_geometry import walls_of  # noqa: PLC0415
    from intellwheels_server.world.warmup import warm  # noqa: PLC0415

    warm()  # says that it compiles; cutting the walls would compile a kernel in silence
    try:
        walls_of(floor)
    except ValueError as error:
        raise WireError("value", f"--map: {floor.name}: {error}", "--map") from None


def _is_included(document: Map) -> bool:
    return document.name in included_names("floors") and document == floor(document.name)


def _floor(given: argparse.Namespace, written: Scene | None) -> Map:
    if given.map is not None or written is None:
        with naming("--map"):
            return floor(DEFAULT_FLOOR if given.map is None else given.map)
    return floor(written.map, beside=folder_of(given.scene))
