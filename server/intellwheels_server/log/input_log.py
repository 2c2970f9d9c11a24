"""Writes and reads the input log: all inputs of a run, one line per tick. `file_records` declares its lines."""

from __future__ import annotations

import os
import platform
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Final

import msgspec

from intellwheels_schemas import defaults
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.file_records import CHAINED, FORMAT, InputEnd, InputHeader, InputTick, WorldRules
from intellwheels_schemas.input_reader import InputReader
from intellwheels_schemas.log_chain import Chain
from intellwheels_schemas.version import versions_of
from intellwheels_server.log.line_file import LineFile
from intellwheels_server.world import Setup

PACKAGES: Final = ("intellwheels", "numpy", "numba")
"""Distributions whose versions the header has, besides Python."""

Line = InputTick
"""A line after the header."""


class Header(InputHeader, frozen=True, kw_only=True):
    """The first line."""

    def world_setup(self) -> Setup:
        """Return the setup of the world."""
        rules = msgspec.structs.asdict(self.setup)
        return Setup(floor=self.map, seed=self.seed, period=self.period, **rules)


def rules_of(setup: Setup) -> WorldRules:
    """Return the settings of a world besides map, seed and period, which the header has itself."""
    return WorldRules(**{name: getattr(setup, name) for name in WorldRules.__struct_fields__})


class LogError(ValueError):
    """A log that cannot be read; the text says where."""


_write = msgspec.json.Encoder().encode
_parse = msgspec.json.Decoder(Line).decode


class Log:
    """A log being written. Each line has a checksum over itself and the lines before it. `close` writes the end.

    Args:
        path: The file; an existing one is replaced.
        setup: The setup of the world.
        run: The name of the run.
        world: The name of the world.

    Raises:
        OSError: The file cannot be written.
    """

    def __init__(self, path: Path, setup: Setup, run: str, world: str = defaults.WORLD) -> None:
        self._file = LineFile(path)
        self._chain = Chain()
        self._count = 0
        header = Header(
            log=FORMAT,
            version=CHAINED,
            run=run,
            map=setup.floor,
            seed=setup.seed,
            period=setup.period,
            setup=rules_of(setup),
            world=world,
            versions=versions_of(*PACKAGES),
            cpu=_cpu(),
        )
        self._seal(header)
        self._file.flush()

    def add(self, line: Line) -> None:
        """Add a line to the buffer."""
        self._seal(line)

    def write(self, line: Line, now: float) -> None:
        """Add a line, and write what is buffered if it is time.

        Raises:
            OSError: The file cannot be written.
        """
        self._seal(line)
        self._file.flush_if_due(now)

    def flush_if_due(self, now: float) -> None:
        """Write what is buffered if it is time, also when no line was added.

        Raises:
            OSError: The file cannot be written.
        """
        self._file.flush_if_due(now)

    def close(self, *, orderly: bool = True) -> None:
        """Write what is buffered and close the file. Without `orderly`, the log is left as a cut one.

        Raises:
            OSError: The file cannot be written.
        """
        if orderly:
            self._seal(InputEnd(end="closed", lines=self._count))
        self._file.close()

    def _seal(self, record: InputHeader | InputTick | InputEnd) -> None:
        self._file.add(self._chain.seal(_write(record)))
        self._count += 1


class LogReader(InputReader):
    """Reads a log line by line, as `InputReader` does; its errors are `LogError`.

    Attributes:
        first: The first line.

    Args:
        file: The log, at its beginning.
        name: Its name, for errors.

    Raises:
        LogError: It is not the header of an input log, of a version that this release cannot read, or edited.
    """

    def __init__(self, file: IO[bytes], name: str) -> None:
        try:
            super().__init__(file.readline(), name)
        except WireError as error:
            raise LogError(error.text) from None
        self.first = Header(**msgspec.structs.asdict(self.header))

    def read(self, text: bytes) -> Line | None:
        """Return the next line; None for the end of the log, and for an incomplete last line.

        Raises:
            LogError: The line is edited, or cannot be read.
        """
        try:
            return super().read(text)
        except WireError as error:
            raise LogError(error.text) from None


def read_header(file: IO[bytes], name: str) -> Header:
    """Return the first line of a log.

    Raises:
        LogError: It is not the header of an input log, of a version that this release cannot read, or edited.
    """
    return LogReader(file, name).first


def read_lines(file: IO[bytes], name: str) -> Iterator[Line | None]:
    """Yield the lines after the header, and None at the end of a log that is cut.

    Args:
        file: The log, wherever in it.
        name: Its name, for errors.

    Raises:
        LogError: A line is edited, or cannot be read.
    """
    file.seek(0)
    reader = LogReader(file, name)
    yield from reader.read_all(file)
    if reader.cut:
        yield None


def parse_line(text: bytes, where: str) -> Line:
    """Return a line after the header, whose checksum has been checked before.

    Raises:
        LogError: The line cannot be read.
    """
    try:
        return _parse(text)
    except (msgspec.MsgspecError, UnicodeDecodeError) as error:
        raise LogError(f"{where}: expected the line of a tick, got {error}") from None


def _cpu() -> str:
    asked = os.environ.get("NUMBA_CPU_NAME")
    if asked:
        return f"{platform.machine()} {asked}"
    from llvmlite.binding import get_host_cpu_name  # type: ignore[import-untyped]  # noqa: PLC0415 - needed for the header only

    return f"{platform.machine()} {get_host_cpu_name()}"
