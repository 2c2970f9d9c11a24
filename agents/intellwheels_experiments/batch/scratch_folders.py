"""Hidden folders in the output folder for work that is not finished. Those of a killed process are deleted later.

The process that works in a folder holds a lock on it (`flock`). The system releases the lock when the process ends,
even after `kill -9`. Processes on other machines may share the output folder, and not every file system shares locks,
so the name of a folder contains its machine, and a machine deletes its own folders only.
"""

from __future__ import annotations

import fcntl
import os
import platform
import re
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Final, Literal, TypeAlias

Purpose: TypeAlias = Literal["worker", "merge", "branch"]

PURPOSES: Final[tuple[Purpose, ...]] = ("worker", "merge", "branch")


@contextmanager
def scratch_folder(out: Path, purpose: Purpose) -> Iterator[Path]:
    """Make an empty folder in `out`, lock it, and delete it in the end.

    Raises:
        OSError: The folder cannot be made.
    """
    # While `out` is locked, nobody takes the new folder for one that its process has left.
    with ExitStack() as stack:
        with _locked(out, fcntl.LOCK_EX):
            folder = Path(tempfile.mkdtemp(prefix=_prefix(purpose), dir=out))
            stack.enter_context(_locked(folder, fcntl.LOCK_EX))
        stack.callback(shutil.rmtree, folder, ignore_errors=True)
        yield folder


def delete_abandoned(out: Path) -> None:
    """Delete the folders that killed processes of this machine have left in `out`."""
    with _locked(out, fcntl.LOCK_EX) as alone:
        if not alone:
            return
        for purpose in PURPOSES:
            for folder in out.glob(f"{_prefix(purpose)}*"):
                with _locked(folder, fcntl.LOCK_EX | fcntl.LOCK_NB) as abandoned:
                    if abandoned:
                        shutil.rmtree(folder, ignore_errors=True)


def _prefix(purpose: Purpose) -> str:
    machine = re.sub(r"[^\w.-]", "_", platform.node())
    return f".{purpose}-{machine}-"


@contextmanager
def _locked(folder: Path, how: int) -> Iterator[bool]:
    """Hold a lock on a folder. It yields whether it holds it: another process may, or the file system has no locks."""
    try:
        # Python's descriptors are closed in the processes that it starts, so none of those keeps the lock.
        descriptor = os.open(folder, os.O_RDONLY)
    except OSError:
        yield False
        return
    try:
        held = False
        with suppress(OSError):
            fcntl.flock(descriptor, how)
            held = True
        yield held
    finally:
        os.close(descriptor)
