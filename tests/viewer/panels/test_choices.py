"""What a browser starts from, before anybody touched it."""

from __future__ import annotations

from dataclasses import FrozenInstanceError

import pytest

from intellwheels_viewer.panels.choices import Choices


def test_a_new_browser_has_chosen_nothing_and_may_steer() -> None:
    choices = Choices()
    assert (choices.selected, choices.placing, choices.refusal, choices.allowed) == (None, None, "", True)
    assert dict(choices.colours) == {}


def test_browsers_do_not_share_their_colours() -> None:
    assert Choices().colours is not Choices().colours


def test_a_choice_is_not_changed_behind_a_panels_back() -> None:
    with pytest.raises(FrozenInstanceError):
        Choices().selected = "chair1"  # type: ignore[misc]
