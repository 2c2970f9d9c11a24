"""`iw-run SCENE --seeds N`: a batch from the command line to its files.

`run_store` writes the files of each run; beside them are `batch.csv`, `summary.json`, `junit.xml` and `report.html`.
"""

from __future__ import annotations

import os
import platform
import shlex
import sys
import threading
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

import msgspec
import numpy as np
from rich import markup
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.table import Table

from intellwheels_experiments.batch.experiment_rows import Row
from intellwheels_experiments.batch.html_report import HtmlReport, floor_hash, render
from intellwheels_experiments.batch.report_drawings import Drawn, timeline
from intellwheels_experiments.batch.run_batch import Batch, read_batch, run_batch, shares_of
from intellwheels_experiments.batch.run_store import StoredRun, place_of, read_tum, table
from intellwheels_experiments.batch.summary import Summary, sum_up, to_json, to_junit
from intellwheels_experiments.batch.sweep import sweep
from intellwheels_experiments.batch.umbmark import Figure, Squares, squares
from intellwheels_experiments.run.progress import PLAIN_EVERY
from intellwheels_experiments.run.run_report import versions
from intellwheels_schemas.messages import Experiment, Robot, Scene

ABOUT: Final = "batch.json"


class About(msgspec.Struct, frozen=True, kw_only=True):
    """What a batch's folder is of: another scene does not go on in it."""

    scene: Scene
    floor: str


class OtherBatchError(ValueError):
    """A folder is another batch's; the text says so."""


def perform_batch(batch: Batch, scene: Scene, console: Console, stop: threading.Event) -> Summary:
    """Run what is left of a batch, write its files and return it summed up.

    Raises:
        OtherBatchError: The folder is another batch's.
        OSError: A file cannot be written.
    """
    _claim(batch, scene)
    left = sum(len(seeds) for _, seeds in shares_of(batch))
    total = len(batch.rows) * len(batch.seeds)
    if left < total:
        console.print(f"going on: {total - left} of {total} runs are there", markup=False, highlight=False)
    said = time.monotonic()
    with _bar(console) as bar:
        task = bar.add_task(scene.name, total=total, completed=total - left)

        def told(kept: StoredRun) -> None:
            nonlocal said
            bar.advance(task)
            if not console.is_terminal and time.monotonic() >= said + PLAIN_EVERY:
                said = time.monotonic()
                console.print(f"progress done={bar.tasks[task].completed:.0f} of={total}", highlight=False)
            if kept.died:
                console.print(f"died row={kept.row} seed={kept.seed} why={kept.died}", markup=False, highlight=False)

        run_batch(batch, told, stop)
    return write_files(batch, scene)


def write_files(
    batch: Batch, scene: Scene, timelines: Mapping[str, Sequence[tuple[str, str]]] | None = None
) -> Summary:
    """Write what is told of all runs, and return it.

    Args:
        batch: The batch.
        scene: Its scene.
        timelines: Further drawings of a row, by its name: what it shows and the SVG.
    """
    runs = read_batch(batch)
    summary = sum_up(batch.rows, runs, scene.experiment)
    out = batch.out
    if scene.experiment is not None and (asked := scene.experiment.umbmark) is not None:
        summary = msgspec.structs.replace(summary, umbmark=squares(out, runs, asked))
    (out / "batch.csv").write_text(table(runs))
    (out / "summary.json").write_bytes(to_json(summary))
    (out / "junit.xml").write_text(to_junit(scene.name, summary, runs))
    drawn = {row.name: _drawn(batch, row, runs) for row in batch.rows}
    page = HtmlReport(
        scene=scene,
        floor=batch.floor,
        summary=summary,
        runs=runs,
        drawn=drawn,
        drift={row.name: _drift(batch, row) for row in batch.rows},
        origin=_origin(batch, scene),
        timelines={**{row.name: _doors(batch, row) for row in batch.rows}, **(timelines or {})},
    )
    (out / "report.html").write_text(render(page))
    return summary


def show(summary: Summary, console: Console, experiment: Experiment | None = None) -> None:
    """Print a batch: tables on a terminal, plain lines elsewhere.

    Args:
        summary: The batch.
        console: Where to.
        experiment: Of a batch with several factors: a terminal shows its grid too.
    """
    if not console.is_terminal:
        for line in summary.lines:
            low, high = line.interval
            console.file.write(
                f"row name={line.name} runs={line.runs} succeeded={line.succeeded} low={low:.3f} high={high:.3f} "
                f"reached={line.reached} collided={line.collided} physical={line.physical} virtual={line.virtual} "
                f"died={len(line.died)}\n"
            )
        for one in summary.comparisons:
            words = f"compare first={one.first} second={one.second or '-'} expect={one.expect or '-'}"
            if one.paired is not None:
                words += f" difference={one.paired.difference:+.3f} p={one.paired.p:.4f}"
                words += f" equivalent={'yes' if one.paired.equivalent else 'no'}"
            console.file.write(f"{words} found={one.verdict.replace(' ', '-')}\n")
        for name, figure in _figures(summary.umbmark):
            error = "-" if figure.error is None else f"{figure.error:.5f}"
            console.file.write(f"umbmark figure={name} true={figure.true:.4f} found={figure.found:.4f} error={error}\n")
        console.file.flush()
        return
    shown = Table("row", "runs", "succeeded", "95 %", "collided", "physical", "virtual", "time", "odometry error")
    for line in summary.lines:
        low, high = line.interval
        cells = [
            markup.escape(line.title),
            str(line.runs),
            str(line.succeeded),
            f"{100 * low:.0f} to {100 * high:.0f} %",
        ]
        cells += [str(line.collided), str(line.physical), str(line.virtual)]
        for name, form in (("time", "{:.1f} s"), ("odometry_error", "{:.3f} m")):
            cells.append(form.format(line.spread[name].median) if name in line.spread else "-")
        shown.add_row(*cells)
    console.print(shown)
    _show_sweep(summary, console, experiment)
    for one in summary.comparisons:
        against = f" against {one.second}" if one.second else ""
        console.print(
            f"{one.first}{against}: expected {one.expect or 'nothing'}, found: {one.verdict}", highlight=False
        )
    for name, figure in _figures(summary.umbmark):
        error = "" if figure.error is None else f" +- {figure.error:.4f}"
        console.print(f"UMBmark {name}: truly {figure.true:.4f}, found {figure.found:.4f}{error}", highlight=False)


def _show_sweep(summary: Summary, console: Console, experiment: Experiment | None) -> None:
    found = sweep(experiment, summary.lines)
    if found is None:
        return
    across = " and ".join(title.lower() for title in found.across)
    heads = (*found.down, *("\n".join(column) for column in found.columns))
    shown = Table(*map(markup.escape, heads), title=markup.escape(f"Succeeded, by {across}"))
    for levels, cells in found.rows:
        shown.add_row(
            *map(markup.escape, levels), *(f"{line.succeeded} / {line.runs}" if line else "" for line in cells)
        )
    console.print(shown)


def _figures(found: Squares | None) -> tuple[tuple[str, Figure], ...]:
    return () if found is None else (("E_d", found.wheels), ("E_b", found.base))


def _claim(batch: Batch, scene: Scene) -> None:
    """Make the folder this batch's."""
    about = About(scene=scene, floor=floor_hash(batch.floor))
    path = batch.out / ABOUT
    batch.out.mkdir(parents=True, exist_ok=True)
    text = msgspec.json.format(msgspec.json.encode(about), indent=2) + b"\n"
    if path.exists():
        if path.read_bytes() != text:
            raise OtherBatchError(f"{batch.out}: expected an empty folder or one of this scene, got another batch's")
        return
    path.write_bytes(text)


def _bar(console: Console) -> Progress:
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    return Progress(*columns, TimeRemainingColumn(), console=console, disable=not console.is_terminal)


def _drawn(batch: Batch, row: Row, runs: Sequence[StoredRun]) -> list[Drawn]:
    found = []
    for run in runs:
        place = place_of(batch.out, run.row, run.seed)
        true = read_tum(place / "true.tum") if run.row == row.name and run.measured else None
        if true is None or run.measured is None:
            continue
        lines = np.loadtxt(place / "along.csv", delimiter=",", skiprows=1, usecols=(1, 2), ndmin=2)
        hits = [line.split(",") for line in (place / "contacts.csv").read_text().splitlines()[1:]]
        found.append(
            Drawn(
                seed=run.seed,
                success=run.measured.success,
                true=true,
                reported=read_tum(place / "reported.tum"),
                clearance=lines[:, 0],
                speed=lines[:, 1],
                contacts=[(float(hit[3]), float(hit[4])) for hit in hits],
            )
        )
    return found


def _doors(batch: Batch, row: Row) -> list[tuple[str, str]]:
    """Return the timeline of the doors of a row, in the first of its runs that has them."""
    doors = [cast.name for cast in row.scene.cast if cast.mind == "door"]
    for seed in batch.seeds:
        place = place_of(batch.out, row.name, seed)
        path, true = place / "bodies.csv", read_tum(place / "true.tum")
        if not doors or true is None or not path.exists():
            continue
        values = np.atleast_1d(np.genfromtxt(path, delimiter=",", names=True))
        series = []
        for door in doors:
            if f"{door}_heading" in (values.dtype.names or ()):
                turned = np.degrees(np.unwrap(values[f"{door}_heading"]) - values[f"{door}_heading"][0])
                series.append((f"{door}: leaf (deg)", values["time"], np.abs(turned)))
                off = np.hypot(true[:, 1] - values[f"{door}_x"], true[:, 2] - values[f"{door}_y"])
                series.append((f"{batch.subject} to the hinge of {door} (0.1 m)", true[:, 0], 10.0 * off))
        if series:
            return [(f"Door over time, seed {seed}", timeline(series, "deg, 0.1 m"))]
    return []


def _drift(batch: Batch, row: Row) -> tuple[float, float]:
    """Return the variance of a row's wheels and its track, from the first of its logs."""
    for seed in batch.seeds:
        robot = _robot(place_of(batch.out, row.name, seed) / "robot.json")
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
    told = f"{seeds[0]} to {seeds[-1]} ({len(seeds)})" if len(seeds) > 1 else seeds[0]
    found = {"scene": batch.source, "floor": f"{batch.floor.name} {floor_hash(batch.floor)}"}
    if batch.floor.source:
        found["floor from"] = batch.floor.source
    found |= {"seeds": told, "period": f"{scene.period:g} s", "pace": "lockstep, strict"}
    found |= versions()
    found["processor"] = f"{_processor()}, {os.cpu_count()} cores, {platform.system()} {platform.machine()}"
    found["command"] = shlex.join(["iw-run", *sys.argv[1:]])
    return found


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor() or "unknown"
    return next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), "unknown")
