"""An input log as a world: a simulator plays it, tick by tick, so that no tick is missed."""

from __future__ import annotations

import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

from intellwheels_agents.options import OptionError
from intellwheels_agents.record_gateway.translator import Translator
from intellwheels_agents.record_gateway.world_source import WorldSource
from intellwheels_schemas import link
from intellwheels_schemas.codec import decode, encode, encoding_of
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import Result, Step
from intellwheels_schemas.process import PYTHON

WORLD: Final = "recorded"
"""The world in which the log is played; it is on this machine only."""
FASTEST: Final = "1000"
"""Speed of the playback: each tick is asked for, and then not delayed."""
START_TIMEOUT: Final = 120.0
"""Seconds for the simulator to read the log: a long one is run as a whole first."""
STEP_TIMEOUT: Final = 10.0
"""Seconds for a tick."""
END_TIMEOUT: Final = 5.0
"""Seconds for the simulator to end."""


@contextmanager
def playing(log: Path, endpoint: str, stop: threading.Event) -> Iterator[Callable[[], list[str]]]:
    """Let a simulator play a log at an endpoint; give a function that returns what it has said about the log.

    Raises:
        OptionError: The file is no log, or edited; the text is its own.
        ConnectionError: It did not start.
    """
    words = ["-m", "intellwheels_server", "--play", str(log), "--world", WORLD, "--listen", endpoint]
    words += ["--speed", FASTEST]
    child = subprocess.Popen(
        [*PYTHON, *words], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    complaints: list[str] = []
    ready = threading.Event()
    readers = [
        threading.Thread(target=_read, args=(child.stdout, lambda _line: ready.set()), daemon=True),
        threading.Thread(target=_read, args=(child.stderr, complaints.append), daemon=True),
    ]
    for reader in readers:
        reader.start()
    try:
        deadline = time.monotonic() + START_TIMEOUT
        while not ready.wait(0.05) and not stop.is_set():
            if child.poll() is not None or time.monotonic() > deadline:
                readers[1].join(END_TIMEOUT)
                why = "; ".join(complaints).removeprefix("iw-server: ").replace("--play", "--from")
                if child.returncode == 2:
                    raise OptionError(why)
                raise ConnectionError(why or f"--from: expected a simulator that plays {log}, got none")
        yield lambda: [line for line in complaints if line.startswith(f"{log}:")]
    finally:
        child.terminate()
        try:
            child.wait(END_TIMEOUT)
        except subprocess.TimeoutExpired:
            child.kill()
            child.wait()
        for reader in readers:
            reader.join(END_TIMEOUT)


def _read(stream: Any, take: Callable[[str], object]) -> None:
    for line in stream:
        take(line.rstrip("\n"))
    stream.close()


class LogSteps:
    """Steps through a log that is played.

    Args:
        session: An open session.
        keys: The keys of the world.
        source: Its messages.
        translator: What is recorded.
    """

    def __init__(self, session: Any, keys: Keys, source: WorldSource, translator: Translator) -> None:
        self._session = session
        self._keys = keys
        self._source = source
        self._translator = translator

    def run(self, stop: threading.Event, tend: Callable[[], None]) -> None:
        """Record every tick of the log.

        Args:
            stop: Ends it early.
            tend: Called after each tick.

        Raises:
            ConnectionError: The simulator does not answer, or a tick does not arrive.
        """
        self._wait_for(None, stop)
        while not stop.is_set():
            result = self._step(stop)
            if result is None or result.code != "ok":
                return
            self._wait_for(result, stop)
            tend()
            if result.text:
                return

    def _step(self, stop: threading.Event) -> Result | None:
        answers = link.query(
            self._session, self._keys.ctl("step"), encode(Step(count=1)), timeout=STEP_TIMEOUT, stop=stop
        )
        try:
            return decode(Result, answers[0].data, encoding_of(answers[0].encoding, answers[0].data), strict=False)
        except WireError as error:
            raise ConnectionError(f"step: {error.text}") from None

    def _wait_for(self, result: Result | None, stop: threading.Event) -> None:
        """Record what arrives until the clock and the state of a tick are there, with the map and the bodies."""
        deadline = time.monotonic() + STEP_TIMEOUT
        while not stop.is_set():
            self._source.work(stop, 0.01)
            translator = self._translator
            clock = translator.clock
            there = clock is not None and (result is None or (clock.run, clock.tick) == (result.run, result.tick))
            state = result is None or translator.ticks.last == (result.run, result.tick)
            if there and state and not translator.wants_map and not translator.wants_bodies:
                return
            if time.monotonic() > deadline:
                tick = "the first tick" if result is None else f"tick {result.tick}"
                raise ConnectionError(f"--from: expected {tick} of the log within {STEP_TIMEOUT:g} s, got none")
