"""Runs a batch: every row of an experiment with every seed, several at a time. Finished runs are not repeated.

Each thread takes some seeds of a row, starts one worker and runs the seeds on it one after the other. A run that dies
takes its worker with it. It is stored with the reason, and a new worker runs the remaining seeds.
"""

from __future__ import annotations

import shutil
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from intellwheels_experiments.batch.batch_parts import WHOLE, Part
from intellwheels_experiments.batch.experiment_rows import Row
from intellwheels_experiments.batch.run_measures import measure_run
from intellwheels_experiments.batch.run_store import LOG, StoredRun, finished_run, load_run, store_run
from intellwheels_experiments.batch.run_worker import RunWorker, RunWorkerError, StoppedError, WorkerSettings
from intellwheels_experiments.batch.scratch_folders import scratch_folder
from intellwheels_experiments.batch.seed_variation import drawn, varied_floor, varied_row, write_scene
from intellwheels_experiments.batch.trace_reader import read_trace
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Map

SEEDS_PER_WORKER: Final = 10
"""Seeds of a row that one worker runs: few enough that all threads finish at about the same time."""


@dataclass(frozen=True, kw_only=True)
class Batch:
    """The runs to make.

    Attributes:
        rows: The rows.
        seeds: The seeds that each row runs with.
        subject: The agent that is measured.
        floor: The map.
        source: The scene's name or path, as the simulator gets it.
        folder: Where relative paths in the scene start; None for an included scene.
        out: The batch's folder.
        jobs: Number of workers at a time.
        timeout: Seconds of wall time that a run may take.
        say: Tells people why a simulator is not ready yet.
        part: The share of the runs that is made here.
        cluster: The address of the Dask scheduler whose workers make the runs; None to make them on this machine.
    """

    rows: tuple[Row, ...]
    seeds: tuple[str, ...]
    subject: str
    floor: Map
    source: str
    folder: Path | None
    out: Path
    jobs: int
    timeout: float
    say: Callable[[str], None] = lambda _: None
    part: Part = WHOLE
    cluster: str | None = None


def runs_of_part(batch: Batch) -> list[tuple[Row, tuple[str, ...]]]:
    """Return the runs of the batch's part: each row with its seeds."""
    found = []
    for number, row in enumerate(batch.rows):
        first = number * len(batch.seeds)
        seeds = tuple(seed for index, seed in enumerate(batch.seeds, first) if batch.part.holds(index))
        if seeds:
            found.append((row, seeds))
    return found


def pending_runs(batch: Batch) -> list[tuple[Row, tuple[str, ...]]]:
    """Return the runs that still have to be made, as rows with the seeds for one worker each."""
    pending = []
    for row, mine in runs_of_part(batch):
        seeds = [seed for seed in mine if finished_run(batch.out, row.name, seed) is None]
        # A seed that varies options or the map needs agents and a simulator of its own.
        share = 1 if row.uniform else SEEDS_PER_WORKER
        pending += [(row, tuple(seeds[i : i + share])) for i in range(0, len(seeds), share)]
    return pending


def run_batch(batch: Batch, on_run: Callable[[StoredRun], None], stop: threading.Event) -> None:
    """Make the runs that are still pending, and store them.

    Args:
        batch: The batch.
        on_run: Called with each run that finished or died, on the thread that made it.
        stop: Set from outside to abort. Finished runs stay.

    Raises:
        Exception: What went wrong other than a run that died, such as a full disk. It is raised when all threads have
            ended.
    """
    pending = deque(pending_runs(batch))
    failures: list[BaseException] = []

    def work() -> None:
        try:
            while not stop.is_set() and not failures:
                try:
                    row, seeds = pending.popleft()
                except IndexError:
                    return
                run_seeds(batch, row, seeds, on_run, stop)
        except StoppedError:
            return
        except BaseException as error:
            failures.append(error)

    threads = [threading.Thread(target=work, name=f"worker-{number}") for number in range(batch.jobs)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    if failures:
        raise failures[0]


def run_seeds(
    batch: Batch, row: Row, seeds: Sequence[str], on_run: Callable[[StoredRun], None], stop: threading.Event
) -> None:
    """Run seeds of a row one after the other and store the runs.

    Args:
        batch: The batch. Where runs are stored, and what they need.
        row: The row.
        seeds: The seeds; one only if the row varies something by seed.
        on_run: Called with each run that finished or died.
        stop: Set from outside to abort.

    Raises:
        StoppedError: `stop` was set.
    """
    remaining = deque(seeds)
    while remaining:
        with scratch_folder(batch.out, "worker") as scratch:
            settings = WorkerSettings(
                source=batch.source, folder=batch.folder, logs=scratch, runs=scratch / "runs", timeout=batch.timeout,
                say=batch.say,
            )  # fmt: skip
            try:
                if row.uniform:
                    batch, row, settings = _varied(batch, row, settings, remaining[0])
                with RunWorker(settings, row, stop) as worker:
                    while remaining:
                        _run_seed(batch, row, worker, remaining[0], on_run)
                        remaining.popleft()
            except (RunWorkerError, WireError) as error:
                # A map may be valid at both ends of its ranges and not between them.
                seed = remaining.popleft()
                run = StoredRun(row=row.name, seed=seed, died=str(error), drawn=drawn(row, seed))
                store_run(batch.out, run)
                on_run(run)


def _varied(batch: Batch, row: Row, settings: WorkerSettings, seed: str) -> tuple[Batch, Row, WorkerSettings]:
    """Return what one seed runs with. Its scene and its map are files in the worker's folder."""
    floor = varied_floor(batch.floor, row, seed)
    source, row = write_scene(settings.logs, varied_row(row, seed), seed, floor)
    return replace(batch, floor=floor), row, replace(settings, source=str(source.absolute()))


def _run_seed(batch: Batch, row: Row, worker: RunWorker, seed: str, on_run: Callable[[StoredRun], None]) -> None:
    begun = time.monotonic()
    folders = worker.run(seed)
    truth, mirror = folders
    try:
        trace = read_trace(truth / "trace.jsonl", truth / LOG)
        mirrored = None if mirror is None else read_trace(mirror / "trace.jsonl", mirror / LOG)
    except (OSError, WireError) as error:
        raise RunWorkerError(f"the simulator's files of the run cannot be read: {error}") from error
    numbers, series = measure_run(trace, row.scene, batch.floor, batch.subject, real=row.real, mirror=mirrored)
    run = StoredRun(row=row.name, seed=seed, measured=numbers, wall=time.monotonic() - begun, drawn=drawn(row, seed))
    store_run(batch.out, run, series, truth / LOG, None if mirror is None else mirror / LOG)
    for folder in folders:
        if folder is not None:
            shutil.rmtree(folder, ignore_errors=True)
    on_run(run)


def read_batch(batch: Batch) -> list[StoredRun]:
    """Return every run of a batch, by row and then by seed. Those that were not made have nothing but these two."""
    return [
        load_run(batch.out, row.name, seed) or StoredRun(row=row.name, seed=seed)
        for row in batch.rows
        for seed in batch.seeds
    ]
