"""`iw-run`: runs a scene, an experiment with many seeds, or a what-if run.

It starts the processes of a scene and ends them.
"""

from __future__ import annotations

import argparse
import dataclasses
import math
import shutil
import sys
import tempfile
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Final

import msgspec
from rich.console import Console

from intellwheels_experiments.batch.batch_parts import WHOLE
from intellwheels_experiments.batch.experiment_rows import Row, rows_of
from intellwheels_experiments.batch.seed_variation import check_variation
from intellwheels_experiments.run.cast_changes import with_changes
from intellwheels_experiments.run.endpoints import free_endpoint
from intellwheels_experiments.run.floor_scene import check_scene_options, write_floor_scene
from intellwheels_experiments.run.foreign_program import check_programs
from intellwheels_experiments.run.launch_spec import WALL_LIMIT, LaunchSpec, laboratory_log, resolved, wall_limit
from intellwheels_experiments.run.progress import Progress
from intellwheels_experiments.run.run_report import show, to_json
from intellwheels_experiments.run.scene_run import perform
from intellwheels_experiments.run.start_watch import once
from intellwheels_experiments.run.usage_checks import (
    check_cast_of,
    check_connection,
    check_speed,
    first_agent,
    narrow_warnings,
)
from intellwheels_experiments.run.world_watch import watching
from intellwheels_experiments.run_parser import parser
from intellwheels_maps import floor, scene
from intellwheels_maps.library import folder_of
from intellwheels_schemas.command_parser import naming
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.explain import did_you_mean
from intellwheels_schemas.extras import missing_extra
from intellwheels_schemas.link import Link
from intellwheels_schemas.messages import Map, Scene
from intellwheels_schemas.output_paths import check_output_file, check_output_folder, reserved_output, write_reserved
from intellwheels_schemas.process import stop_on_signals

INTERRUPTED: Final = 130
"""Exit code of a shell for a command that Ctrl-C ended."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    try:
        with tempfile.TemporaryDirectory(prefix="iw-floor-") as folder:
            return _run(arguments, Path(folder))
    except KeyboardInterrupt:  # before anything was started: a run has its own handlers of signals
        print("iw-run: interrupted", file=sys.stderr)
        return INTERRUPTED


def _run(arguments: Sequence[str] | None, floor_folder: Path) -> int:
    grammar = parser()
    options = grammar.parse_args(arguments)
    try:
        _check_together(grammar, options)
        _check_extras(options)
        check_connection(options)
        if options.floor is not None:
            options.scene = write_floor_scene(options.floor, floor_folder, doors=options.doors, forever=options.view)
        with naming("SCENE"):
            chosen = scene(options.scene)
            folder = folder_of(options.scene)
            chosen_floor = floor(chosen.map, beside=folder)
        if options.log is not None and chosen.bridge:
            check_output_file(laboratory_log(options.log), "--log", overwrite=options.overwrite)
        pace = options.pace or ("realtime" if options.view else chosen.pace)
        check_speed(options.speed, pace)
        if options.branch is None:
            chosen = with_changes(chosen, options.mind, options.option, options.command)
            if options.seeds is None:
                check_programs(chosen.cast, folder, _meeting(options))
                check_cast_of([chosen], folder, options)
        warnings = narrow_warnings(chosen, chosen_floor, folder)
    except (WireError, ConnectionError) as error:
        print(f"iw-run: {error}", file=sys.stderr)
        return 2
    for warning in warnings:
        print(f"iw-run: warning: {warning}", file=sys.stderr)
    if options.seeds is not None or options.branch is not None:
        return _batch(options, chosen, chosen_floor, folder)
    changes = {"pace": pace, "seed": options.seed}
    chosen = msgspec.structs.replace(chosen, **{name: value for name, value in changes.items() if value is not None})
    logs = options.logs or Path(tempfile.mkdtemp(prefix="iw-run-"))
    meets_elsewhere = options.connect or options.config is not None
    spec = LaunchSpec(
        scene=chosen,
        source=resolved(options.scene, None),
        folder=folder,
        floor=chosen_floor,
        world=options.world,
        listen=tuple(options.listen) or (() if meets_elsewhere else (free_endpoint(),)),
        connect=tuple(options.connect),
        config=options.config,
        identity=options.identity,
        logs=logs,
        speed=options.speed,
        encoding=options.encoding,
        log=options.log,
        timeout=options.timeout or (math.inf if options.view else wall_limit(chosen, options.speed)),
        view=options.view_port if options.view else None,
        dark=options.dark,
        laboratory=free_endpoint() if chosen.bridge else "",
    )
    link = Link(spec.world, (), spec.meeting, spec.config, spec.identity)
    stop = stop_on_signals()
    with ExitStack() as stack:
        report = None
        try:
            if options.json is not None:
                report = stack.enter_context(reserved_output(options.json, overwrite=options.overwrite))
        except OSError as error:
            return _unwritten(options.json, error)
        with Progress(Console(stderr=True), chosen, chosen_floor) as progress:
            result = perform(spec, lambda until: watching(link, until), progress, stop)
        show(result, Console())
        try:
            if report is not None:
                write_reserved(report, to_json(result))
        except OSError as error:
            return _unwritten(options.json, error)
    if options.logs is None:
        if result.held:
            shutil.rmtree(logs, ignore_errors=True)
        else:
            print(f"the logs are in {logs}", file=sys.stderr)
    return 0 if result.held else 1


def _unwritten(file: Path, error: OSError) -> int:
    print(f"iw-run: --json {file}: {error.strerror}", file=sys.stderr)
    return 1


def _batch(options: argparse.Namespace, chosen: Scene, chosen_floor: Map, folder: Path | None) -> int:
    out = options.out or Path(f"{chosen.name}-runs")
    try:
        rows = _rows(rows_of(chosen), options.row)
        subject = chosen.experiment.subject if chosen.experiment else first_agent(chosen)
        check_output_folder(out, "--out")
        if options.branch is not None:
            cast = with_changes(rows[0].scene, options.mind, options.option, options.command, robot_fields=False)
            changed = dataclasses.replace(rows[0], scene=cast)
            scenes = [cast]
            check_variation([changed], chosen_floor)
        else:
            scenes = [row.scene for row in rows]
        check_variation(rows, chosen_floor)
        for one in scenes:
            check_programs(one.cast, folder)
        check_cast_of(scenes, folder, options)
    except WireError as error:
        print(f"iw-run: {error.text}", file=sys.stderr)
        return 2
    # These import numpy, scipy, shapely and matplotlib: a single run needs none of them.
    from intellwheels_experiments.batch.batch_command import (  # noqa: PLC0415
        OtherBatchError,
        merge_parts,
        perform_batch,
        perform_part,
        shortfall,
    )
    from intellwheels_experiments.batch.batch_command import show as show_batch  # noqa: PLC0415
    from intellwheels_experiments.batch.cluster_client import ClusterError  # noqa: PLC0415
    from intellwheels_experiments.batch.run_batch import Batch  # noqa: PLC0415
    from intellwheels_experiments.batch.what_if import BranchError, perform_branch  # noqa: PLC0415

    console = Console(stderr=True)
    batch = Batch(
        rows=rows,
        seeds=tuple(str(seed) for seed in range(1, (options.seeds or 1) + 1)),
        subject=subject,
        floor=chosen_floor,
        source=resolved(options.scene, None),
        folder=folder,
        out=out,
        jobs=options.jobs,
        timeout=options.timeout or WALL_LIMIT,
        say=once(lambda text: console.print(text, markup=False, highlight=False, soft_wrap=True)),
        part=options.part,
        cluster=options.cluster,
    )
    stop = stop_on_signals()
    try:
        if options.branch is not None:
            summary = perform_branch(batch, chosen, changed, options.branch, options.at, stop)
        elif options.part != WHOLE:
            made = perform_part(batch, chosen, console, stop)
            died = sum(1 for run in made if run.died)
            print(f"part={options.part} runs={len(made)} died={died} out={out}")
            _say_shortfall(shortfall(batch, interrupted=stop.is_set()))
            return 1 if stop.is_set() or died else 0
        elif options.merge:
            copied, summary = merge_parts(batch, chosen, options.merge)
            print(f"merged runs={copied} folders={len(options.merge)} out={out}")
        else:
            summary = perform_batch(batch, chosen, console, stop)
    except WireError as error:
        print(f"iw-run: {error.text}", file=sys.stderr)
        return 2
    except OtherBatchError as error:
        print(f"iw-run: --out: {error}", file=sys.stderr)
        return 2
    except BranchError as error:
        print(f"iw-run: --branch: {error}", file=sys.stderr)
        return 1
    except ClusterError as error:
        print(f"iw-run: --cluster: {error}", file=sys.stderr)
        _say_shortfall(shortfall(batch, interrupted=True))
        return 1
    show_batch(summary, Console(), chosen.experiment)
    print(f"report={batch.out / 'report.html'} csv={batch.out / 'batch.csv'}")
    if options.branch is None:
        _say_shortfall(shortfall(batch, interrupted=stop.is_set()))
    return 1 if stop.is_set() or any(row.died or row.missing for row in summary.lines) else 0


def _say_shortfall(text: str) -> None:
    if text:
        print(f"iw-run: {text}", file=sys.stderr)


def _meeting(options: argparse.Namespace) -> list[str] | None:
    """Return the endpoints at which the processes meet, or None if they meet at a free port of this machine."""
    given = [*options.connect, *options.listen]
    return given if given or options.config is not None else None


_BATCH_ONLY: Final = ("jobs", "row", "out", "part", "merge", "cluster")
_BRANCH_ONLY: Final = ("at",)
_PAGE_ONLY: Final = ("view_port", "dark")
_SINGLE_ONLY: Final = (
    "floor", "view", "view_port", "dark", "pace", "speed", "seed", "encoding", "json", "log", "logs", "world", "listen",
    "connect", "config", "identity",
)  # fmt: skip


def _check_together(grammar: argparse.ArgumentParser, options: argparse.Namespace) -> None:
    """Check that no option is given that the wanted kind of run would ignore, and that all outputs can be written.

    Raises:
        WireError: One is, or one cannot.
    """
    given = {name for name, value in vars(options).items() if value != grammar.get_default(name)}
    check_scene_options(options)
    rules: list[tuple[tuple[str, ...], str]] = []
    if options.seeds is None and options.branch is None:
        rules += [(_BATCH_ONLY, "expected with --seeds or --branch, got a single run")]
    else:
        rules += [(_SINGLE_ONLY, "expected with a single run, got --seeds or --branch")]
    if options.seeds is not None:
        rules += [(("overwrite",), "expected with a single run or --branch, got a batch, which resumes in its folder")]
    elif options.branch is None and options.json is None and options.log is None:
        rules += [(("overwrite",), "expected with --json, --log or --branch, got none of them")]
    if not options.view:
        rules += [(_PAGE_ONLY, "expected with --view, got none")]
    if options.branch is None:
        rules += [(_BRANCH_ONLY, "expected with --branch, got none")]
    else:
        rules += [(("seeds", "jobs", "part", "merge", "cluster"), "expected without --branch, which repeats one run")]
        if len(options.row or ()) > 1:
            rules += [(("row",), "expected one row with --branch, which repeats one run")]
    if options.merge:
        rules += [(("jobs", "part", "cluster"), "expected without --merge, which does no runs")]
    if options.cluster is not None:
        rules += [(("jobs",), "expected without --cluster, whose workers have their own number of threads")]
    for group, text in rules:
        for name in given.intersection(group):
            option = f"--{name.replace('_', '-')}"
            raise WireError("value", f"{option}: {text}", option)
    for name in ("json", "log"):
        check_output_file(getattr(options, name), f"--{name}", overwrite=options.overwrite)
    for name in ("logs", "out"):
        check_output_folder(getattr(options, name), f"--{name}")
    out = options.out
    if options.branch is not None and out is not None and out.is_dir() and any(out.iterdir()) and not options.overwrite:
        expected = "expected an empty folder, or --overwrite to replace the report in it"
        raise WireError("value", f"--out: {expected}, got {out}", "--out")


def _check_extras(options: argparse.Namespace) -> None:
    """Check that the processes of the run, its page and its report have what they import.

    Raises:
        WireError: An extra is not installed.
    """
    needed = ["server"]
    needed += ["viewer"] if options.view else []
    needed += ["experiments"] if options.seeds is not None or options.branch is not None else []
    needed += ["cluster"] if options.cluster is not None else []
    lacking = missing_extra(*needed)
    if lacking is not None:
        raise WireError("value", lacking)


def _rows(rows: tuple[Row, ...], names: Sequence[str] | None) -> tuple[Row, ...]:
    known = [row.name for row in rows]
    for name in names or ():
        if name not in known:
            text = f"--row: expected a row ({', '.join(known)}), got {name!r}{did_you_mean(name, known)}"
            raise WireError("value", text, "--row")
    return tuple(row for row in rows if not names or row.name in names)


if __name__ == "__main__":
    sys.exit(main())
