"""Where numba keeps the compiled kernels of this package, whatever folder the package is installed in.

Numba's own locators name the folder of compiled functions after the path of their source. A second environment or a
second checkout would then compile all kernels again. Numba compares the content of the source anyway, and the version
of Python is part of the file names.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import numba
from numba.core import caching

_PACKAGE: Final = Path(__file__).resolve().parent
_SETTING: Final = "CACHE_LOCATOR_CLASSES"
_OTHERS: Final = "UserProvidedCacheLocator"
"""Numba's locator for all other functions. Its name had an underscore before numba could be told locators."""

_ready: set[str] = set()
"""Folders of the cache to which files can be written."""


class KernelLocator(getattr(caching, _OTHERS, caching._CacheLocator)):  # type: ignore[misc] # numba has no types
    """Locates the kernels of this package. It leaves all other functions to the next locator."""

    @classmethod
    def from_function(cls, py_func: Callable[..., Any], py_file: str) -> Any:
        """Return a locator for a function, or None if the function is not of this package."""
        return super().from_function(py_func, py_file) if _folder_of(py_file, _PACKAGE) is not None else None

    @classmethod
    def get_suitable_cache_subpath(cls, py_file: str) -> str:
        """Return the folder of a source file below the cache's folder: its place in the package."""
        return str(_folder_of(py_file, _PACKAGE))

    def ensure_cache_path(self) -> None:
        """Make the folder of the cache, and see that files can be written to it: once for each folder."""
        path = self.get_cache_path()
        if path not in _ready or not Path(path).is_dir():
            super().ensure_cache_path()
            _ready.add(path)


def use_kernel_locator() -> None:
    """Make numba use the locator, unless the user has named others or this version of numba cannot be told any.

    It sets no environment variable: a child process in another environment would inherit it and fail to find the class.
    """
    if not getattr(numba.config, _SETTING, "unknown"):
        setattr(numba.config, _SETTING, f"{__name__}.{KernelLocator.__name__},{_OTHERS}")


@functools.cache
def _folder_of(file: str, package: Path) -> Path | None:
    """Return the folder of a source file below the package, or None. A file has many kernels."""
    folder = Path(file).resolve().parent
    return folder.relative_to(package) if folder.is_relative_to(package) else None
