"""Checks where a command will write, before it starts anything: a run must not be lost after it is over."""

from __future__ import annotations

import os
from pathlib import Path

from intellwheels_schemas.errors import WireError


def check_output_file(path: Path | None, option: str) -> None:
    """Check that a file can be written. It is not created or changed.

    Args:
        path: The file; None is no file.
        option: The option that names it, for the error.

    Raises:
        WireError: It is a folder, its folder does not exist, or it must not be written.
    """
    if path is None:
        return
    if path.is_dir():
        raise WireError("value", f"{option}: expected a file, got the folder {path}", option)
    if path.exists():
        if not os.access(path, os.W_OK):
            raise WireError("value", f"{option}: expected a file that may be written, got {path}", option)
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
