"""Reaching the scheduler of a cluster: what is said when it is not there, or gone."""

from __future__ import annotations

from concurrent.futures import CancelledError
from typing import Any

import pytest

from intellwheels_experiments.batch import cluster_client
from intellwheels_experiments.batch.cluster_client import ClusterError, connect, reach, slots
from intellwheels_schemas.errors import WireError

HEAD = "tcp://head:1"


@pytest.mark.process
def test_address_without_a_scheduler_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster_client, "CONNECT_LIMIT", 0.5)
    words = r"--cluster: expected a Dask scheduler at tcp://127.0.0.1:9, got no answer"
    with pytest.raises(WireError, match=words), connect("tcp://127.0.0.1:9"):
        pass


@pytest.mark.parametrize(
    "error",
    [CancelledError("lost"), OSError("Timed out trying to connect to tcp://head:1 after 15 s"), TimeoutError()],
)
def test_what_is_raised_when_the_scheduler_is_gone_is_told_in_words(error: Exception) -> None:
    with (
        pytest.raises(ClusterError, match="the scheduler at tcp://head:1 was lost; what had arrived is stored") as told,
        reach(HEAD),
    ):
        raise error
    assert told.value.__cause__ is error


def test_another_error_stays() -> None:
    with pytest.raises(RuntimeError, match="a fault"), reach(HEAD):
        raise RuntimeError("a fault")


def test_slots_are_the_threads_of_all_workers() -> None:
    class Client:
        def nthreads(self) -> dict[str, int]:
            return {"a": 1, "b": 4}

    client: Any = Client()
    assert slots(client, HEAD) == 5
