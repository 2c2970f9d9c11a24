"""A batch on a Dask cluster: real scheduler and workers, of which some are killed."""

from __future__ import annotations

import argparse
import dataclasses
import json
import signal
import sys
import threading
from collections.abc import Iterator
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

import msgspec
import pytest

from intellwheels_experiments.batch import cluster_batch
from intellwheels_experiments.batch.batch_options import scheduler_address
from intellwheels_experiments.batch.cluster_batch import (
    Task,
    batch_files,
    inspect_worker,
    make_runs,
)
from intellwheels_experiments.batch.cluster_client import ClusterError, connect
from intellwheels_experiments.batch.experiment_rows import Row, rows_of
from intellwheels_experiments.batch.run_batch import Batch, run_batch
from intellwheels_experiments.batch.run_store import StoredRun, load_run, runs_csv, store_run
from intellwheels_experiments.run.child_processes import ChildProcesses
from intellwheels_maps import floor, scene
from intellwheels_schemas.errors import WireError
from tests.experiments.runs import stored
from tests.experiments.scenes import write_scene

LIMIT = 240.0
STORED = Path(__file__).parents[1] / "table1" / "batch.csv"
KILLS = '''\
"""Kills the process that started it."""

import os
import signal


class Mind:
    def __init__(self, context):
        self.name = context.agent

    def decide(self, measures):
        os.kill(os.getppid(), signal.SIGKILL)
'''


def _words(words: list[str], _lifeline: int) -> list[str]:
    return words


class Cluster:
    """A scheduler and its workers, each a process that can be killed with all that belongs to it."""

    def __init__(self, children: ChildProcesses, folder: Path) -> None:
        self.children = children
        self.folder = folder
        self.address = ""
        self.start_scheduler()
        for number in range(3):
            self.start_worker(number)

    def start_scheduler(self) -> None:
        file = self.folder / "scheduler.json"
        self.launch("scheduler", "scheduler", "--port", "0", "--scheduler-file", str(file))
        self.address = self.children.wait(lambda: _address(file), "address of the scheduler", LIMIT)

    def start_worker(self, number: int) -> None:
        folder = self.folder / f"worker{number}"
        self.launch(f"worker{number}", "worker", self.address, "--nthreads", "1", "--local-directory", str(folder))

    def launch(self, name: str, kind: str, *more: str) -> None:
        # A task of which two workers have died is given up, so that the test is short; Dask itself waits for four.
        settings = "distributed.scheduler.allowed-failures=1"
        words = ["-c", _MAIN, kind, settings, "--host", "127.0.0.1", "--no-dashboard", *more]
        self.children.launch(name, partial(_words, [sys.executable, *words]))


_MAIN = """\
import sys, dask
kind, setting = sys.argv[1:3]
name, value = setting.split("=")
dask.config.set({name: int(value)})
from importlib import import_module
command = import_module(f"distributed.cli.dask_{kind}").main
command(sys.argv[3:])
"""


def _address(file: Path) -> str | None:
    try:
        return str(json.loads(file.read_text())["address"])
    except (OSError, ValueError):
        return None


@pytest.fixture
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    folder = tmp_path_factory.mktemp("cluster")
    with ChildProcesses(folder / "logs") as children:
        yield Cluster(children, folder)


def launch_batch(cluster: Cluster, scene: Path | str, out: Path, *more: str) -> str:
    name = f"batch-{out.parent.name}-{out.name}"
    words = [sys.executable, "-m", "intellwheels_experiments", str(scene), "--out", str(out), *more]
    return cluster.children.launch(name, partial(_words, words))


def results(out: Path) -> list[Path]:
    return sorted(out.glob("runs/*/*/result.json"))


def short_batch(folder: Path, out: str, seeds: int = 2, *, dies: bool = False) -> Batch:
    folder.mkdir(exist_ok=True)
    source = write_scene(folder, dies=dies)
    chosen = scene(source)
    return Batch(
        rows=rows_of(chosen), seeds=tuple(map(str, range(1, seeds + 1))), subject="chair", floor=floor(chosen.map),
        source=str(source), folder=folder, out=folder / out, jobs=2, timeout=LIMIT,
    )  # fmt: skip


@pytest.mark.process
def test_a_killed_worker_a_deadly_run_and_a_lost_scheduler_cost_no_other_run(cluster: Cluster, tmp_path: Path) -> None:
    """One test, as processes of a cluster take long to start."""
    _lack_files(cluster, tmp_path / "files")
    _lose_a_worker(cluster, tmp_path / "worker")
    _meet_a_deadly_run(cluster, tmp_path / "deadly")
    _lose_the_scheduler(cluster, tmp_path / "scheduler")


def _lose_a_worker(cluster: Cluster, folder: Path) -> None:
    both = short_batch(folder, "local")
    local = dataclasses.replace(both, rows=both.rows[:1], seeds=("2",), jobs=1)
    out = folder / "out"
    child = launch_batch(cluster, folder / "short.xml", out, "--seeds", "2", "--cluster", cluster.address)
    cluster.children.wait(lambda: results(out) or None, "a run", LIMIT, unless=child)
    cluster.children.signal("worker0", signal.SIGKILL)
    assert cluster.children.exit(child, LIMIT) == 0, cluster.children.report()
    assert list(out.glob(".*")) == []
    found = (out / "batch.csv").read_text().splitlines()
    assert len(found) == 5
    local.out.mkdir()
    run_batch(local, lambda run: None, threading.Event())
    alone = runs_csv(run for row in local.rows if (run := load_run(local.out, row.name, "2"))).splitlines()
    assert len(alone) == 2
    assert set(alone) <= set(found)


def _meet_a_deadly_run(cluster: Cluster, folder: Path) -> None:
    short_batch(folder, "local", dies=True)
    (folder / "dies.py").write_text(KILLS)
    words = ("--seeds", "1", "--row", "equal", "--cluster", cluster.address)
    child = launch_batch(cluster, folder / "short.xml", folder / "out", *words)
    assert cluster.children.exit(child, LIMIT) == 1
    log = cluster.children.log(child)
    assert "died row=equal seed=1 why=every worker that ran it was killed, last tcp://127.0.0.1:" in log
    assert "row name=equal runs=0" in log


def _lose_the_scheduler(cluster: Cluster, folder: Path) -> None:
    short_batch(folder, "local")
    out = folder / "out"
    words = (folder / "short.xml", out, "--seeds", "4", "--row", "equal")
    child = launch_batch(cluster, *words, "--cluster", cluster.address)
    cluster.children.wait(lambda: results(out) or None, "a run", LIMIT, unless=child)
    cluster.children.signal("scheduler", signal.SIGKILL)
    assert cluster.children.exit(child, LIMIT) == 1, cluster.children.report()
    log = cluster.children.log(child)
    assert f"iw-run: --cluster: the scheduler at {cluster.address} was lost; what had arrived is stored" in log
    assert "of 4 runs are done; run the same command again to resume" in log
    assert "Traceback" not in log
    done = {path: path.stat().st_mtime_ns for path in results(out)}
    assert 1 <= len(done) < 4
    # The files are all that counts: another machine may take over.
    again = launch_batch(cluster, *words, "--jobs", "2")
    assert cluster.children.exit(again, LIMIT) == 0, cluster.children.report()
    assert {path: path.stat().st_mtime_ns for path in done} == done
    assert len(results(out)) == 4


def _lack_files(cluster: Cluster, folder: Path) -> None:
    batch = short_batch(folder, "out")
    files = batch_files(batch)
    source = folder / "short.xml"
    assert list(files) == [str(source)]
    source.write_text(source.read_text() + "<!-- other -->")
    with pytest.raises(
        WireError, match=r"worker tcp://127\.0\.0\.1:.*expected the file .*short\.xml as on this machine"
    ):
        _ask(cluster.address, batch, files)


def _ask(address: str, batch: Batch, files: dict[str, str]) -> None:
    with pytest.MonkeyPatch.context() as patch, connect(address) as client:
        patch.setattr(cluster_batch, "batch_files", lambda _batch: files)
        cluster_batch._await_workers(client, address, batch, threading.Event())


@pytest.mark.soak
@pytest.mark.process
def test_table_1_on_three_workers_of_which_one_is_killed_equals_the_stored_runs(
    cluster: Cluster, tmp_path: Path
) -> None:
    out = tmp_path / "table1"
    child = launch_batch(cluster, "table1", out, "--seeds", "3", "--cluster", cluster.address)
    cluster.children.wait(lambda: results(out)[9:] or None, "ten runs", 4 * LIMIT, unless=child)
    cluster.children.signal("worker2", signal.SIGKILL)
    assert cluster.children.exit(child, 4 * LIMIT) in (0, 1), cluster.children.report()
    found, known = (out / "batch.csv").read_text().splitlines(), STORED.read_text().splitlines()
    assert len(found) == 22
    assert set(found) <= set(known)


# ---------------------------------------------------------------- without processes


@pytest.mark.parametrize(
    ("text", "address"),
    [("head:8786", "tcp://head:8786"), ("tcp://[::1]:1", "tcp://[::1]:1"), ("tls://a.b-c:65535", "tls://a.b-c:65535")],
)
def test_address_is_read(text: str, address: str) -> None:
    assert scheduler_address(text) == address


@pytest.mark.parametrize("text", ["head", "http://head:8786", "head:0", "head:65536", "tcp://:1", ""])
def test_other_address_is_refused(text: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError, match="expected HOST:PORT"):
        scheduler_address(text)


def test_worker_of_another_version_is_refused(tmp_path: Path) -> None:
    assert "expected version 0.0.1 of IntellWheels, got" in inspect_worker({}, "0.0.1")
    task = Task(
        batch=short_batch(tmp_path, "out"),
        row=short_batch(tmp_path, "out").rows[0],
        seeds=(),
        version="0.0.1",
        files={},
    )
    with pytest.raises(RuntimeError, match=r"expected version 0\.0\.1"):
        make_runs(task)


def test_worker_that_came_later_and_lacks_a_file_says_so(tmp_path: Path) -> None:
    batch = short_batch(tmp_path, "out")
    files = batch_files(batch)
    (tmp_path / "short.xml").unlink()
    task = Task(batch=batch, row=batch.rows[0], seeds=("1",), version=version("intellwheels"), files=files)
    with pytest.raises(RuntimeError, match=r"expected the file .*short\.xml as on this machine"):
        make_runs(task)


def test_shares_are_small_enough_for_all_workers(tmp_path: Path) -> None:
    rows = short_batch(tmp_path, "out").rows
    pending = [(row, tuple(map(str, range(10)))) for row in rows]
    shares = list(cluster_batch._shares(pending, 10))
    assert {len(seeds) for _, seeds in shares} == {2}
    assert [(row.name, seed) for row, seeds in shares for seed in seeds] == [
        (row.name, seed) for row, seeds in pending for seed in seeds
    ]
    assert len(list(cluster_batch._shares(pending, 1))) == 2


class Ended:
    """A future that ended, as a cluster would return it."""

    def __init__(self, key: str, outcome: Any) -> None:
        self.key = key
        self.outcome = outcome
        self.status = "error" if isinstance(outcome, Exception) else "finished"

    def add_done_callback(self, call: Any) -> None:
        call(self)

    def exception(self) -> Exception:
        assert isinstance(self.outcome, Exception)
        return self.outcome

    def result(self, timeout: float) -> Any:
        if self.outcome is None:
            raise TimeoutError
        return self.outcome

    def release(self) -> None:
        pass


class Client:
    """A cluster of one thread that ends each task at once."""

    status = "running"

    def __init__(self, outcome: Any) -> None:
        self.outcome = outcome
        self.seeds: list[tuple[str, ...]] = []

    def nthreads(self) -> dict[str, int]:
        return {"a": 1}

    def submit(self, call: Any, task: Task, *, key: str, pure: bool) -> Ended:
        self.seeds.append(task.seeds)
        return Ended(key, self.outcome(task))

    def cancel(self, futures: list[Any], *, force: bool) -> None:
        assert futures == []


def perform(client: Client, batch: Batch) -> list[StoredRun]:
    runs: list[StoredRun] = []
    batch.out.mkdir()
    whole: Any = client
    cluster_batch._Distribution(whole, "tcp://head:1", batch, runs.append, threading.Event()).perform()
    return runs


def _archive_of(task: Task, folder: Path) -> bytes:
    import io
    import tarfile

    for seed in task.seeds:
        store_run(folder, stored(task.row.name, seed))
    archive = io.BytesIO()
    with tarfile.open(fileobj=archive, mode="w:gz") as file:
        file.add(folder / "runs", "runs")
    return archive.getvalue()


def test_seeds_of_a_task_that_kills_workers_are_tried_one_by_one(tmp_path: Path) -> None:
    from distributed import KilledWorker

    class Worker:
        address = "tcp://worker:7"

    def outcome(task: Task) -> Any:
        if "2" in task.seeds and task.row.name == "equal":
            return KilledWorker("task", Worker(), 1)  # type: ignore[arg-type]
        return _archive_of(task, tmp_path / "worker")

    client = Client(outcome)
    runs = perform(client, short_batch(tmp_path, "out", 6))
    assert ("1", "2", "3", "4", "5", "6") in client.seeds
    assert client.seeds.count(("2",)) == 1
    assert [(run.row, run.seed, run.died) for run in runs if run.died] == [
        ("equal", "2", "every worker that ran it was killed, last tcp://worker:7")
    ]
    assert len(runs) == 12


def test_worker_that_fails_ends_the_batch_with_the_reason(tmp_path: Path) -> None:
    with pytest.raises(ClusterError, match=r"a worker of tcp://head:1 failed: OSError: no space left"):
        perform(Client(lambda task: OSError("no space left")), short_batch(tmp_path, "out"))


def test_worker_that_keeps_its_runs_ends_the_batch_in_words(tmp_path: Path) -> None:
    with pytest.raises(ClusterError, match=r"a worker of tcp://head:1 did not hand over its runs within 120 s"):
        perform(Client(lambda task: None), short_batch(tmp_path, "out"))


@pytest.mark.parametrize("call", ["nthreads", "submit"])
def test_scheduler_that_is_gone_when_it_is_asked_is_lost(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, call: str
) -> None:
    def gone(*_: Any, **__: Any) -> None:
        raise OSError("Timed out trying to connect to tcp://head:1 after 15 s")

    monkeypatch.setattr(Client, call, gone)
    with pytest.raises(ClusterError, match=r"the scheduler at tcp://head:1 was lost; what had arrived is stored"):
        perform(Client(None), short_batch(tmp_path, "out"))


@pytest.mark.parametrize("stopped", [False, True])
def test_worker_that_does_not_answer_ends_the_wait(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, stopped: bool
) -> None:
    monkeypatch.setattr(cluster_batch, "CONNECT_LIMIT", 0.05)
    monkeypatch.setattr(cluster_batch, "INTERVAL", 0.01)
    thaw, stop = threading.Event(), threading.Event()

    class Frozen(Client):
        def run(self, *_: Any, **__: Any) -> dict[str, str]:
            thaw.wait()
            return {}

    if stopped:
        stop.set()
    frozen: Any = Frozen(None)
    try:
        if stopped:
            assert cluster_batch._ask_workers(frozen, short_batch(tmp_path, "out"), stop) == {}
        else:
            with pytest.raises(WireError, match=r"--cluster: expected an answer of each worker within 0\.05 s"):
                cluster_batch._ask_workers(frozen, short_batch(tmp_path, "out"), stop)
    finally:
        thaw.set()


def test_words_of_a_command_are_among_the_files(tmp_path: Path) -> None:
    batch = short_batch(tmp_path, "out")
    (tmp_path / "mine.py").write_text("")
    row = batch.rows[0]
    cast = msgspec.structs.replace(row.scene.cast[0], mind=None, command="python mine.py 'chair 1'")
    changed: Row = dataclasses.replace(row, scene=msgspec.structs.replace(row.scene, cast=(cast,)))
    assert str(tmp_path / "mine.py") in batch_files(dataclasses.replace(batch, rows=(changed,)))
