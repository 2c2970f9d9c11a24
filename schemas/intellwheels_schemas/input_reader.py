"""Reads the lines of an input log in order, and tells a log that was edited from one that was truncated.

A log ends with an `InputEnd`. One that ends earlier was truncated: by `kill -9`, a full disk, or a copy that is
incomplete. Its lines can be used up to the last whole one. A log whose checksums do not match was edited, and is
refused. Logs of version 1 have neither checksums nor an end; there, only an incomplete last line shows it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Final

import msgspec

from intellwheels_schemas.errors import WireError
from intellwheels_schemas.file_records import CHAINED, InputEnd, InputHeader, InputTick, read_header
from intellwheels_schemas.log_chain import Chain, has_more_than_a_line, is_sealed, unsealed

_BEGIN: Final = b'{"Log":"'
_END: Final = b'{"End":'
_parse = msgspec.json.Decoder(InputTick).decode
_parse_end = msgspec.json.Decoder(InputEnd).decode


class InputReader:
    """Reads a log whose first line is given.

    Attributes:
        header: The first line.
        chain: The checksum of the lines so far; empty for a log of version 1.
        lines: The lines so far, with the header.
        tick: The tick after them.
        cut: Whether an incomplete line was read, or the end of the file before the end of the log.

    Args:
        first: The first line of the file, with its newline.
        name: The file, for errors.

    Raises:
        WireError: It is not the header of an input log, of a version that this release cannot read, or edited.
    """

    def __init__(self, first: bytes, name: str) -> None:
        self._name = name
        self._chain = Chain()
        self._closed = False
        self.lines = 1
        self.tick = 0
        self.cut = False
        text = first.removesuffix(b"\n")
        if not is_sealed(text) and text == first and (text.startswith(_BEGIN) or _BEGIN.startswith(text)):
            where = self._where()
            raise WireError(
                "malformed",
                f"{where}: expected the header of an input log, got one that is truncated: no tick is left",
                where,
            )
        if is_sealed(text):
            self._check(text)
        self.header = read_header(InputHeader, unsealed(text) if is_sealed(text) else text, self._where())
        if self.is_chained and not is_sealed(text):
            self._check(text)

    @property
    def is_chained(self) -> bool:
        """Whether the lines have checksums."""
        return self.header.version >= CHAINED

    @property
    def chain(self) -> str:
        """The checksum of the lines so far."""
        return self._chain.value

    def read(self, text: bytes) -> InputTick | None:
        """Return the next line; None for the end of the log, and for an incomplete last line.

        Args:
            text: The line, with its newline.

        Raises:
            WireError: The line is edited, or cannot be read.
        """
        self.lines += 1
        line = text.removesuffix(b"\n")
        if self.is_chained:
            if self._closed:
                raise self._error("expected nothing after the end of the log, got another line")
            # Of a whole log, only the newline at its end may be gone.
            if line == text and not is_sealed(line) and not has_more_than_a_line(line):
                self._stop()
                return None
            self._check(line)
            line, text = unsealed(line), b""
            if line.startswith(_END):
                self._close(line)
                return None
        try:
            found = _parse(line)
        except (msgspec.MsgspecError, UnicodeDecodeError) as error:
            if line == text:
                self._stop()
                return None
            raise self._error(f"expected the line of a tick, got {error}") from None
        self.tick = found.tick + found.stepped
        return found

    def finish(self) -> None:
        """Tell that the file has ended; `cut` is right from now on."""
        self.cut = self.cut or (self.is_chained and not self._closed)

    def read_all(self, file: Iterable[bytes]) -> Iterator[InputTick]:
        """Yield the lines up to the end, and finish.

        Raises:
            WireError: A line is edited, or cannot be read.
        """
        for text in file:
            line = self.read(text)
            if line is not None:
                yield line
        self.finish()

    def _stop(self) -> None:
        self.lines -= 1
        self.cut = True

    def _close(self, line: bytes) -> None:
        try:
            count = _parse_end(line).lines
        except (msgspec.MsgspecError, UnicodeDecodeError) as error:
            raise self._error(f"expected the end of the log, got {error}") from None
        if count != self.lines - 1:
            raise self._error(f"expected {self.lines - 1} lines before the end, got {count}")
        self._closed = True

    def _check(self, line: bytes) -> None:
        wrong = self._chain.check(line)
        if wrong is not None:
            raise self._error(
                f"{wrong}: the log was edited after tick {self.tick}, in this line or by adding or removing lines"
            )

    def _where(self) -> str:
        return f"{self._name}:{self.lines}"

    def _error(self, text: str) -> WireError:
        return WireError("malformed", f"{self._where()}: {text}", self._where())


def cut_text(name: str, tick: int) -> str:
    """Return the text that tells people of a truncated log."""
    return f"{name}: the log is truncated after tick {tick}: it has no end, so later ticks may be missing"


def unchained_text(name: str) -> str:
    """Return the text that tells people of a log of version 1."""
    return f"{name}: a log of version 1 has no checksums, so an edit cannot be found"
