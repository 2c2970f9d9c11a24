"""What is not on the map is entered a few points a tick, and the way then leads around it."""

from __future__ import annotations

import numpy as np

from intellwheels_agents.navigation.cost_to_go import CostToGo
from intellwheels_agents.navigation.footprint_clearance import boxes_of
from intellwheels_agents.navigation.strange_obstacles import AT_ONCE, entered
from tests.agents.navigation.rooms import CHAIR, room, weights


def test_way_leads_around_an_entered_obstacle() -> None:
    given = weights(room())
    points = np.stack([np.full(25, 3.0), np.linspace(0.1, 3.6, 25)], axis=1)
    steps = list(entered(given, boxes_of(CHAIR), points))
    assert len(steps) >= 25 // AT_ONCE + 2
    assert steps[:-1] == [None] * (len(steps) - 1)
    changed = steps[-1]
    assert changed is not None
    ways = []
    for each in (given, changed):
        costs = CostToGo.to_point(each, (4.6, 1.2), 0.1)
        costs.expand(10**7)
        ways.append(max(y for _, y in costs.way(1.2, 1.2, 0.0, 20.0)))
    assert ways[0] < 2.0
    assert ways[1] > 3.6


def test_nothing_to_enter_changes_nothing() -> None:
    given = weights(room())
    changed = list(entered(given, boxes_of(CHAIR), np.zeros((0, 2))))[-1]
    assert changed is not None
    assert (changed.move == given.move).all()
