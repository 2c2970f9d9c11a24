from __future__ import annotations

import math

import numpy as np
import pytest
import viser

from intellwheels_schemas.messages import Goal
from intellwheels_viewer.drawings.goals import Goals, arrow, dashes, target
from intellwheels_viewer.palette import Colours
from tests.viewer.drawings.cast import entity, node


def test_dashes_lead_from_the_agent_towards_its_goal() -> None:
    points, tints = dashes([entity("a", 1.0, 1.0, goal=Goal(x=4.0, y=5.0)), entity("b")], Colours())
    assert points.shape == tints.shape == (20, 2, 3)
    assert points[0, 0, :2] == pytest.approx([1.0, 1.0])
    assert float(np.hypot(points[..., 0] - 1.0, points[..., 1] - 1.0).max()) <= 5.0


def test_a_goal_far_away_has_no_more_than_two_hundred() -> None:
    points, _ = dashes([entity("a", goal=Goal(x=9000.0, y=0.0))], Colours())
    assert len(points) == 200


def test_the_sign_is_round_and_the_arrow_outside_of_it() -> None:
    assert float(np.hypot(*target().vertices[:, :2].T).max()) == pytest.approx(0.28)
    assert float(arrow().vertices[:, 0].min()) > 0.28


def test_goals_are_shown_where_they_are_and_only_headed_ones_have_an_arrow(scene: viser.SceneApi) -> None:
    goals = Goals(scene)
    goals.show([entity("a", goal=Goal(x=3.0, y=4.0)), entity("b", goal=Goal(x=5.0, y=6.0, heading=math.pi))], Colours())
    assert node(scene, "/goals/targets").batched_positions[:, :2].tolist() == [[3.0, 4.0], [5.0, 6.0]]
    arrows = node(scene, "/goals/headings")
    assert arrows.batched_positions[:, 0].tolist() == [5.0]
    goals.show([entity("a")], Colours())
    assert not arrows.visible
    assert not node(scene, "/goals/lines").visible
