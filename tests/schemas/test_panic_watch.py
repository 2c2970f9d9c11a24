"""A panic of Zenoh is noticed; everything on standard error is passed on."""

from __future__ import annotations

import subprocess
import sys

import pytest

PANIC = "thread 'rx-1' (16113) panicked at /root/.cargo/zenoh-1/io/zenoh-transport/src/pipeline.rs:401:39:"
PROGRAM = """
import os, sys, threading
from intellwheels_schemas.panic_watch import PanicWatch
seen = threading.Event()
def on_panic(line):
    print("seen", line, flush=True)
    seen.set()
watch = PanicWatch(on_panic)
os.write(2, sys.argv[1].encode())
if sys.argv[2] == "waits":
    seen.wait(20.0)
print("last words", file=sys.stderr)
raise SystemExit(3)
"""


def run(text: str, waits: bool) -> subprocess.CompletedProcess[str]:
    words = [sys.executable, "-c", PROGRAM, text, "waits" if waits else "goes"]
    return subprocess.run(words, capture_output=True, text=True, timeout=60.0, check=False)


@pytest.mark.process
def test_panic_is_told_once_and_passed_on() -> None:
    text = f"before\n\n{PANIC}\nmore\n{PANIC}\n"
    done = run(text, waits=True)
    assert done.stdout == f"seen {PANIC}\n"
    assert done.stderr == f"{text}last words\n"
    assert done.returncode == 3


@pytest.mark.process
def test_words_of_peers_are_no_panic() -> None:
    text = f"dropped why={PANIC!r}\nthread 'main' panicked at my.rs:1\nx {PANIC}\n"
    done = run(text, waits=False)
    assert (done.stdout, done.stderr) == ("", f"{text}last words\n")
