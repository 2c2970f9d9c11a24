"""A file of lines that is written as it grows. A process that is killed loses at most the lines of the last second.

A machine that loses power loses more: what the system has not yet written to the disk. The file is never forced there
(`fsync`), as that can make the next write to it wait, and so a tick.
"""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import Final

from intellwheels_schemas.output_paths import open_output

FLUSH_AFTER: Final = 0.5
"""Seconds that a line is buffered. The loop of the service calls `flush_if_due` five times a second or more."""


class LineFile:
    """A file being written. After a write that fails, nothing more is written, so that no line is there twice.

    Args:
        path: The file; an existing one is replaced.

    Raises:
        OSError: The file cannot be written, or another process is writing it.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._file = open_output(path)
        self._lines: list[bytes] = []
        self._flush_at = 0.0
        self._failed = False

    def add(self, line: bytes) -> None:
        """Add a line, without its newline, to the buffer."""
        self._lines.append(line)

    def flush_if_due(self, now: float) -> None:
        """Write the buffer to the file if it is time.

        Raises:
            OSError: The file cannot be written.
        """
        if now >= self._flush_at:
            self.flush()
            self._flush_at = now + FLUSH_AFTER

    def flush(self) -> None:
        """Write the buffer to the file.

        Raises:
            OSError: The file cannot be written.
        """
        if not self._lines or self._failed:
            return
        data = memoryview(b"\n".join(self._lines) + b"\n")
        self._lines.clear()
        try:
            while data:
                data = data[self._file.write(data) :]
        except OSError as error:
            self._failed = True
            raise OSError(error.errno, error.strerror, str(self._path)) from error

    def close(self) -> None:
        """Write the buffer to the file and close it.

        Raises:
            OSError: The file cannot be written.
        """
        try:
            self.flush()
        except OSError:
            with contextlib.suppress(OSError):
                self._file.close()
            raise
        try:
            # Some file systems refuse what was written only now.
            self._file.close()
        except OSError as error:
            if not self._failed:
                raise OSError(error.errno, error.strerror, str(self._path)) from error
