"""Where a command will write: checked before it starts anything, locked while it runs.

A run must not be lost after it is over. So no command replaces a file without `--overwrite`, and a file has one writer
at a time: it holds a lock (`flock`), which the system releases when the process ends, even after `kill -9`. Devices and
pipes have no lock. File systems that know no locks go without.
"""

from __future__ import annotations

import argparse
import contextlib
import errno
import io
import os
import stat
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from intellwheels_schemas.errors import WireError

WRITTEN: Final = "another process is writing this file"
"""What the error says of a file that is locked."""
EXISTS: Final = "the file exists; --overwrite replaces it"
"""What the error says of a file that is not to be replaced."""
_LOCKED: Final = (errno.EWOULDBLOCK, errno.EACCES)


def add_overwrite_option(parser: argparse.ArgumentParser | argparse._ArgumentGroup) -> None:
    """Add the option `--overwrite`."""
    parser.add_argument(
        "--overwrite", action="store_true", help="replace files that exist; without it, they are refused"
    )


def check_output_file(path: Path | None, option: str, *, overwrite: bool = False) -> None:
    """Check that a file can be written. It is not created or changed.

    Args:
        path: The file; None is no file.
        option: The option that names it, for the error.
        overwrite: Whether it may replace a file. An empty file is no loss and may always be replaced.

    Raises:
        WireError: It is a folder, its folder does not exist, it must not be written, another process is writing it,
            or it would replace a file.
    """
    if path is None:
        return
    if path.is_dir():
        raise WireError("value", f"{option}: expected a file, got the folder {path}", option)
    if path.exists():
        if not os.access(path, os.W_OK):
            raise WireError("value", f"{option}: expected a file that may be written, got {path}", option)
        if path.is_file():
            if _is_written(path):
                raise WireError("value", f"{option}: expected another file than {path}: {WRITTEN}", option)
            if path.stat().st_size and not overwrite:
                raise WireError("value", f"{option}: expected a new file, got {path}: {EXISTS}", option)
        return
    folder = path.parent
    if not folder.is_dir():
        raise WireError("value", f"{option}: expected a folder that exists, got {folder} for the file {path}", option)
    if not os.access(folder, os.W_OK | os.X_OK):
        raise WireError("value", f"{option}: expected a folder that may be written, got {folder}", option)


def check_output_folder(path: Path | None, option: str) -> None:
    """Check that a folder can be written, or created with its parents. It is not created.

    Args:
        path: The folder; None is no folder.
        option: The option that names it, for the error.

    Raises:
        WireError: It is a file, or it must not be written.
    """
    if path is None:
        return
    nearest = next(each for each in (path.absolute(), *path.absolute().parents) if each.exists())
    if not nearest.is_dir():
        raise WireError("value", f"{option}: expected a folder, got the file {nearest}", option)
    if not os.access(nearest, os.W_OK | os.X_OK):
        raise WireError("value", f"{option}: expected a folder that may be written, got {nearest}", option)


def open_output(path: Path, *, overwrite: bool = True) -> io.FileIO:
    """Return an empty file without a buffer, locked until it is closed.

    Args:
        path: The file.
        overwrite: Whether it may replace a file that is not empty.

    Raises:
        OSError: It cannot be written, another process is writing it, or it would replace a file.
    """
    file = _lock_new(path, overwrite=overwrite)
    with contextlib.suppress(OSError):  # a device or a pipe
        file.truncate(0)
    return file


@contextlib.contextmanager
def reserved_output(path: Path, *, overwrite: bool) -> Iterator[io.FileIO]:
    """Reserve a file that is written at the end, all at once. Until then it keeps what it has.

    If nothing was written, a new file is removed in the end.

    Args:
        path: The file.
        overwrite: Whether it may replace a file that is not empty.

    Raises:
        OSError: It cannot be written, another process is writing it, or it would replace a file.
    """
    with _lock_new(path, overwrite=overwrite) as file:
        try:
            yield file
        finally:
            if path.is_file() and not os.fstat(file.fileno()).st_size:
                path.unlink()


def write_reserved(file: io.FileIO, data: bytes) -> None:
    """Write all that a reserved file is to have.

    Raises:
        OSError: It cannot be written.
    """
    with contextlib.suppress(OSError):  # a device or a pipe
        file.truncate(0)
    left = memoryview(data)
    while left:
        left = left[file.write(left) :]


def _lock_new(path: Path, *, overwrite: bool) -> io.FileIO:
    file = io.FileIO(os.open(path, os.O_WRONLY | os.O_CREAT, 0o666), "wb")
    found = os.fstat(file.fileno())
    if stat.S_ISREG(found.st_mode):
        if not _locks(file.fileno(), shared=False):
            file.close()
            raise OSError(errno.EBUSY, WRITTEN, str(path))
        if os.fstat(file.fileno()).st_size and not overwrite:
            file.close()
            raise OSError(errno.EEXIST, EXISTS, str(path))
    return file


def _is_written(path: Path) -> bool:
    try:
        descriptor = os.open(path, os.O_RDONLY)
    except OSError:
        return False  # nobody may read it, so nobody knows
    try:
        return not _locks(descriptor, shared=True)
    finally:
        os.close(descriptor)


def _locks(descriptor: int, *, shared: bool) -> bool:
    """Lock an open file, and return whether no other process holds it."""
    try:
        import fcntl  # noqa: PLC0415 - not every system has it
    except ImportError:
        return True
    try:
        fcntl.flock(descriptor, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)
    except OSError as error:
        return error.errno not in _LOCKED
    return True
