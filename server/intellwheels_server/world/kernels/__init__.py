"""Compiled kernels: the inner loops of the world, numba functions over plain arrays.

A kernel gives the same bits on every processor. So it uses only + - * / and sqrt, which
IEEE 754 rounds correctly, and this project's own :mod:`elementary` functions, never those of the C
library, which differ between machines; no `fastmath`, no `parallel`; and no sum runs over
bodies, because its order would show in the last bit.
"""

from intellwheels_server.kernel_locator import use_kernel_locator

use_kernel_locator()
