"""Where recorded messages go: files in MCAP, and the server of the live view. Only this file writes and serves.

A file is flushed at least once a second, so that a recorder that is killed loses no more. A new file begins when one
is full. It repeats the map and the bodies, so that each file can be read by itself.
"""

from __future__ import annotations

import errno
import io
import socket
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any, BinaryIO, Final

import foxglove
from foxglove import Channel, Context, channels
from foxglove.mcap import MCAPWriteOptions
from foxglove.websocket import Capability, WebSocketServer

from intellwheels_agents.record_gateway.translator import Entry

FLUSH_EVERY: Final = 1.0
"""Longest time, s, for which a message is only in memory."""
MOST_PENDING: Final = 4_000_000
"""Most bytes of a file that are only in memory."""
PROFILE: Final = "intellwheels"
_LEVEL: Final = "ERROR"


class OutputFile:
    """A file that gets whole chunks only, and remembers an error instead of raising it within the library.

    The library writes the length of a chunk when it is complete. Everything since the last `commit` is therefore kept
    in memory: the file on the disk never ends within a chunk.

    Attributes:
        error: The first error, or None.
    """

    def __init__(self, path: Path) -> None:
        """Create the file.

        Raises:
            OSError: It cannot be created.
        """
        self.error: OSError | None = None
        self._file: BinaryIO = path.open("wb", buffering=0)
        self._committed = 0
        self._tail = io.BytesIO()

    @property
    def pending(self) -> int:
        """Bytes in memory."""
        return len(self._tail.getbuffer())

    @property
    def size(self) -> int:
        """Bytes so far, with those in memory."""
        return self._committed + self.pending

    def write(self, data: bytes | bytearray) -> int:
        """Keep bytes; return their number."""
        return self._tail.write(data)

    def seek(self, offset: int, whence: int = 0) -> int:
        """Move within what is in memory and return the position in the file."""
        if whence == io.SEEK_SET:
            offset -= self._committed
        return self._committed + self._tail.seek(offset, whence)

    def flush(self) -> None:
        """Do nothing: a chunk may be open."""

    def commit(self) -> None:
        """Write what is in memory. Call it while no chunk is open."""
        data = memoryview(self._tail.getvalue())
        self._committed += len(data)
        self._tail = io.BytesIO()
        try:
            while data and self.error is None:
                data = data[self._file.write(data) :]
        except OSError as error:
            self.error = error

    def close(self) -> None:
        """Write what is in memory, and close the file."""
        self.commit()
        self._file.close()


class MessageSinks:
    """Writes entries to a file, or serves them, or both.

    Attributes:
        files: The files so far.
        messages: Messages so far, those that are repeated in a new file not counted.
    """

    def __init__(self, schemas: Mapping[str, dict[str, Any]], path: Path | None, most_bytes: int) -> None:
        """Begin the first file.

        Args:
            schemas: The JSON Schema of each document.
            path: The file; None for none.
            most_bytes: Size at which a new file begins.

        Raises:
            OSError: The file cannot be created.
        """
        foxglove.set_log_level(_LEVEL)
        self.files: list[Path] = []
        self.messages = 0
        self._schemas = schemas
        self._path = path
        self._most_bytes = most_bytes
        self._context = Context()
        self._channels: dict[str, Any] = {}
        self._kept: dict[str, Entry] = {}
        self._server: WebSocketServer | None = None
        self._file: OutputFile | None = None
        self._writer: foxglove.MCAPWriter | None = None
        self._flush_due = time.monotonic() + FLUSH_EVERY
        if path is not None:
            self._open(path)

    def serve(self, name: str, host: str, port: int, listener: Any) -> int:
        """Serve the live view, and return its port.

        Raises:
            OSError: The port is in use, or the address is not of this machine.
        """
        try:
            # The library has no class and no code for these errors, so they are found first.
            with socket.create_server((host, port)):
                pass
        except OSError as error:
            if error.errno == errno.EADDRINUSE:
                text = f"--port: expected a free port, got {port}, which is in use; --port 0 takes any free one"
                raise OSError(text) from None
            raise OSError(f"cannot serve at {host}:{port}: {error.strerror or error}") from None
        try:
            self._server = foxglove.start_server(
                name=name, host=host, port=port, capabilities=[Capability.ClientPublish], server_listener=listener,
                supported_encodings=["json"], context=self._context,
            )  # fmt: skip
        except Exception as error:  # the library has no class of its own for it
            raise OSError(f"cannot serve at {host}:{port}: {error}") from None
        return self._server.port

    def write(self, entry: Entry) -> None:
        """Write an entry.

        Raises:
            OSError: The disk is full, or another error of the file.
        """
        for name in entry.forgets:
            self._kept.pop(name, None)
        if entry.keep:
            self._kept[entry.keep] = entry
        self._log(entry)
        self.messages += 1
        if self._file is None:
            return
        if self._file.size >= self._most_bytes:
            self._rotate()
        elif self._file.pending >= MOST_PENDING:
            self._flush()

    def tend(self) -> None:
        """Flush the file if it is time. Call it often.

        Raises:
            OSError: The disk is full, or another error of the file.
        """
        if time.monotonic() >= self._flush_due:
            self._flush()

    def repeat(self, topic: str) -> None:
        """Send what is kept of a topic again, for a page that has just subscribed. The file gets it again too."""
        for entry in [kept for kept in self._kept.values() if kept.topic == topic]:
            self._log(entry)

    def close(self, summary: Mapping[str, str]) -> None:
        """End the file, with a summary as its metadata, and the server.

        Raises:
            OSError: The disk is full, or another error of the file.
        """
        if self._server is not None:
            self._server.stop()
            self._server = None
        self._close_file(summary)

    def _flush(self) -> None:
        self._flush_due = time.monotonic() + FLUSH_EVERY
        if self._writer is None or self._file is None:
            return
        self._writer.flush()
        self._file.commit()
        if self._file.error is not None:
            raise self._file.error

    def _open(self, path: Path) -> None:
        self._file = OutputFile(path)
        # One thread compresses: cores belong to the simulator.
        options = MCAPWriteOptions(profile=PROFILE, compression_threads=0)
        self._writer = foxglove.open_mcap(self._file, context=self._context, writer_options=options)
        self.files.append(path)

    def _close_file(self, summary: Mapping[str, str]) -> None:
        if self._writer is None or self._file is None:
            return
        if self._file.error is None:
            self._writer.write_metadata("iw-record", dict(summary))
        self._writer.close()
        self._file.close()
        self._writer, error = None, self._file.error
        if error is not None:
            raise error

    def _rotate(self) -> None:
        if self._path is None:
            return
        self._close_file({"continues": part_of(self._path, len(self.files) + 1).name})
        self._open(part_of(self._path, len(self.files) + 1))
        for entry in list(self._kept.values()):
            self._log(entry)

    def _log(self, entry: Entry) -> None:
        channel = self._channels.get(entry.topic)
        if channel is None:
            channel = self._channels[entry.topic] = self._channel(entry)
        channel.log(entry.message, log_time=entry.time)

    def _channel(self, entry: Entry) -> Any:
        if entry.kind:
            return Channel(entry.topic, schema=self._schemas[entry.kind], context=self._context)
        made = getattr(channels, f"{type(entry.message).__name__}Channel")
        return made(entry.topic, context=self._context)


def part_of(path: Path, number: int) -> Path:
    """Return the name of a file of a recording, the first of which is `path`: `run-2.mcap` is the second."""
    return path if number == 1 else path.with_name(f"{path.stem}-{number}{path.suffix}")
