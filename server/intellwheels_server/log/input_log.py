"""The input log: what a run is a function of, one line a tick.

JSON Lines. A header says what the world was made of; each line after it has what acted on a tick and the hash of the
state that came of it. A line with `"Stepped": false` changed the world without a step: a reset, or what came last.
"""

from __future__ import annotations

import os
import platform
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import IO, Annotated, Final

import msgspec
from msgspec import Meta

from intellwheels_schemas.messages import End, Hex, Map
from intellwheels_server.world import Setup
from intellwheels_server.world.inputs import Inputs

FORMAT: Final = "iw.v1"
DEFAULT_WORLD: Final = "main"
"""The world of a log that does not say it."""
FLUSH_AFTER: Final = 1.0
"""Seconds that a line is buffered at most."""


class Rules(msgspec.Struct, frozen=True, kw_only=True, rename="pascal"):
    """What a world is made of besides map, seed and period. Bounds are those of `iw-server`'s options."""

    say_limit: Annotated[int, Meta(ge=1, le=1000)]
    say_range: Annotated[float, Meta(gt=0.0)]
    command_timeout: Annotated[float, Meta(gt=0.0)]
    truth: bool
    strict: bool
    end: End | None = None
    say_walls: bool = False
    say_loss: Annotated[float, Meta(ge=0.0, le=1.0)] = 0.0
    say_delay: Annotated[float, Meta(ge=0.0, le=3600.0)] = 0.0


class Header(msgspec.Struct, frozen=True, kw_only=True, rename="pascal"):
    """The first line."""

    log: str
    run: Hex
    map: Map
    seed: str
    period: Annotated[float, Meta(ge=0.001, le=1.0)]
    setup: Rules
    world: str = DEFAULT_WORLD
    versions: dict[str, str] = {}
    cpu: str = ""

    def world_setup(self) -> Setup:
        """Return what the world is made of."""
        return Setup(
            floor=self.map,
            seed=self.seed,
            period=self.period,
            say_limit=self.setup.say_limit,
            say_range=self.setup.say_range,
            say_walls=self.setup.say_walls,
            say_loss=self.setup.say_loss,
            say_delay=self.setup.say_delay,
            command_timeout=self.setup.command_timeout,
            truth=self.setup.truth,
            strict=self.setup.strict,
            end=self.setup.end,
        )


class Line(msgspec.Struct, frozen=True, kw_only=True, rename="pascal", omit_defaults=True):
    """What acted on the step from `tick`, and the hash after it; without a step, the hash at `tick`."""

    tick: int
    inputs: Inputs
    hash: str
    stepped: bool = True


class LogError(ValueError):
    """A log that cannot be read; the text says where."""


_write = msgspec.json.Encoder().encode
_parse = msgspec.json.Decoder(Line).decode


class Log:
    """A log being written. Lines are buffered for about a second; `close` writes the rest.

    Args:
        path: The file; an existing one is replaced.
        setup: What the world is made of.
        run: The name of the run.
        world: The name of the world.

    Raises:
        OSError: The file cannot be written.
    """

    def __init__(self, path: Path, setup: Setup, run: str, world: str = DEFAULT_WORLD) -> None:
        self._file: IO[bytes] = path.open("wb")
        self._lines: list[bytes] = []
        self._flush_at = 0.0
        header = Header(
            log=FORMAT,
            run=run,
            map=setup.floor,
            seed=setup.seed,
            period=setup.period,
            setup=Rules(
                say_limit=setup.say_limit,
                say_range=setup.say_range,
                say_walls=setup.say_walls,
                say_loss=setup.say_loss,
                say_delay=setup.say_delay,
                command_timeout=setup.command_timeout,
                truth=setup.truth,
                strict=setup.strict,
                end=setup.end,
            ),
            world=world,
            versions=_versions(),
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
        LogError: It is not the header of an input log.
    """
    first = file.readline()
    try:
        header = msgspec.json.decode(first, type=Header)
    except (msgspec.MsgspecError, UnicodeDecodeError) as error:
        raise LogError(f"{name}:1: expected the header of an input log, got {error}") from None
    if header.log != FORMAT:
        raise LogError(f"{name}:1: expected a log of format {FORMAT}, got {header.log!r}")
    return header


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


def _versions() -> dict[str, str]:
    found = {"python": platform.python_version()}
    for package in ("intellwheels", "numpy", "numba"):
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = "unknown"
    return found


def _cpu() -> str:
    asked = os.environ.get("NUMBA_CPU_NAME")
    if asked:
        return f"{platform.machine()} {asked}"
    from llvmlite.binding import get_host_cpu_name  # type: ignore[import-untyped]  # noqa: PLC0415 - needed for the header only

    return f"{platform.machine()} {get_host_cpu_name()}"
