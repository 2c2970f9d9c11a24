"""What a live run writes: one input log of everything, or a folder for each run, or both, or nothing."""

from __future__ import annotations

from types import TracebackType
from typing import Self

from intellwheels_schemas.file_records import Inputs
from intellwheels_server.log.input_log import Line, Log
from intellwheels_server.log.run_files import RunFiles


class RunRecorder:
    """Writes each line wherever it belongs. As a context it closes the files, in order if nothing went wrong.

    Args:
        log: The log of everything, if any.
        files: The folder for the files of each run, if any.
    """

    def __init__(self, log: Log | None, files: RunFiles | None) -> None:
        self._log = log
        self._files = files

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None) -> None:
        try:
            if self._log is not None:
                self._log.close(orderly=kind is None)
        finally:
            if self._files is not None:
                self._files.close(orderly=kind is None)

    @property
    def is_wanted(self) -> bool:
        """Whether anything is written."""
        return self._log is not None or self._files is not None

    def write(self, tick: int, inputs: Inputs, digest: str, *, stepped: bool) -> None:
        """Add a line.

        Raises:
            OSError: A file cannot be written.
        """
        if self._log is not None:
            self._log.add(Line(tick=tick, inputs=inputs, hash=digest, stepped=stepped))
        if self._files is not None:
            self._files.record(tick, inputs, digest, stepped=stepped)

    def flush_if_due(self, now: float) -> None:
        """Write what is buffered if it is time. The loop of the service calls this, also while nothing happens.

        Raises:
            OSError: A file cannot be written.
        """
        for each in (self._log, self._files):
            if each is not None:
                each.flush_if_due(now)
