"""What if: a run that begins as another went and goes on with another mind or option, the two side by side in a report.

A row with a laboratory has two logs, and both of its worlds begin as they went. The minds of the branch live through
all of it, and until the branch they are not obeyed: so they have their memory of it. An option that differs acts from
the first tick within a mind, and on the world from the branch on.
"""

from __future__ import annotations

import dataclasses
import shutil
import subprocess
import sys
import tempfile
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import msgspec

from intellwheels_experiments.batch.batch_command import write_files
from intellwheels_experiments.batch.experiment_rows import Row
from intellwheels_experiments.batch.run_batch import Batch
from intellwheels_experiments.batch.run_measures import measured
from intellwheels_experiments.batch.run_store import IMAGE, LOG, StoredRun, keep
from intellwheels_experiments.batch.run_worker import Branch, RunWorker, RunWorkerError, Site, StoppedError
from intellwheels_experiments.batch.summary import Summary
from intellwheels_experiments.batch.trace_reader import Trace, read_trace
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Cast, Experiment, Option, Scene, Varied
from intellwheels_schemas.messages import Compare as Asked

PARENT: Final = "parent"
BRANCH: Final = "branch"
LIMIT: Final = 300.0
"""Seconds for a log to be run again."""


class ParentError(RuntimeError):
    """A log cannot be branched from; the text says why."""


def changed(row: Row, minds: Sequence[str], options: Sequence[str]) -> Row:
    """Return a row with other minds and options.

    Args:
        row: The row.
        minds: `AGENT=MIND` each.
        options: `AGENT.NAME=VALUE` each.

    Raises:
        WireError: One has another form, names nobody of the cast, or a field of a robot.
    """
    cast = {one.name: one for one in row.scene.cast}
    for text in minds:
        agent, equals, mind = text.partition("=")
        _check(agent in cast and bool(equals and mind), "--mind", "AGENT=MIND", cast, text)
        # What the old mind was told is not for the new one; the body's fields stay.
        kept = tuple(option for option in cast[agent].option if option.name[0].isupper())
        cast[agent] = msgspec.structs.replace(cast[agent], mind=mind, option=kept)
    for text in options:
        name, equals, value = text.partition("=")
        agent, dot, option = name.partition(".")
        fits = agent in cast and bool(equals and dot and option) and not option[:1].isupper()
        _check(fits, "--option", "AGENT.NAME=VALUE of a mind", cast, text)
        kept = tuple(one for one in cast[agent].option if one.name != option)
        cast[agent] = msgspec.structs.replace(cast[agent], option=(*kept, Option(name=option, value=value)))
    return dataclasses.replace(row, scene=msgspec.structs.replace(row.scene, cast=tuple(cast.values())))


def perform_branch(batch: Batch, scene: Scene, other: Row, log: Path, at: int, stop: threading.Event) -> Summary:
    """Run a branch and write the report of it and its parent.

    Args:
        batch: Its first row is the parent's; its folder takes the files.
        scene: The scene.
        other: The row of the branch.
        log: The parent's input log; of a row with a laboratory, the laboratory's, and the other's is beside it.
        at: The tick of the branch.
        stop: Set from outside to break off.

    Raises:
        ParentError: The log cannot be branched from, or the branch came to no end; in words.
    """
    image_log = log.with_name(IMAGE) if other.bridges else None
    if image_log is not None and not image_log.exists():
        raise ParentError(f"{image_log}: expected the log of the world that showed the chair, beside the laboratory's")
    batch.out.mkdir(parents=True, exist_ok=True)
    scratch = Path(tempfile.mkdtemp(prefix=".branch-", dir=batch.out))
    try:
        parent = _again(log, scratch / "parent.jsonl")
        image = None if image_log is None else _again(image_log, scratch / "image.jsonl")
        site = Site(
            source=batch.source, folder=batch.folder, logs=scratch, runs=scratch / "runs", timeout=batch.timeout,
            branch=Branch(log=log, at=at, image=image_log),
        )  # fmt: skip
        with RunWorker(site, other, stop) as stand:
            place, shown = stand.run(parent.heading.seed)
        branch = read_trace(place / "trace.jsonl", place / LOG)
        _check_same(parent, branch, at)
        seen = None if shown is None else read_trace(shown / "trace.jsonl", shown / LOG)
        if image is not None and seen is not None:
            _check_same(image, seen, at)
        seed = parent.heading.seed
        row = batch.rows[0]
        image_of = {PARENT: image, BRANCH: seen}
        log_of = {PARENT: image_log, BRANCH: None if shown is None else shown / LOG}
        for name, trace, source in ((PARENT, parent, log), (BRANCH, branch, place / LOG)):
            numbers, course = measured(trace, scene, batch.floor, batch.subject, real=row.real, image=image_of[name])
            keep(batch.out, StoredRun(row=name, seed=seed, measured=numbers), course, source, log_of[name])
    except (RunWorkerError, WireError) as error:
        raise ParentError(str(error)) from error
    except StoppedError:
        raise ParentError("broken off") from None
    finally:
        shutil.rmtree(scratch, ignore_errors=True)
    rows = (
        dataclasses.replace(row, name=PARENT, title=f"{row.title}: as it was"),
        dataclasses.replace(other, name=BRANCH, title=f"{row.title}: {_told(row, other)} from tick {at} on"),
    )
    both = dataclasses.replace(batch, rows=rows, seeds=(seed,))
    pair = Experiment(
        subject=batch.subject, factor=(Varied(name="run"),), compare=(Asked(first=BRANCH, second=PARENT),)
    )
    return write_files(both, msgspec.structs.replace(scene, experiment=pair))


def _again(log: Path, target: Path) -> Trace:
    """Return what was true in a log's world, by running it again."""
    command = [sys.executable, "-m", "intellwheels_server", "--resimulate", str(log), "--trace", str(target)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT, check=False)
    except subprocess.TimeoutExpired as error:
        raise ParentError(f"{log}: running it again took more than {LIMIT:g} s") from error
    if done.returncode != 0:
        raise ParentError(done.stderr.strip() or f"exit {done.returncode}")
    try:
        return read_trace(target, log)
    except (OSError, WireError) as error:
        raise ParentError(f"{log}: {error}") from error


def _check_same(parent: Trace, branch: Trace, at: int) -> None:
    """Raise where a branch is not its parent up to its tick; the simulator has ended it then already."""
    hashes = {moment.tick: moment.hash for moment in parent.moments}
    for moment in branch.moments:
        if moment.tick <= at and hashes.get(moment.tick, moment.hash) != moment.hash:
            raise ParentError(f"tick {moment.tick}: the branch is not as its parent was")


def _told(row: Row, other: Row) -> str:
    old = {cast.name: cast for cast in row.scene.cast}
    return (
        ", ".join(_difference(old[cast.name], cast) for cast in other.scene.cast if cast != old[cast.name]) or "again"
    )


def _difference(old: Cast, new: Cast) -> str:
    words = [f"{new.name} with {new.mind}"] if new.mind != old.mind else []
    words += [f"{new.name}.{one.name}={one.value}" for one in new.option if one not in old.option]
    return ", ".join(words)


def _check(fits: bool, option: str, expected: str, cast: dict[str, Cast], got: str) -> None:
    if not fits:
        raise WireError("value", f"{option}: expected {expected}, AGENT of {', '.join(cast)}, got {got!r}", option)
