"""Makes the runs of a batch on the workers of a Dask cluster.

    iw-run SCENE --seeds 400 --cluster tcp://head:8786

A task is some seeds of a row, as one local worker would run them. It makes its runs in a folder of the worker's machine
and returns their files as an archive. The files are stored in the batch's folder as soon as they arrive, so a batch
whose scheduler was lost resumes from them.

Dask repeats the task of a killed worker on another one. If several workers die of the same task, Dask gives it up. Its
seeds are then sent one by one, and the seed that still kills workers is stored as a run that died.
"""

from __future__ import annotations

import hashlib
import io
import math
import queue
import shlex
import tarfile
import tempfile
import threading
import time
import uuid
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from intellwheels_experiments.batch.cluster_client import CONNECT_LIMIT, ClusterError, connect, lost, reach, slots
from intellwheels_experiments.batch.collect_runs import collect_runs
from intellwheels_experiments.batch.experiment_rows import Row
from intellwheels_experiments.batch.run_batch import Batch, pending_runs, run_seeds
from intellwheels_experiments.batch.run_store import StoredRun, load_run, store_run
from intellwheels_experiments.batch.run_worker import StoppedError
from intellwheels_experiments.batch.scratch_folders import scratch_folder
from intellwheels_experiments.batch.seed_variation import drawn
from intellwheels_schemas.errors import WireError

if TYPE_CHECKING:
    from distributed import Client, Future

RESULT_LIMIT: Final = 120.0
"""Seconds for a worker to hand over the files of its runs."""
AHEAD: Final = 2
"""Tasks that are sent for each run that the cluster can make at a time. More would only fill the scheduler's memory."""
INTERVAL: Final = 0.2
"""Seconds between two checks whether the batch was stopped, or a task given up."""


@dataclass(frozen=True, kw_only=True)
class Task:
    """Seeds of a row, for one worker.

    Attributes:
        batch: The batch. Its folder is that of the machine that started it.
        row: The row.
        seeds: The seeds.
        version: The version of IntellWheels that sent the task.
        files: What `batch_files` returned where the batch was started.
    """

    batch: Batch
    row: Row
    seeds: tuple[str, ...]
    version: str
    files: dict[str, str]


def run_on_cluster(batch: Batch, address: str, on_run: Callable[[StoredRun], None], stop: threading.Event) -> None:
    """Make the runs of a batch that are still pending on a cluster, and store them.

    Args:
        batch: The batch.
        address: The address of the scheduler.
        on_run: Called with each run that finished or died.
        stop: Set from outside to abort. Finished runs stay.

    Raises:
        WireError: No scheduler answers, or a worker has another version or other files.
        ClusterError: The scheduler was lost, or a worker failed for a reason other than a run.
        OSError: A file cannot be written here.
    """
    with connect(address) as client:
        batch.say(_await_workers(client, address, batch, stop))
        if not stop.is_set():
            _Distribution(client, address, batch, on_run, stop).perform()


class _Distribution:
    """The tasks of a batch, and who has them."""

    def __init__(
        self, client: Client, address: str, batch: Batch, on_run: Callable[[StoredRun], None], stop: threading.Event
    ) -> None:
        self._client = client
        self._address = address
        self._batch = batch
        self._on_run = on_run
        self._stop = stop
        self._files = batch_files(batch)
        self._waiting: deque[tuple[Row, tuple[str, ...]]] = deque()
        self._sent: dict[str, tuple[Future[Any], Row, tuple[str, ...]]] = {}
        self._ended: queue.SimpleQueue[str] = queue.SimpleQueue()

    def perform(self) -> None:
        self._waiting.extend(_shares(pending_runs(self._batch), slots(self._client, self._address)))
        try:
            while (self._waiting or self._sent) and not self._stop.is_set():
                self._send()
                with suppress(queue.Empty):
                    self._take(self._ended.get(timeout=INTERVAL))
                if self._client.status not in ("running", "newly-connected"):
                    raise lost(self._address)
        finally:
            with suppress(Exception):
                self._client.cancel([future for future, _, _ in self._sent.values()], force=True)

    def _send(self) -> None:
        room = AHEAD * max(1, slots(self._client, self._address))
        while self._waiting and len(self._sent) < room:
            row, seeds = self._waiting.popleft()
            task = Task(
                batch=_portable(self._batch), row=row, seeds=seeds, version=version("intellwheels"), files=self._files
            )  # fmt: skip
            key = f"intellwheels-{row.name}-{seeds[0]}-{uuid.uuid4().hex}"
            with reach(self._address):
                future = self._client.submit(make_runs, task, key=key, pure=False)
            self._sent[key] = (future, row, seeds)
            future.add_done_callback(lambda ended: self._ended.put(ended.key))

    def _take(self, key: str) -> None:
        """Store what a task returned, or send its seeds one by one if workers die of it."""
        from distributed import KilledWorker  # noqa: PLC0415

        future, row, seeds = self._sent.pop(key)
        if future.status in ("cancelled", "lost"):
            raise lost(self._address)
        with reach(self._address):
            error = future.exception() if future.status == "error" else None
        if isinstance(error, KilledWorker):
            if len(seeds) > 1:
                self._waiting.extendleft((row, (seed,)) for seed in reversed(seeds))
                return
            died = f"every worker that ran it was killed, last {error.last_worker.address}"
            run = StoredRun(row=row.name, seed=seeds[0], died=died, drawn=drawn(row, seeds[0]))
            store_run(self._batch.out, run)
            self._on_run(run)
            return
        if error is not None:
            raise ClusterError(f"a worker of {self._address} failed: {type(error).__name__}: {error}") from error
        with reach(self._address):
            try:
                archive = future.result(timeout=RESULT_LIMIT)
            except TimeoutError as late:
                text = f"a worker of {self._address} did not hand over its runs within {RESULT_LIMIT:g} s"
                raise ClusterError(text) from late
        for run in _unpack(archive, self._batch.out, row, seeds):
            self._on_run(run)
        future.release()


def make_runs(task: Task) -> bytes:
    """Make the runs of a task in a folder of this machine, and return their files. It runs on a worker.

    Returns:
        A compressed tar archive of `runs/ROW/SEED`.

    Raises:
        RuntimeError: This worker has another version of IntellWheels or other files, or the task was given up.
    """
    # This worker may have come after the others were asked.
    if lacks := inspect_worker(task.files, task.version):
        raise RuntimeError(lacks)
    with _watched() as (folder, stop), tempfile.TemporaryDirectory(dir=folder, prefix="iw-batch-") as out:
        batch = replace(task.batch, out=Path(out))
        try:
            run_seeds(batch, task.row, task.seeds, _ignore_run, stop)
        except StoppedError as error:
            raise RuntimeError("the task was given up") from error
        archive = io.BytesIO()
        with tarfile.open(fileobj=archive, mode="w:gz", compresslevel=1) as file:
            file.add(Path(out) / "runs", "runs")
        return archive.getvalue()


def inspect_worker(files: dict[str, str], expected: str) -> str:
    """Return what this worker lacks for a batch, or an empty text. It runs on a worker.

    Args:
        files: The files that the batch reads, with their SHA-256 in hexadecimal digits.
        expected: The version of IntellWheels that it must have.
    """
    if (own := version("intellwheels")) != expected:
        return f"expected version {expected} of IntellWheels, got {own}"
    for name, digest in files.items():
        path = Path(name)
        if not path.is_file():
            return f"expected the file {name} as on this machine (share its folder), got none"
        if hashlib.sha256(path.read_bytes()).hexdigest() != digest:
            return f"expected the file {name} as on this machine (share its folder), got another one"
    return ""


def _await_workers(client: Client, address: str, batch: Batch, stop: threading.Event) -> str:
    """Wait until the cluster has a worker, check all that it has, and return a line about them.

    Raises:
        WireError: A worker cannot make the runs.
        ClusterError: The scheduler was lost.
    """
    said = False
    while not slots(client, address):
        if client.status not in ("running", "newly-connected"):
            raise lost(address)
        if not said:
            batch.say(f"waiting for a worker of {address}; start one with: dask worker {address} --nthreads 1")
            said = True
        if stop.wait(INTERVAL):
            return ""
    asked = _ask_workers(client, batch, stop)
    for worker, answer in sorted(asked.items()):
        if isinstance(answer, ModuleNotFoundError):
            answer = f"expected IntellWheels with the extra cluster, got none ({answer})"  # noqa: PLW2901
        if answer:
            raise WireError("value", f"--cluster: worker {worker}: {answer}", "--cluster")
    with reach(address):
        threads = client.nthreads()
    noun = "worker" if len(threads) == 1 else "workers"
    return f"cluster {address}: {len(threads)} {noun}, {sum(threads.values())} runs at a time"


def _ask_workers(client: Client, batch: Batch, stop: threading.Event) -> dict[str, Any]:
    """Return what each worker lacks, or the exception that asking it raised; nothing if `stop` was set.

    Raises:
        WireError: A worker does not answer.
    """
    answers: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()
    files, own = batch_files(batch), version("intellwheels")

    def ask() -> None:
        with suppress(Exception):  # the client is closed meanwhile
            answers.put(client.run(inspect_worker, files, own, on_error="return"))

    # In a thread, since Dask waits for a frozen worker without end.
    threading.Thread(target=ask, name="ask-workers", daemon=True).start()
    deadline = time.monotonic() + CONNECT_LIMIT
    while time.monotonic() < deadline and not stop.is_set():
        with suppress(queue.Empty):
            return answers.get(timeout=INTERVAL)
    if stop.is_set():
        return {}
    text = f"--cluster: expected an answer of each worker within {CONNECT_LIMIT:g} s, got none of at least one"
    raise WireError("value", text, "--cluster")


def batch_files(batch: Batch) -> dict[str, str]:
    """Return the files outside the installation that a batch reads, with their SHA-256 in hexadecimal digits.

    These are the scene and what its members name: minds, robots, maps, and words of commands.
    """
    named = [batch.source]
    for row in batch.rows:
        named.append(row.scene.map)
        for cast in row.scene.cast:
            named += [cast.robot or "", cast.mind or "", *_words(cast.command)]
    beside = batch.folder or Path()
    found = {}
    for text in filter(None, named):
        path = (beside / text).absolute()
        if path.is_file():
            found[str(path)] = hashlib.sha256(path.read_bytes()).hexdigest()
    return found


def _words(command: str | None) -> list[str]:
    try:
        return shlex.split(command or "")
    except ValueError:
        return []


def _shares(pending: Iterable[tuple[Row, tuple[str, ...]]], slots: int) -> Iterator[tuple[Row, tuple[str, ...]]]:
    """Yield pending runs in shares small enough that every thread of the cluster gets some.

    A larger share costs less, since its seeds share a simulator.
    """
    pending = list(pending)
    runs = sum(len(seeds) for _, seeds in pending)
    most = math.ceil(runs / max(1, slots)) or 1
    for row, seeds in pending:
        for first in range(0, len(seeds), most):
            yield row, seeds[first : first + most]


def _portable(batch: Batch) -> Batch:
    """Return the batch without what only this process can call."""
    return replace(batch, say=_ignore_text, rows=())


def _unpack(archive: bytes, out: Path, row: Row, seeds: Sequence[str]) -> list[StoredRun]:
    """Store the files of a task and return its runs."""
    with scratch_folder(out, "merge") as scratch:
        with tarfile.open(fileobj=io.BytesIO(archive), mode="r:gz") as file:
            file.extractall(scratch, filter="data")
        collect_runs(out, [scratch], [row.name], seeds)
    runs = [load_run(out, row.name, seed) for seed in seeds]
    return [run for run in runs if run is not None]


@contextmanager
def _watched() -> Iterator[tuple[str | None, threading.Event]]:
    """Yield the folder of the worker, and an event that is set when the scheduler gives the task up.

    It does so when the batch is stopped, or its process is gone.
    """
    from distributed import get_worker  # noqa: PLC0415

    stop, done = threading.Event(), threading.Event()
    try:
        worker = get_worker()
    except ValueError:  # not on a worker
        yield None, stop
        return
    key = worker.get_current_task()

    def watch() -> None:
        while not done.wait(INTERVAL):
            task = worker.state.tasks.get(key)
            if task is None or task.state == "cancelled":
                stop.set()
                return

    thread = threading.Thread(target=watch, name="task-watch", daemon=True)
    thread.start()
    try:
        yield worker.local_directory, stop
    finally:
        done.set()
        thread.join()


def _ignore_run(_run: StoredRun) -> None:
    pass


def _ignore_text(_text: str) -> None:
    pass
