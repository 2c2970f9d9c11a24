"""A shorter start of a command that loads the kernels and then stays."""

from __future__ import annotations

import gc
import sys
from typing import Final

_BLAS: Final = "scipy.linalg.cython_blas"
"""The module that numba imports for linear algebra, if scipy is installed."""


class QuickStart:
    """Saves a third of the time that it takes to load the world, from its creation until `end`.

    - The garbage collector is off: nearly all objects that a program loads stay until it ends.
    - Numba does not find scipy. Numba imports all of `scipy.linalg` for `numpy.dot` in kernels, and ours do not use it.

    Create it in a process of a command alone. A program that embeds the world may compile kernels of its own.
    """

    def __init__(self) -> None:
        self._active = True
        self._collects = gc.isenabled()
        self._hides = _BLAS not in sys.modules
        gc.disable()
        if self._hides:
            # An import of a module that is None here raises ImportError, which numba expects.
            sys.modules[_BLAS] = None  # type: ignore[assignment]

    def end(self, *, freeze: bool = False) -> None:
        """Let the collector run again and scipy be found. Only the first call has an effect.

        Args:
            freeze: The objects that exist now live until the process ends, so the collector need not visit them again.
        """
        if not self._active:
            return
        self._active = False
        if self._hides:
            del sys.modules[_BLAS]
        if freeze:
            gc.collect()
            gc.freeze()
        if self._collects:
            gc.enable()
