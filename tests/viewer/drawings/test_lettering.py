from __future__ import annotations

from intellwheels_viewer.drawings.lettering import written


def test_words_are_painted_on_a_clear_ground_in_their_colour() -> None:
    picture = written("Room", (10, 20, 30))
    assert picture.shape[0] == 96
    assert picture.shape[2] == 4
    assert picture[0, 0, 3] == 0
    assert picture[..., 3].max() == 255
    assert picture[picture[..., 3] == 255][0, :3].tolist() == [10, 20, 30]


def test_a_longer_word_is_a_wider_picture() -> None:
    assert written("Anteroom", (0, 0, 0)).shape[1] > written("Room", (0, 0, 0)).shape[1]


def test_lines_become_one_and_nothing_is_still_a_picture() -> None:
    assert written("a\nb", (0, 0, 0)).shape == written("a b", (0, 0, 0)).shape
    assert written("", (0, 0, 0)).shape[1] > 0
