"""A batch: every row of an experiment with every seed, several at a time; what is done is not done again.

A worker takes a share of a row's seeds, puts up one stand and runs them one after the other. A run that dies costs its
stand, which is put up anew for the rest; the run is named in what is told.
"""

from __future__ import annotations

import shutil
import tempfile
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import msgspec

from intellwheels_experiments.batch.experiment_rows import Row
from intellwheels_experiments.batch.run_measures import measured
from intellwheels_experiments.batch.run_store import LOG, StoredRun, done, keep
from intellwheels_experiments.batch.run_worker import RunWorker, RunWorkerError, Site, StoppedError
from intellwheels_experiments.batch.trace_reader import read_trace
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Map

SHARE: Final = 10
"""Seeds of a row that a stand runs before another may take over: small enough that all workers end together."""


@dataclass(frozen=True, kw_only=True)
class Batch:
    """What is to be run.

    Attributes:
        rows: The rows.
        seeds: The seeds of each.
        subject: Whose runs they are.
        floor: The floor.
        source: The scene as the simulator is told it.
        folder: Where relative paths in it start from, or None for a shipped scene.
        out: The batch's folder.
        jobs: Stands at a time.
        timeout: Seconds of wall time a run may take.
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


def shares_of(batch: Batch) -> list[tuple[Row, tuple[str, ...]]]:
    """Return what is still to be run, in shares of a stand each."""
    shares = []
    for row in batch.rows:
        left = [seed for seed in batch.seeds if done(batch.out, row.name, seed) is None]
        shares += [(row, tuple(left[i : i + SHARE])) for i in range(0, len(left), SHARE)]
    return shares


def run_batch(batch: Batch, told: Callable[[StoredRun], None], stop: threading.Event) -> None:
    """Run what is still to be run.

    Args:
        batch: What.
        told: Called with each run that came to its end or died, on the thread that ran it.
        stop: Set from outside to break off; what is done stays.

    Raises:
        Exception: What a worker ran into that is no run's fault, once all have ended.
    """
    shares = deque(shares_of(batch))
    failures: list[BaseException] = []

    def work() -> None:
        try:
            while not stop.is_set() and not failures:
                try:
                    row, seeds = shares.popleft()
                except IndexError:
                    return
                _run_share(batch, row, seeds, told, stop)
        except StoppedError:
            return
        except BaseException as error:
            failures.append(error)

    workers = [threading.Thread(target=work, name=f"stand-{number}") for number in range(batch.jobs)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    if failures:
        raise failures[0]


def _run_share(
    batch: Batch, row: Row, seeds: Sequence[str], told: Callable[[StoredRun], None], stop: threading.Event
) -> None:
    left = deque(seeds)
    while left:
        scratch = Path(tempfile.mkdtemp(prefix=".stand-", dir=batch.out))
        site = Site(
            source=batch.source, folder=batch.folder, logs=scratch, runs=scratch / "runs", timeout=batch.timeout
        )
        try:
            with RunWorker(site, row, stop) as stand:
                while left:
                    _run_one(batch, row, stand, left[0], told)
                    left.popleft()
        except RunWorkerError as error:
            kept = StoredRun(row=row.name, seed=left.popleft(), died=str(error))
            keep(batch.out, kept)
            told(kept)
        finally:
            shutil.rmtree(scratch, ignore_errors=True)


def _run_one(batch: Batch, row: Row, stand: RunWorker, seed: str, told: Callable[[StoredRun], None]) -> None:
    begun = time.monotonic()
    place, shown = stand.run(seed)
    try:
        trace = read_trace(place / "trace.jsonl", place / LOG)
        image = None if shown is None else read_trace(shown / "trace.jsonl", shown / LOG)
    except (OSError, WireError) as error:
        raise RunWorkerError(f"the simulator's files of the run cannot be read: {error}") from error
    numbers, course = measured(trace, row.scene, batch.floor, batch.subject, real=row.real, image=image)
    kept = StoredRun(row=row.name, seed=seed, measured=numbers, wall=time.monotonic() - begun)
    keep(batch.out, kept, course, place / LOG, None if shown is None else shown / LOG)
    for each in (place, shown):
        if each is not None:
            shutil.rmtree(each, ignore_errors=True)
    told(kept)


def read_batch(batch: Batch) -> list[StoredRun]:
    """Return what came of every run in the order of rows and seeds; one that is not done or died says so."""
    found = []
    for row in batch.rows:
        for seed in batch.seeds:
            kept = done(batch.out, row.name, seed)
            if kept is None:
                path = batch.out / "runs" / row.name / seed / "result.json"
                try:
                    kept = msgspec.json.decode(path.read_bytes(), type=StoredRun)
                except (OSError, msgspec.MsgspecError):
                    kept = StoredRun(row=row.name, seed=seed, died="it was not run")
            found.append(kept)
    return found
