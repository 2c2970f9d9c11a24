"""Reaches the scheduler of a Dask cluster, and says in words when it is gone."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Final

from intellwheels_schemas.errors import WireError

if TYPE_CHECKING:
    from distributed import Client

CONNECT_LIMIT: Final = 15.0
"""Seconds for the scheduler to answer, and for all workers to say what they have."""


class ClusterError(RuntimeError):
    """The cluster did not make the runs. The text says why. What was made is stored."""


@contextmanager
def connect(address: str) -> Iterator[Client]:
    """Connect to the scheduler, and close the connection at the end.

    Raises:
        WireError: No scheduler answers within `CONNECT_LIMIT`.
    """
    import logging  # noqa: PLC0415
    import warnings  # noqa: PLC0415

    from distributed import Client  # noqa: PLC0415
    from distributed.versions import VersionMismatchWarning  # noqa: PLC0415

    # What it logs as an error, such as a scheduler that is gone, is told in a sentence here.
    for name in [name for name in logging.root.manager.loggerDict if name.startswith("distributed")]:
        logging.getLogger(name).setLevel(logging.CRITICAL)
    try:
        with warnings.catch_warnings():
            # Workers with other versions of Python or of libraries serve: only plain records are exchanged.
            warnings.filterwarnings("ignore", category=VersionMismatchWarning)
            client = Client(address, timeout=CONNECT_LIMIT, set_as_default=False)
    except (OSError, TimeoutError, ValueError) as error:
        text = f"--cluster: expected a Dask scheduler at {address}, got no answer within {CONNECT_LIMIT:.0f} s"
        raise WireError("value", text, "--cluster") from error
    try:
        yield client
    finally:
        with suppress(Exception):
            client.close(timeout=5)


def lost(address: str) -> ClusterError:
    """Return the error of a scheduler that is gone."""
    return ClusterError(f"the scheduler at {address} was lost; what had arrived is stored")


@contextmanager
def reach(address: str) -> Iterator[None]:
    """Say in our own words what Dask raises when the scheduler is gone: its own error, or that of the connection.

    Raises:
        ClusterError: The scheduler was lost.
    """
    from concurrent.futures import CancelledError  # noqa: PLC0415

    from distributed.client import ClosedClientError  # noqa: PLC0415

    try:
        yield
    except (CancelledError, ClosedClientError, OSError) as error:
        raise lost(address) from error


def slots(client: Client, address: str) -> int:
    """Return how many runs the cluster makes at a time: one for each thread of its workers.

    Raises:
        ClusterError: The scheduler was lost.
    """
    with reach(address):
        return sum(client.nthreads().values())
