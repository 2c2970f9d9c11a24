"""A request queue that is closed and has sent everything when the block is left."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from intellwheels_viewer.steering import RequestQueue, Simulator


@contextmanager
def requests_of(simulator: Simulator) -> Iterator[RequestQueue]:
    requests = RequestQueue(simulator, lambda what, why: None)
    try:
        yield requests
    finally:
        requests.close()
        requests.join(10.0)
