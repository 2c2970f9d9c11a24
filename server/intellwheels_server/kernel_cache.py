"""The folder of compiled kernels, chosen before numba is imported.

The name of the folder holds a digest of the source of all kernels, because numba compiles a cached function again when
its own file changes, but not when a function that it calls from another file does.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import sys
import tempfile
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path

_VARIABLE = "NUMBA_CACHE_DIR"
# Folders of this package that hold kernels. A kind of sensor may call a kernel of another kind.
_FOLDERS = ("world/kernels", "world/sensors")
BAKED = "INTELLWHEELS_KERNELS"
"""The variable that names a folder of kernels compiled into an image. They are copied, as numba writes to its cache."""


def choose() -> Path:
    """Return the folder of compiled kernels, and make numba use it.

    It is what `NUMBA_CACHE_DIR` names; otherwise the first writable one of the user's cache folder, a folder of the
    user under the system's temporary folder, and a new temporary folder.
    """
    wanted = os.environ.get(_VARIABLE)
    folder = Path(wanted) if wanted else _first_writable()
    baked = os.environ.get(BAKED)
    if baked and not wanted and is_cold(folder):
        shutil.copytree(baked, folder, dirs_exist_ok=True)
    os.environ[_VARIABLE] = str(folder)
    loaded = sys.modules.get("numba")
    if loaded is not None:  # the program has imported numba already
        loaded.config.CACHE_DIR = str(folder)
    return folder


def is_cold(folder: Path) -> bool:
    """Return whether `folder` has no kernel of this version of Python, which is in the names of numba's indexes."""
    return next(folder.rglob(f"*.py{sys.version_info.major}{sys.version_info.minor}*.nbi"), None) is None


def source_digest() -> str:
    """Return 12 hex digits that change with the source of any kernel."""
    digest = hashlib.blake2b(digest_size=6)
    for folder in _FOLDERS:
        for file in _sources(folder):
            digest.update(f"{folder}/{file.name}".encode())
            digest.update(file.read_bytes())
    return digest.hexdigest()


def _sources(folder: str) -> list[Traversable]:
    package = resources.files("intellwheels_server").joinpath(folder)
    return sorted((file for file in package.iterdir() if file.name.endswith(".py")), key=lambda file: file.name)


def _first_writable() -> Path:
    name = f"kernels-{source_digest()}"
    for parent in _candidates():
        folder = parent / name
        if _usable(folder):
            return folder
    return Path(tempfile.mkdtemp(prefix="intellwheels-"))


def _candidates() -> list[Path]:
    base = os.environ.get("XDG_CACHE_HOME")
    places = [Path(base) / "intellwheels"] if base else []
    home = os.environ.get("HOME")
    if home:
        places.append(Path(home) / ".cache" / "intellwheels")
    places.append(Path(tempfile.gettempdir()) / f"intellwheels-{os.getuid()}")
    return places


def _usable(folder: Path) -> bool:
    """Make `folder`; return whether it belongs to this user and a file can be written to it.

    Compiled kernels are machine code, so a folder that another user made is not used.
    """
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        if folder.stat().st_uid != os.getuid():
            return False
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False
