from __future__ import annotations

import argparse

import pytest

from intellwheels_experiments.batch.batch_options import MOST_RUNS, add_batch_options
from intellwheels_experiments.batch.batch_parts import WHOLE, Part


def parsed(*words: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser(exit_on_error=False)
    add_batch_options(parser)
    return parser.parse_args(words)


def test_without_options_there_is_one_job_and_one_part() -> None:
    found = parsed()
    assert (found.seeds, found.jobs, found.part, found.merge, found.branch) == (None, 1, WHOLE, [], None)


def test_part_and_folders_are_read() -> None:
    found = parsed("--seeds", "400", "--part", "2/8", "--merge", "a", "--merge", "b")
    assert (found.seeds, found.part) == (400, Part(2, 8))
    assert [folder.name for folder in found.merge] == ["a", "b"]


@pytest.mark.parametrize("words", [("--seeds", "0"), ("--jobs", str(MOST_RUNS + 1)), ("--part", "3/2")])
def test_value_out_of_range_is_refused(words: tuple[str, str]) -> None:
    with pytest.raises(argparse.ArgumentError):
        parsed(*words)
