"""What a browser starts from, before anybody touched it."""

from __future__ import annotations

from dataclasses import FrozenInstanceError

import pytest

from intellwheels_viewer.page_rights import EVERYTHING
from intellwheels_viewer.panels.choices import Choices


def test_a_new_browser_has_chosen_nothing_and_may_steer() -> None:
    choices = Choices()
    assert (choices.selected, choices.placing, choices.can_undo, choices.rights) == (None, None, False, EVERYTHING)
    assert dict(choices.looks) == {}


def test_browsers_do_not_share_their_looks() -> None:
    assert Choices().looks is not Choices().looks


def test_a_choice_is_not_changed_behind_a_panels_back() -> None:
    with pytest.raises(FrozenInstanceError):
        Choices().selected = "chair1"  # type: ignore[misc]
