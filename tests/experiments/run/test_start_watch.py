from __future__ import annotations

import sys
from pathlib import Path

import pytest

from intellwheels_experiments.run.child_processes import ChildProcesses, WaitError
from intellwheels_experiments.run.start_watch import StartWatch, await_ready


def test_time_counts_from_the_last_words_and_each_kind_is_said_once(tmp_path: Path) -> None:
    log, said, done = tmp_path / "server.log", list[str](), list[str]()
    log.write_text("")
    watch = StartWatch(log, 180.0, said.append, done.append)
    assert not watch.over(0.0)
    assert not watch.over(180.0)
    now = 180.0
    with log.open("a") as file:
        for seconds in range(0, 3600, 100):  # an hour on a loaded machine
            file.write(f"compiling kernels: {seconds} s so far\nand so on\n")
            file.flush()
            now += 100.0
            assert not watch.over(now)
        file.write("waiting why='nobody answers at tcp/10.0.0.5:7447'\nwait")
    assert not watch.over(now)
    assert said == ["compiling kernels: 0 s so far", "waiting why='nobody answers at tcp/10.0.0.5:7447'"]
    assert len(done) == 37
    assert watch.over(now + 181.0)


@pytest.mark.process
def test_a_process_that_says_what_it_does_is_waited_for(tmp_path: Path) -> None:
    program = (
        "import sys; print('compiling kernels: 3 s so far', file=sys.stderr, flush=True); "
        "print('ready world=main', flush=True); input()"
    )
    said: list[str] = []
    with ChildProcesses(tmp_path) as children:
        child = children.launch("server", lambda _: [sys.executable, "-c", program])
        values = await_ready(children, child, 60.0, check=lambda: None, say=said.append)
        assert values == {"world": "main"}
        silent = children.launch("silent", lambda _: [sys.executable, "-c", "import time; time.sleep(600)"])
        with pytest.raises(WaitError, match="no line 'ready' of silent: it printed nothing for 0 s"):
            await_ready(children, silent, 0.0)

        def give_up() -> None:
            raise KeyError

        with pytest.raises(KeyError):
            await_ready(children, silent, 60.0, check=give_up)
    assert said in ([], ["compiling kernels: 3 s so far"])
