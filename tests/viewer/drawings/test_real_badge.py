from __future__ import annotations

import numpy as np
import pytest

from intellwheels_schemas.rules import parts_of
from intellwheels_viewer.drawings.body_look import extent
from intellwheels_viewer.drawings.real_badge import GAP, LETTERS, PLATE, WIDTHS, WORDS, legend, on_floor, plate, upright
from tests.viewer.drawings.cast import robot


@pytest.mark.parametrize("word", WIDTHS)
def test_letters_lie_on_the_plate(word: str) -> None:
    made = plate(word)
    for rgb in (PLATE, LETTERS):
        assert (abs(made[rgb].vertices[:, 0]) <= 0.5).all()
    assert float(made[PLATE].vertices[:, 0].max()) == pytest.approx(0.5)
    assert float(made[LETTERS].vertices[:, 1].max()) < float(made[PLATE].vertices[:, 1].max())


@pytest.mark.parametrize("word", WIDTHS)
def test_the_plate_on_the_floor_is_behind_the_footprint(word: str) -> None:
    hull = extent(parts_of(robot("intellwheels")))
    made = on_floor(hull, word)
    assert float(made[PLATE].vertices[:, 0].max()) == pytest.approx(hull.rear - GAP)
    across = made[PLATE].vertices[:, 1]
    assert float(across.max() - across.min()) == pytest.approx(WIDTHS[word])
    assert float(made[LETTERS].vertices[:, 2].min()) > float(made[PLATE].vertices[:, 2].max())
    # Who stands behind the chair has its left at the left: the first letter is there.
    assert float(made[LETTERS].vertices[0, 1]) > 0.0


def test_an_upright_plate_is_read_from_behind() -> None:
    made = upright(-0.3, 0.8, 0.4, "REAL")
    assert float(made[LETTERS].vertices[:, 0].max()) < float(made[PLATE].vertices[:, 0].min())
    assert float(made[LETTERS].vertices[0, 1]) > 0.0
    assert float(made[PLATE].vertices[:, 2].mean()) == pytest.approx(0.8)


def test_the_legend_has_all_four() -> None:
    assert [word in legend() for word in ("real:", "stand-in:", "virtual:", "faded:")] == [True] * 4


def test_every_word_has_a_plate_and_letters_of_about_the_same_height() -> None:
    assert {word for word in WORDS.values() if word} == WIDTHS.keys()
    heights = [np.ptp(plate(word)[LETTERS].vertices[:, 1]) * width for word, width in WIDTHS.items()]
    assert min(heights) >= 0.08
