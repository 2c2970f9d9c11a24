"""Latency from the source of an input to the motors of a chair at 20 Hz, as `iw-joystick --latency` reports it."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import tempfile
import threading
import wave
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest

from tests.agents.joystick import spoken, streams
from tests.bench.network import WORLD, process, wait_for
from tests.bench.rows import Row
from tests.bench.sink import endpoint

Joystick = subprocess.Popen[str]
NAMES = {
    "put_median": "source to network, median",
    "start_median": "source to motors, median",
    "start_max": "source to motors, maximum",
    "stop_median": "source to motors of a stop, median",
}
"""The figures by their names in the line that the command prints."""
LSL = ["lsl", "--stream-name", "bench", "--axes", "forward=0"]
SAMPLE_PERIOD = 0.01
"""Seconds between two samples of the stream."""


def bench(*, rounds: int = 40) -> list[Row]:
    """Return the rows; `rounds` is the number of starts and stops of each source."""
    pauses = random.Random(1)

    def words(child: Joystick) -> None:
        assert child.stdin is not None
        for _ in range(rounds):
            for word in ("forward", "stop"):
                child.stdin.write(f"{word}\n")
                child.stdin.flush()
                threading.Event().wait(pauses.uniform(0.3, 0.4))

    try:
        out = streams.outlet("bench")
    except pytest.skip.Exception as lacking:
        print(f"inputs: no stream: {lacking}")
        out = None

    def samples(_child: Joystick) -> None:
        for _ in range(rounds):
            for value in (1.0, 0.0):
                for _ in range(pauses.randint(30, 40)):
                    out.push_sample([value, 0.0])
                    threading.Event().wait(SAMPLE_PERIOD)

    with tempfile.TemporaryDirectory() as folder, _chair() as where:
        file = Path(folder) / "said.wav"
        with wave.open(str(file), "wb") as sound:
            sound.setnchannels(1)
            sound.setsampwidth(2)
            sound.setframerate(spoken.RATE)
            sound.writeframes((spoken.said("forward") + spoken.said("stop")) * max(1, rounds // 4))
        return [
            *_rows("words on a pipe", where, ["words"], words),
            *([] if out is None else _rows("lsl, 100 Hz", where, LSL, samples)),
            *_rows("voice, from the end of a word", where, ["voice", "--audio", str(file)], None),
        ]


@contextmanager
def _chair() -> Iterator[list[str]]:
    """A world with a chair whose motors obey at once. Gives the options that lead to it."""
    address = endpoint()
    where = ["--world", WORLD, "--connect", address]
    with ExitStack() as stack:
        simulator = stack.enter_context(
            process("intellwheels_server", "--map", "corridor15m", "--world", WORLD, "--listen", address)
        )
        wait_for(simulator, "ready")
        agent = stack.enter_context(process(
            "intellwheels_agents", "joystick", "--name", "chair1", "--robot", "rear-wheel",
            "--option", "AccelerationCurve=0", *where,
        ))  # fmt: skip
        wait_for(agent, "joined")
        yield where


def _rows(case: str, where: list[str], source: list[str], drive: Callable[[Joystick], None] | None) -> list[Row]:
    """Return the rows of a source. Without something that drives, it ends by itself."""
    words = ("chair1", "--forward", "0.05", "--latency", *where, "--source", *source)
    with process("intellwheels_agents.joystick", *words) as child:
        wait_for(child, "ready")
        if drive is not None:
            drive(child)
            os.killpg(child.pid, signal.SIGTERM)
        assert child.stdout is not None
        (line,) = [line for line in child.stdout if line.startswith("latency")]
    figures = dict(word.split("=") for word in line.split()[1:])
    known = {name: float(figures[name]) for name in NAMES if name in figures}
    return [Row("inputs", case, NAMES[name], 1e3 * value, "ms") for name, value in known.items()]
