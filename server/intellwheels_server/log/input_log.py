"""Writes and reads the input log: all inputs of a run, one line per tick. `file_records` declares its lines."""

from __future__ import annotations

import os
import platform
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Final

import msgspec

from intellwheels_schemas import defaults, file_records
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.file_records import FORMAT, InputHeader, InputTick, WorldRules
from intellwheels_schemas.version import versions_of
from intellwheels_server.world import Setup

FLUSH_AFTER: Final = 1.0
"""Seconds that a line is buffered at most."""

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
    """A log being written. Lines are buffered for about a second; `close` writes the rest.

    Args:
        path: The file; an existing one is replaced.
        setup: The setup of the world.
        run: The name of the run.
        world: The name of the world.

    Raises:
        OSError: The file cannot be written.
    """

    def __init__(self, path: Path, setup: Setup, run: str, world: str = defaults.WORLD) -> None:
        self._file: IO[bytes] = path.open("wb")
        self._lines: list[bytes] = []
        self._flush_at = 0.0
        header = Header(
            log=FORMAT,
            run=run,
            map=setup.floor,
            seed=setup.seed,
            period=setup.period,
            setup=rules_of(setup),
            world=world,
            versions=versions_of("intellwheels", "numpy", "numba"),
            cpu=_cpu(),
        )
        self._lines.append(_write(header))
        self.flush()

    def write(self, line: Line, now: float) -> None:
        """Add a line, and write the buffer to the file if a second has passed."""
        self._lines.append(_write(line))
        if now >= self._flush_at:
            self.flush()
            self._flush_at = now + FLUSH_AFTER

    def flush(self) -> None:
        """Write the buffer to the file."""
        if self._lines:
            self._file.write(b"\n".join(self._lines) + b"\n")
            self._lines.clear()
        self._file.flush()

    def close(self) -> None:
        """Write the buffer to the file and close it."""
        self.flush()
        self._file.close()


def read_header(file: IO[bytes], name: str) -> Header:
    """Return the first line of a log.

    Raises:
        LogError: It is not the header of an input log, or of a version that this release cannot read.
    """
    try:
        header = file_records.read_header(InputHeader, file.readline(), f"{name}:1")
    except WireError as error:
        raise LogError(error.text) from None
    return Header(**msgspec.structs.asdict(header))


def read_lines(file: IO[bytes], name: str) -> Iterator[Line | None]:
    """Yield the lines after the header, and None for an incomplete last line.

    Raises:
        LogError: A complete line cannot be read.
    """
    for number, text in enumerate(file, start=2):
        line = parse_line(text, f"{name}:{number}")
        yield line
        if line is None:
            return


def parse_line(text: bytes, where: str) -> Line | None:
    """Return a line after the header, or None for an incomplete last line.

    Raises:
        LogError: A complete line cannot be read.
    """
    try:
        return _parse(text)
    except (msgspec.MsgspecError, UnicodeDecodeError) as error:
        if not text.endswith(b"\n"):
            return None
        raise LogError(f"{where}: expected the line of a tick, got {error}") from None


def _cpu() -> str:
    asked = os.environ.get("NUMBA_CPU_NAME")
    if asked:
        return f"{platform.machine()} {asked}"
    from llvmlite.binding import get_host_cpu_name  # type: ignore[import-untyped]  # noqa: PLC0415 - needed for the header only

    return f"{platform.machine()} {get_host_cpu_name()}"
