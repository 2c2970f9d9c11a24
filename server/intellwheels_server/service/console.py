"""The lines that the simulator prints. A closed pipe does not stop the run."""

from __future__ import annotations

import contextlib
import sys
from typing import TextIO


def print_line(line: str) -> None:
    """Print a line that scripts wait for, to standard output."""
    _write(sys.stdout, line)


def log_line(line: str) -> None:
    """Print a line for people, to standard error."""
    _write(sys.stderr, line)


def _write(stream: TextIO, line: str) -> None:
    with contextlib.suppress(OSError, ValueError):  # the reader has closed the pipe
        # In one piece, as the two streams may share a file and `PYTHONUNBUFFERED` writes each piece by itself.
        stream.write(line + "\n")
        stream.flush()
