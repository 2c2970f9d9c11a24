"""Work that threads share is done once, by as many as there are."""

from __future__ import annotations

import threading

import pytest

from intellwheels_server.world.shared_work import parts_of, share


@pytest.mark.parametrize(
    ("count", "threads", "parts"),
    [
        (5, 1, [(0, 5)]),
        (5, 2, [(0, 2), (2, 5)]),
        (2, 8, [(0, 1), (1, 2)]),
        (0, 2, [(0, 0)]),
    ],
)
def test_parts_cover_everything_once(count: int, threads: int, parts: list[tuple[int, int]]) -> None:
    assert parts_of(count, threads) == parts


@pytest.mark.parametrize("threads", [0, -1, True, 1.5])
def test_wrong_number_of_threads_is_named(threads: int) -> None:
    with pytest.raises(ValueError, match=f"threads: expected a whole number from 1, got {threads}"):
        parts_of(3, threads)


def test_every_part_has_its_thread_and_its_error_arrives() -> None:
    together = threading.Barrier(2, timeout=20.0)  # passes only if both run at once
    done: list[int] = []

    def work(first: int, end: int) -> None:
        together.wait()
        done.extend(range(first, end))

    share(work, parts_of(4, 2))
    assert sorted(done) == [0, 1, 2, 3]

    def fail(first: int, _end: int) -> None:
        if first:
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        share(fail, parts_of(4, 2))
