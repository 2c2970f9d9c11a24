"""Work on many things that are independent of one another, shared by threads.

It pays for kernels that release Python's lock and run for longer than it takes to start a thread, about 0.1 ms.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise


def parts_of(count: int, threads: int) -> list[tuple[int, int]]:
    """Return the things of each thread: the first, and one past the last. There is at least one part.

    Raises:
        ValueError: The number of threads is no whole number from 1.
    """
    if isinstance(threads, bool) or not isinstance(threads, int) or threads < 1:
        raise ValueError(f"threads: expected a whole number from 1, got {threads!r}")
    threads = max(1, min(threads, count))
    return list(pairwise(count * k // threads for k in range(threads + 1)))


def share(work: Callable[[int, int], None], parts: list[tuple[int, int]]) -> None:
    """Call `work` for every part, the first one in this thread. Return when all are done.

    Raises:
        Exception: Whatever `work` raises.
    """
    if len(parts) == 1:
        work(*parts[0])
        return
    with ThreadPoolExecutor(len(parts) - 1) as pool:
        others = [pool.submit(work, *part) for part in parts[1:]]
        work(*parts[0])
        for other in others:
            other.result()
