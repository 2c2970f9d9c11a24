"""Chairs claim their ways by messages; a claim has a right, and is void a while after it was said."""

from __future__ import annotations

import numpy as np
import pytest

from intellwheels_agents.navigation.right_of_way import (
    AT_GOAL,
    FORGET,
    TIRED,
    USUAL,
    Claim,
    Right,
    RightOfWay,
    claim_in,
    claim_message,
    halved,
)
from intellwheels_schemas.messages import Heard

WAY = np.array([(0.1 * i, -1.0) for i in range(40)])
CLAIM = Claim(Right(USUAL, "chair1"), 12.34, WAY, inside=True, stands=True)


def heard(sender: str, text: str) -> Heard:
    return Heard(sender=sender, tick=1, distance=1.0, text=text)


def test_claim_is_said_and_understood() -> None:
    text = claim_message(CLAIM, 100)
    assert len(text) <= 100
    assert text.startswith("way 1is chair1 12.3 0.0 -1.0 0.6 -1.0 1.2 -1.0")
    found = claim_in(text)
    assert found is not None
    assert found[:2] == (Right(USUAL, "chair1"), 12.3)
    assert found.inside
    assert found.stands
    assert found.way[:3].tolist() == pytest.approx(np.array([(0.0, -1.0), (0.3, -1.0), (0.6, -1.0)]))
    assert len(claim_message(CLAIM, 40)) <= 40
    assert claim_message(CLAIM, 20) == ""


@pytest.mark.parametrize("text", ["way 1 chair1 2.0", "way 0.5 1.0", "at 1.0 2.0", "open", "way 1 chair1 2.0 1.0 x"])
def test_other_messages_are_no_claims(text: str) -> None:
    assert claim_in(text) is None


def test_class_counts_before_the_name() -> None:
    rights = [Right(USUAL, "chair1"), Right(USUAL, "chair2"), Right(TIRED, "chair0"), Right(AT_GOAL, "a")]
    assert sorted(rights) == rights


def test_old_claims_and_those_without_a_right_do_not_count() -> None:
    ways = RightOfWay("chair2")
    at_goal = claim_message(CLAIM._replace(right=Right(AT_GOAL, "chair3")), 100)
    # What stems from this chair's own need comes back with its name.
    own = claim_message(CLAIM._replace(right=Right(USUAL, "chair2")), 100)
    ways.update(12.5, [heard("chair1", claim_message(CLAIM, 100)), heard("chair3", at_goal), heard("chair4", own)])
    assert [claim.right.name for claim in ways.of_others()] == ["chair1"]
    ways.update(12.4 + FORGET, [])
    assert ways.of_others() == []


def test_points_between_are_added() -> None:
    assert halved(np.array([[0.0, 0.0], [1.0, 0.0]])).tolist() == [[0.0, 0.0], [0.5, 0.0], [1.0, 0.0]]
    assert halved(np.zeros((1, 2))).shape == (1, 2)
