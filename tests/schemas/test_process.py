from __future__ import annotations

import os
import signal
import subprocess
import sys

import pytest

pytestmark = pytest.mark.process

CHILD = """
import sys
from intellwheels_schemas.process import stop_on_signals
stop = stop_on_signals(int(sys.argv[1]) if len(sys.argv) > 1 else None)
print("ready", flush=True)
while not stop.wait(0.2):
    pass
print("stopped", flush=True)
"""


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_signal_stops_a_process(number: signal.Signals) -> None:
    with subprocess.Popen([sys.executable, "-c", CHILD], stdout=subprocess.PIPE, text=True) as child:
        assert child.stdout is not None
        assert child.stdout.readline() == "ready\n"
        child.send_signal(number)
        assert child.communicate(timeout=10.0)[0] == "stopped\n"
        assert child.returncode == 0


BUSY = """
import os, signal
from intellwheels_schemas.process import stop_on_signals
stop = stop_on_signals()
with stop._cond:
    # Where the event is held, as in each of its waits.
    os.kill(os.getpid(), signal.SIGTERM)
    os.kill(os.getpid(), signal.SIGTERM)
assert stop.wait(10.0)
for _ in range(200_000):
    os.kill(os.getpid(), signal.SIGINT)
print("stopped", flush=True)
"""


def test_signal_at_any_moment_and_any_number_of_them_stop_a_process() -> None:
    done = subprocess.run([sys.executable, "-c", BUSY], capture_output=True, text=True, timeout=60.0, check=False)
    assert (done.returncode, done.stdout) == (0, "stopped\n"), done.stderr


LATE = """
import os, sys
from intellwheels_schemas.process import stop_on_signals
class Last:
    def __del__(self, write=os.write, read=os.read):
        # Python has put the default handlers back by now.
        write(1, b"last\\n")
        read(0, 1)
last = Last()
stop_on_signals()
sys.exit(3)
"""


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_signal_to_a_process_that_is_ending_leaves_its_exit_code(number: signal.Signals) -> None:
    command = [sys.executable, "-c", LATE]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as child:
        assert child.stdout is not None
        assert child.stdout.readline() == "last\n"
        child.send_signal(number)
        child.communicate("x", timeout=10.0)
        assert child.returncode == 3


def test_end_of_the_parents_pipe_stops_a_process() -> None:
    reading, writing = os.pipe()
    command = [sys.executable, "-c", CHILD, str(reading)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, pass_fds=(reading,)) as child:
        os.close(reading)
        assert child.stdout is not None
        assert child.stdout.readline() == "ready\n"
        os.close(writing)
        assert child.communicate(timeout=10.0)[0] == "stopped\n"


@pytest.mark.process
def test_a_reader_that_leaves_early_is_no_error() -> None:
    program = (
        "import sys\nfrom intellwheels_schemas.process import printing\ninput()\n"
        "with printing():\n    print('x' * 1_000_000)\nprint('and more')"
    )
    reading, writing = os.pipe()
    with subprocess.Popen(
        [sys.executable, "-c", program], stdin=subprocess.PIPE, stdout=writing, stderr=subprocess.PIPE, text=True
    ) as child:
        os.close(writing)
        os.close(reading)
        _, err = child.communicate("go\n", timeout=60.0)
    assert (child.returncode, err) == (0, "")


THREADS = """
import sys, threading, time
from intellwheels_schemas.process import start_network_thread
closed, slow = threading.Event(), threading.Event()
def waits():
    assert closed.wait(10.0)
    print("closed", flush=True)
def works():
    slow.set()
    sys.stdin.readline()
    print("answered", flush=True)
start_network_thread("waits", waits, end=closed.set)
start_network_thread("ended", lambda: None).join()
start_network_thread("works", works)
slow.wait(10.0)
print("ending", flush=True)
"""


def test_python_ends_after_the_threads_that_use_the_network() -> None:
    command = [sys.executable, "-c", THREADS]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as child:
        assert child.stdout is not None
        assert child.stdout.readline() == "ending\n"
        assert child.stdout.readline() == "closed\n"
        assert child.communicate("go\n", timeout=10.0)[0] == "answered\n"
        assert child.returncode == 0


CALLBACK = """
import atexit, sys, threading
atexit.register(print, "last", flush=True)
import zenoh
from intellwheels_schemas.process import start_network_thread
inside = threading.Event()
def on_sample(sample):
    inside.set()
    sys.stdin.readline()
    print("called back", flush=True)
def works():
    config = zenoh.Config()
    config.insert_json5("scouting/multicast/enabled", "false")
    config.insert_json5("listen/endpoints", "[]")
    with zenoh.open(config) as session, session.declare_subscriber("a", on_sample):
        session.put("a", b"")
        inside.wait(30.0)
start_network_thread("works", works).join(60.0)
print("ending", flush=True)
"""


def test_python_ends_after_the_callbacks_of_a_network_thread() -> None:
    """Zenoh calls back on threads that are daemons if the thread that subscribed is one."""
    command = [sys.executable, "-c", CALLBACK]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as child:
        assert child.stdout is not None
        assert child.stdout.readline() == "ending\n"
        assert child.communicate("go\n", timeout=30.0)[0] == "called back\nlast\n"
        assert child.returncode == 0


STUCK = """
import threading
from intellwheels_schemas import process
process.THREADS_END = 0.1
process.start_network_thread("stuck", threading.Event().wait)
"""


def test_a_thread_that_never_returns_cannot_keep_python_from_ending() -> None:
    done = subprocess.run([sys.executable, "-c", STUCK], capture_output=True, text=True, timeout=60.0, check=False)
    assert (done.returncode, done.stderr) == (0, "")


LATER = """
import sys, threading
from intellwheels_schemas.process import start_network_thread
closed = threading.Event()
def fails():
    raise ValueError("no end")
def first():
    assert closed.wait(10.0)
    start_network_thread("second", second)
def second():
    sys.stdin.readline()
    print("answered", flush=True)
started = threading.Event()
start_network_thread("fails", lambda: closed.wait(10.0), end=fails)
start_network_thread("first", first, end=closed.set)
"""


def test_python_waits_for_a_thread_that_another_starts_though_one_end_fails() -> None:
    command = [sys.executable, "-c", LATER]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=pipe, text=True) as child:
        out, err = child.communicate("go\n", timeout=60.0)
    assert (child.returncode, out) == (0, "answered\n")
    assert err.count("ValueError: no end") == 1


FULL = """
import threading
from intellwheels_schemas.process import start_network_thread
def full(_):
    raise RuntimeError("can't start new thread")
start, threading.Thread.start = threading.Thread.start, full
try:
    start_network_thread("none", lambda: None)
except RuntimeError as error:
    print(error)
threading.Thread.start = start
"""


def test_a_thread_that_cannot_start_is_not_waited_for() -> None:
    done = subprocess.run([sys.executable, "-c", FULL], capture_output=True, text=True, timeout=60.0, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, "can't start new thread\n", "")
