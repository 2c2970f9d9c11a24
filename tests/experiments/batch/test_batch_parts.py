"""Parts of a batch: each run is in exactly one, and together they are the batch."""

from __future__ import annotations

import argparse

import pytest

from intellwheels_experiments.batch.batch_parts import Part, part
from tests.every_case import every_case


@pytest.mark.parametrize("parts", [1, 2, 3, 7, 50])
def test_every_run_is_in_exactly_one_part(parts: int) -> None:
    for index in range(40):
        assert [Part(number, parts).holds(index) for number in range(1, parts + 1)].count(True) == 1


def test_parts_differ_by_at_most_one_run() -> None:
    sizes = [sum(Part(number, 7).holds(index) for index in range(40)) for number in range(1, 8)]
    assert max(sizes) - min(sizes) <= 1


def test_part_is_read_from_text() -> None:
    assert part("2/8") == Part(2, 8)
    assert str(part("12/12")) == "12/12"


@every_case("text", ["", "2", "0/2", "3/2", "1/0", "-1/2", "1/2/3", "one/two", "1 / 2", "01/2", "1/9999999"])
def test_other_text_is_refused(text: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError, match="expected I/N with I from 1 to N, such as 2/8"):
        part(text)
