"""What-if: repeats a recorded run up to a tick, continues with another mind or option, and reports both side by side.

A row with a laboratory has two logs, and both of its worlds repeat their log. The minds of the branch run from the
first tick on, so that they remember it. Until the branch tick, however, the world follows the log and not the minds. So
a changed option affects a mind from the first tick on, and the world from the branch tick on.
"""

from __future__ import annotations

import dataclasses
import threading
from pathlib import Path
from typing import Final

import msgspec

from intellwheels_experiments.batch.batch_command import write_files
from intellwheels_experiments.batch.experiment_rows import Row
from intellwheels_experiments.batch.run_batch import Batch
from intellwheels_experiments.batch.run_measures import measure_run
from intellwheels_experiments.batch.run_store import LOG, MIRROR_LOG, StoredRun, store_run
from intellwheels_experiments.batch.run_worker import Branch, RunWorker, RunWorkerError, StoppedError, WorkerSettings
from intellwheels_experiments.batch.scratch_folders import delete_abandoned, scratch_folder
from intellwheels_experiments.batch.seed_variation import varied_floor, varied_row
from intellwheels_experiments.batch.summary import Summary
from intellwheels_experiments.batch.trace_reader import Trace, read_trace
from intellwheels_experiments.run.child_processes import ChildProcesses, WaitError
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Cast, Compare, Experiment, Scene, Varied

PARENT: Final = "parent"
"""The report's row of the recorded run."""
BRANCH: Final = "branch"
"""The report's row of the changed run."""
LIMIT: Final = 300.0
"""Seconds to resimulate a log."""


class BranchError(RuntimeError):
    """A run cannot be branched; the text says why."""


def perform_branch(batch: Batch, scene: Scene, changed: Row, log: Path, at: int, stop: threading.Event) -> Summary:
    """Run a branch, write the report of it and its parent, and return the summary of both.

    Args:
        batch: Its first row is the row of the parent; its folder takes the files.
        scene: The scene.
        changed: The row of the branch.
        log: The parent's input log. For a row with a laboratory this is the laboratory's log, with the log of the
            mirror beside it.
        at: The branch tick.
        stop: Set from outside to abort.

    Raises:
        BranchError: The run cannot be branched, or the branch did not reach its end.
    """
    mirror_log = log.with_name(MIRROR_LOG) if changed.bridges else None
    if mirror_log is not None and not mirror_log.exists():
        raise BranchError(f"{mirror_log}: expected the mirror world's log beside the laboratory's, got no such file")
    batch.out.mkdir(parents=True, exist_ok=True)
    delete_abandoned(batch.out)
    with scratch_folder(batch.out, "branch") as scratch:
        try:
            with ChildProcesses(scratch) as children:
                parent = _resimulate(log, scratch / "parent.jsonl", children)
                parent_mirror = None if mirror_log is None else _resimulate(mirror_log, scratch / MIRROR_LOG, children)
            seed = parent.heading.seed
            floor, changed = varied_floor(batch.floor, changed, seed), varied_row(changed, seed)
            settings = WorkerSettings(
                source=batch.source, folder=batch.folder, logs=scratch, runs=scratch / "runs", timeout=batch.timeout,
                branch=Branch(log=log, at=at, mirror=mirror_log), say=batch.say,
            )  # fmt: skip
            with RunWorker(settings, changed, stop) as worker:
                truth, mirror = worker.run(seed)
            branch = read_trace(truth / "trace.jsonl", truth / LOG)
            _check_same(parent, branch, at)
            branch_mirror = None if mirror is None else read_trace(mirror / "trace.jsonl", mirror / LOG)
            if parent_mirror is not None and branch_mirror is not None:
                _check_same(parent_mirror, branch_mirror, at)
            row = batch.rows[0]
            for name, trace, trace_log, mirrored, mirrored_log in (
                (PARENT, parent, log, parent_mirror, mirror_log),
                (BRANCH, branch, truth / LOG, branch_mirror, None if mirror is None else mirror / LOG),
            ):
                numbers, series = measure_run(trace, scene, floor, batch.subject, real=row.real, mirror=mirrored)
                store_run(batch.out, StoredRun(row=name, seed=seed, measured=numbers), series, trace_log, mirrored_log)
        except (RunWorkerError, WireError) as error:
            raise BranchError(str(error)) from error
        except StoppedError:
            raise BranchError("interrupted") from None
    rows = (
        dataclasses.replace(row, name=PARENT, title=f"{row.title}: as recorded"),
        dataclasses.replace(changed, name=BRANCH, title=f"{row.title}: {_changes(row, changed)} from tick {at} on"),
    )
    both = dataclasses.replace(batch, rows=rows, seeds=(seed,))
    pair = Experiment(
        subject=batch.subject, factor=(Varied(name="run"),), compare=(Compare(first=BRANCH, second=PARENT),)
    )
    return write_files(both, msgspec.structs.replace(scene, experiment=pair))


def _resimulate(log: Path, target: Path, children: ChildProcesses) -> Trace:
    """Return the trace of a log, by running it again."""
    child = children.start(
        f"resimulate-{target.stem}",
        "intellwheels_server",
        "--resimulate",
        str(log),
        "--trace",
        str(target),
        "--overwrite",
    )
    try:
        code = children.exit(child, LIMIT)
    except WaitError as error:
        raise BranchError(f"{log}: resimulation took more than {LIMIT:g} s") from error
    if code != 0:
        raise BranchError("\n".join(children.tail(child)) or f"{log}: resimulation failed, exit {code}")
    try:
        return read_trace(target, log)
    except (OSError, WireError) as error:
        raise BranchError(f"{log}: {error}") from error


def _check_same(parent: Trace, branch: Trace, at: int) -> None:
    """Raise if a branch differs from its parent before the branch tick. The simulator should have ended it already."""
    hashes = {moment.tick: moment.hash for moment in parent.moments}
    for moment in branch.moments:
        if moment.tick <= at and hashes.get(moment.tick, moment.hash) != moment.hash:
            raise BranchError(f"tick {moment.tick}: the branch differs from its parent")


def _changes(row: Row, changed: Row) -> str:
    old = {cast.name: cast for cast in row.scene.cast}
    changes = [_change(old[cast.name], cast) for cast in changed.scene.cast if cast != old[cast.name]]
    return ", ".join(changes) or "repeated"


def _change(old: Cast, new: Cast) -> str:
    changes = [f"{new.name} with {_program(new)}"] if _program(new) != _program(old) else []
    changes += [f"{new.name}.{option.name}={option.value}" for option in new.option if option not in old.option]
    return ", ".join(changes)


def _program(cast: Cast) -> str:
    return cast.command or cast.mind
