from __future__ import annotations

import os
import threading

from intellwheels_agents.bridge.terminal_lines import is_background, read_lines

DEADLINE = 10.0


def test_each_line_counts_until_the_input_ends() -> None:
    reading, writing = os.pipe()
    count: list[int] = []
    os.write(writing, b"go\n\nhalf a line")
    os.close(writing)
    read_lines(reading, lambda: count.append(1), threading.Event())
    os.close(reading)
    assert len(count) == 2


def test_stopping_ends_the_reading() -> None:
    reading, writing = os.pipe()
    stop = threading.Event()
    thread = threading.Thread(target=read_lines, args=(reading, lambda: None, stop))
    thread.start()
    stop.set()
    thread.join(DEADLINE)
    assert not thread.is_alive()
    os.close(reading)
    os.close(writing)


def test_a_pipe_and_a_foreign_terminal_are_not_the_background() -> None:
    reading, writing = os.pipe()
    ours, theirs = os.openpty()
    try:
        assert not is_background(reading)
        assert not is_background(theirs)
    finally:
        for descriptor in (reading, writing, ours, theirs):
            os.close(descriptor)
