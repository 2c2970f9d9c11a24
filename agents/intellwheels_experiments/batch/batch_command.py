"""`iw-run SCENE --seeds N`: runs a batch and writes its files.

`run_store` writes the files of each run. Beside them are `batch.csv`, `summary.json`, `junit.xml` and `report.html`.
"""

from __future__ import annotations

import os
import platform
import shlex
import sys
import threading
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from datetime import timedelta
from pathlib import Path
from typing import Final

import msgspec
import numpy as np
from rich import markup
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.table import Table

from intellwheels_experiments.batch.batch_parts import WHOLE
from intellwheels_experiments.batch.cluster_batch import run_on_cluster
from intellwheels_experiments.batch.collect_runs import collect_runs
from intellwheels_experiments.batch.experiment_rows import Row
from intellwheels_experiments.batch.findings import counted
from intellwheels_experiments.batch.html_report import HtmlReport, floor_hash, render
from intellwheels_experiments.batch.report_drawings import PlottedRun, timeline
from intellwheels_experiments.batch.run_batch import Batch, pending_runs, read_batch, run_batch, runs_of_part
from intellwheels_experiments.batch.run_store import StoredRun, finished_run, load_run, read_tum, run_folder, runs_csv
from intellwheels_experiments.batch.scratch_folders import delete_abandoned
from intellwheels_experiments.batch.seed_variation import label_of
from intellwheels_experiments.batch.summary import Summary, summarize, to_json, to_junit
from intellwheels_experiments.batch.sweep import sweep
from intellwheels_experiments.batch.umbmark import Factor, UmbmarkResult, umbmark_of
from intellwheels_experiments.run.progress import PLAIN_EVERY
from intellwheels_experiments.run.run_report import versions
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Experiment, Robot, Scene

ABOUT: Final = "batch.json"


class About(msgspec.Struct, frozen=True, kw_only=True):
    """Holds the scene and the map of the batch. A batch of another scene or map is refused in its folder."""

    scene: Scene
    floor: str


class OtherBatchError(ValueError):
    """The folder belongs to another batch."""


def perform_batch(batch: Batch, scene: Scene, console: Console, stop: threading.Event) -> Summary:
    """Make the pending runs of a batch, write its files and return its summary.

    Args:
        batch: The batch.
        scene: Its scene.
        console: Where to show the progress.
        stop: Set from outside to abort. Finished runs stay, and the files cover them.

    Raises:
        OtherBatchError: The folder belongs to another batch.
        OSError: A file cannot be written.
    """
    _make_runs(batch, scene, console, stop)
    return write_files(batch, scene)


def perform_part(batch: Batch, scene: Scene, console: Console, stop: threading.Event) -> list[StoredRun]:
    """Make the pending runs of the batch's part, and return the runs of the part that are stored.

    Raises:
        OtherBatchError: The folder belongs to another batch.
        OSError: A file cannot be written.
    """
    _make_runs(batch, scene, console, stop)
    found = [load_run(batch.out, row.name, seed) for row, seeds in runs_of_part(batch) for seed in seeds]
    return [run for run in found if run is not None]


def merge_parts(batch: Batch, scene: Scene, folders: Iterable[Path]) -> tuple[int, Summary]:
    """Bring the runs of other folders into the batch's folder and write its files.

    Returns:
        How many runs were copied, and the summary.

    Raises:
        WireError: A folder of `folders` is not that of a part of this batch.
        OtherBatchError: The batch's folder belongs to another batch.
        OSError: A file cannot be read or written.
    """
    folders = tuple(folders)
    for folder in folders:
        if not (folder / ABOUT).is_file():
            text = f"expected the folder of a part of this batch, got {str(folder)!r}"
            raise WireError("value", f"--merge: {text}", "--merge")
        if (folder / ABOUT).read_bytes() != _about(batch, scene):
            text = f"expected a part of this batch, got the folder of another batch, {str(folder)!r}"
            raise WireError("value", f"--merge: {text}", "--merge")
    _claim_folder(batch, scene)
    copied = collect_runs(batch.out, folders, [row.name for row in batch.rows], batch.seeds)
    return copied, write_files(batch, scene)


def _make_runs(batch: Batch, scene: Scene, console: Console, stop: threading.Event) -> None:
    _claim_folder(batch, scene)
    pending = sum(len(seeds) for _, seeds in pending_runs(batch))
    total = sum(len(seeds) for _, seeds in runs_of_part(batch))
    whole = f"{counted(len(batch.rows), 'row')} x {counted(len(batch.seeds), 'seed')}"
    share = "" if batch.part == WHOLE else f"part {batch.part} of "
    console.print(f"{counted(total, 'run')}: {share}{whole}", markup=False, highlight=False)
    if pending < total:
        console.print(f"resuming: {total - pending} of {total} runs are done", markup=False, highlight=False)
    begun = printed = time.monotonic()
    with _bar(console) as bar:
        task = bar.add_task(scene.name, total=total, completed=total - pending)

        def on_run(run: StoredRun) -> None:
            nonlocal printed
            bar.advance(task)
            if not console.is_terminal and time.monotonic() >= printed + PLAIN_EVERY:
                printed = time.monotonic()
                done = round(bar.tasks[task].completed)
                left = remaining(printed - begun, done - (total - pending), total - done)
                console.print(f"progress done={done} of={total} remaining={left}", highlight=False)
            if run.died:
                console.print(
                    f"died row={run.row} seed={run.seed} why={run.died}", markup=False, highlight=False, soft_wrap=True
                )

        if batch.cluster is None:
            run_batch(batch, on_run, stop)
        else:
            run_on_cluster(batch, batch.cluster, on_run, stop)


def remaining(seconds: float, made: int, pending: int) -> str:
    """Return how long the pending runs take if they take as long as those made, as `hours:minutes:seconds`.

    Args:
        seconds: Wall time in s since the first run began.
        made: Number of runs made since then, at least 1.
        pending: Number of runs that are not made yet.
    """
    return str(timedelta(seconds=round(seconds / made * pending)))


def shortfall(batch: Batch, *, interrupted: bool) -> str:
    """Return how many runs of the batch's part are done and what to do about the others; empty if none is missing.

    Args:
        batch: The batch.
        interrupted: Whether the batch was stopped from outside.
    """
    of_part = [(row.name, seed) for row, seeds in runs_of_part(batch) for seed in seeds]
    done = sum(finished_run(batch.out, *one) is not None for one in of_part)
    missing = sum(load_run(batch.out, *one) is None for one in of_part)
    if interrupted and done < len(of_part):
        return f"interrupted: {done} of {len(of_part)} runs are done; run the same command again to resume"
    if missing:
        advice = "merge the folders of all parts, or run the command without --merge to make them"
        return f"incomplete: {missing} of {len(of_part)} runs are missing; {advice}"
    return ""


def write_files(
    batch: Batch, scene: Scene, timelines: Mapping[str, Sequence[tuple[str, str]]] | None = None
) -> Summary:
    """Write the files about all runs, and return the summary.

    Args:
        batch: The batch.
        scene: Its scene.
        timelines: Further drawings, by row: the title and the SVG of each.
    """
    runs = read_batch(batch)
    summary = summarize(batch.rows, runs, scene.experiment)
    out = batch.out
    if scene.experiment is not None and (spec := scene.experiment.umbmark) is not None:
        squares = None if any(run.is_missing for run in runs) else umbmark_of(out, runs, spec)
        summary = msgspec.structs.replace(summary, umbmark=squares)
    (out / "batch.csv").write_text(runs_csv(runs))
    (out / "summary.json").write_bytes(to_json(summary))
    (out / "junit.xml").write_text(to_junit(scene.name, summary, runs))
    page = HtmlReport(
        scene=scene,
        floor=batch.floor,
        summary=summary,
        runs=runs,
        plotted={row.name: _plotted(batch, row, runs) for row in batch.rows},
        drift={row.name: _drift(batch, row) for row in batch.rows},
        origin=_origin(batch, scene),
        timelines={**{row.name: _doors(batch, row) for row in batch.rows}, **(timelines or {})},
    )
    (out / "report.html").write_text(render(page))
    return summary


def show(summary: Summary, console: Console, experiment: Experiment | None = None) -> None:
    """Print a batch: tables on a terminal, plain lines elsewhere.

    Args:
        summary: The summary of the batch.
        console: Where to print.
        experiment: The scene's experiment. If it has several factors, a terminal shows the grid of its rows too.
    """
    if console.is_terminal:
        _show_tables(summary, console, experiment)
    else:
        for line in _lines(summary):
            # Not with the console's print, which would wrap what a script reads.
            console.file.write(line + "\n")
        console.file.flush()


def _lines(summary: Summary) -> Iterator[str]:
    """Yield the lines for a script: the verb first, then `name=value`."""
    for row in summary.lines:
        low, high = row.interval
        yield (
            f"row name={row.name} runs={row.runs} succeeded={row.succeeded} low={low:.3f} high={high:.3f} "
            f"reached={row.reached} collided={row.collided} physical={row.physical} virtual={row.virtual} "
            f"died={len(row.died)} missing={len(row.missing)}"
        )
    for one in summary.comparisons:
        line = f"compare first={one.first} second={one.second or '-'} expect={one.expect or '-'}"
        if one.paired is not None:
            line += f" difference={one.paired.difference:+.3f} p={one.paired.p:.4f}"
            line += f" equivalent={'yes' if one.paired.equivalent else 'no'}"
        yield f"{line} found={one.verdict.replace(' ', '-')}"
    for name, factor in _factors(summary.umbmark):
        error = "-" if factor.error is None else f"{factor.error:.5f}"
        yield f"umbmark figure={name} true={factor.true:.4f} found={factor.found:.4f} error={error}"


def _show_tables(summary: Summary, console: Console, experiment: Experiment | None) -> None:
    table = Table("row", "runs", "succeeded", "95 %", "collided", "physical", "virtual", "time", "odometry error")
    for row in summary.lines:
        low, high = row.interval
        cells = [markup.escape(row.title), str(row.runs), str(row.succeeded), f"{100 * low:.0f} to {100 * high:.0f} %"]
        cells += [str(row.collided), str(row.physical), str(row.virtual)]
        for name, form in (("time", "{:.1f} s"), ("odometry_error", "{:.3f} m")):
            cells.append(form.format(row.spread[name].median) if name in row.spread else "-")
        table.add_row(*cells)
    console.print(table)
    _show_sweep(summary, console, experiment)
    for one in summary.comparisons:
        pair = f"{one.first} and {one.second}" if one.second else one.first
        result = "not as expected" if one.verdict == "otherwise" else one.verdict
        expected = f"expected {one.expect}; result: {result}" if one.expect else "no expectation"
        console.print(f"{pair}: {expected}", highlight=False)
    for name, factor in _factors(summary.umbmark):
        error = "" if factor.error is None else f" +- {factor.error:.4f}"
        console.print(f"UMBmark {name}: true {factor.true:.4f}, found {factor.found:.4f}{error}", highlight=False)


def _show_sweep(summary: Summary, console: Console, experiment: Experiment | None) -> None:
    grid = sweep(experiment, summary.lines)
    if grid is None:
        return
    across = " and ".join(title.lower() for title in grid.across)
    heads = (*grid.down, *("\n".join(column) for column in grid.columns))
    table = Table(*map(markup.escape, heads), title=markup.escape(f"Successful runs, by {across}"))
    for levels, cells in grid.rows:
        table.add_row(*map(markup.escape, levels), *(f"{row.succeeded} / {row.runs}" if row else "" for row in cells))
    console.print(table)


def _factors(result: UmbmarkResult | None) -> tuple[tuple[str, Factor], ...]:
    return () if result is None else (("E_d", result.wheels), ("E_b", result.base))


def _claim_folder(batch: Batch, scene: Scene) -> None:
    """Note in the folder which batch it belongs to, or raise if it belongs to another."""
    path = batch.out / ABOUT
    batch.out.mkdir(parents=True, exist_ok=True)
    delete_abandoned(batch.out)
    text = _about(batch, scene)
    if path.exists():
        if path.read_bytes() != text:
            raise OtherBatchError(f"{batch.out}: expected an empty folder or that of this batch, got another batch's")
        return
    # Parts on other machines may claim a shared folder at the same time: none reads half a file.
    draft = path.with_name(f".{ABOUT}.{os.getpid()}")
    draft.write_bytes(text)
    draft.replace(path)


def _about(batch: Batch, scene: Scene) -> bytes:
    about = About(scene=scene, floor=floor_hash(batch.floor))
    return msgspec.json.format(msgspec.json.encode(about), indent=2) + b"\n"


def _bar(console: Console) -> Progress:
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    return Progress(*columns, TimeRemainingColumn(), console=console, disable=not console.is_terminal)


def _plotted(batch: Batch, row: Row, runs: Sequence[StoredRun]) -> list[PlottedRun]:
    """Return the finished runs of a row, read from their files."""
    plotted = []
    for run in runs:
        folder = run_folder(batch.out, run.row, run.seed)
        true = read_tum(folder / "true.tum") if run.row == row.name and run.measured else None
        if true is None or run.measured is None:
            continue
        lines = np.loadtxt(folder / "along.csv", delimiter=",", skiprows=1, usecols=(1, 2), ndmin=2)
        contacts = [line.split(",") for line in (folder / "contacts.csv").read_text().splitlines()[1:]]
        plotted.append(
            PlottedRun(
                seed=run.seed,
                success=run.measured.success,
                true=true,
                reported=read_tum(folder / "reported.tum"),
                clearance=lines[:, 0],
                speed=lines[:, 1],
                contacts=[(float(contact[3]), float(contact[4])) for contact in contacts],
            )
        )
    return plotted


def _doors(batch: Batch, row: Row) -> list[tuple[str, str]]:
    """Return the timeline of a row's doors, from its first run that has one."""
    doors = [cast.name for cast in row.scene.cast if cast.mind == "door"]
    for seed in batch.seeds:
        folder = run_folder(batch.out, row.name, seed)
        path, true = folder / "bodies.csv", read_tum(folder / "true.tum")
        if not doors or true is None or not path.exists():
            continue
        values = np.atleast_1d(np.genfromtxt(path, delimiter=",", names=True))
        series = []
        for door in doors:
            if f"{door}_heading" in (values.dtype.names or ()):
                angle = np.degrees(np.unwrap(values[f"{door}_heading"]) - values[f"{door}_heading"][0])
                series.append((f"{door}: opening angle (deg)", values["time"], np.abs(angle)))
                distance = np.hypot(true[:, 1] - values[f"{door}_x"], true[:, 2] - values[f"{door}_y"])
                series.append((f"{batch.subject}: distance from the hinge (0.1 m)", true[:, 0], 10.0 * distance))
        if series:
            return [(f"Door over time, seed {seed}", timeline(series, "deg, 0.1 m"))]
    return []


def _drift(batch: Batch, row: Row) -> tuple[float, float]:
    """Return the variance of a row's wheels, per metre in m, and its track in m, from its first run with a robot."""
    for seed in batch.seeds:
        robot = _robot(run_folder(batch.out, row.name, seed) / "robot.json")
        if robot is not None:
            return (robot.encoders[0].drift if robot.encoders else 0.0), robot.track
    return 0.0, 1.0


def _robot(path: Path) -> Robot | None:
    try:
        return msgspec.json.decode(path.read_bytes(), type=Robot)
    except (OSError, msgspec.MsgspecError):
        return None


def _origin(batch: Batch, scene: Scene) -> dict[str, str]:
    seeds = batch.seeds
    listed = f"{seeds[0]} to {seeds[-1]} ({len(seeds)})" if len(seeds) > 1 else seeds[0]
    origin = {"scene": batch.source, "floor": f"{batch.floor.name} {floor_hash(batch.floor)}"}
    if batch.floor.source:
        origin["source of the map"] = batch.floor.source
    if varied := _varied(scene):
        origin["differs by seed"] = varied
    origin |= {"seeds": listed, "period": f"{scene.period:g} s", "pace": "lockstep, strict"}
    origin |= versions()
    origin["processor"] = f"{_processor()}, {os.cpu_count()} cores, {platform.system()} {platform.machine()}"
    origin["command"] = shlex.join(["iw-run", *sys.argv[1:]])
    return origin


def _varied(scene: Scene) -> str:
    """Return the ranges of what differs from seed to seed, as text; empty if nothing does."""
    if scene.experiment is None:
        return ""
    levels = [level for factor in scene.experiment.factor for level in factor.level]
    ranges = dict.fromkeys(
        f"{label_of(one)} {one.low:+g} to {one.high:+g}"
        for uniforms in (scene.experiment.uniform, *(level.uniform for level in levels))
        for one in uniforms
    )
    return ", ".join(ranges)


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor() or "unknown"
    return next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), "unknown")
