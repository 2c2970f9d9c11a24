"""Costs are those of a plain Dijkstra search, however the work is cut, and lead around what is in the way."""

from __future__ import annotations

import heapq
import math

import numpy as np
import pytest

from intellwheels_agents.navigation.cost_to_go import REVERSE, CostToGo, Weights, distances
from intellwheels_agents.navigation.lattice import COUNT, STEPS
from tests.agents.navigation.rooms import room, weights

WALL = (2.6, 0.0, 2.9, 4.2)


def searched(given: Weights, ends: np.ndarray) -> np.ndarray:
    """Return the costs by the textbook."""
    found = np.full(ends.shape, np.inf)
    heap = []
    for k, j, i in np.argwhere(ends).tolist():
        found[k, j, i] = 0.0
        heap.append((0.0, k, j, i))
    heapq.heapify(heap)
    while heap:
        cost, k, j, i = heapq.heappop(heap)
        if cost > found[k, j, i]:
            continue
        di, dj = STEPS[k]
        before, after = (k - 1) % COUNT, (k + 1) % COUNT
        for pose, step in (
            ((k, j - dj, i - di), float(given.move[k, j - dj, i - di])),
            ((k, j + dj, i + di), REVERSE * float(given.move[k, j, i])),
            ((before, j, i), float(given.turn[before, j, i])),
            ((after, j, i), float(given.turn[k, j, i])),
        ):
            if cost + step < found[pose] - 1e-9:
                found[pose] = cost + step
                heapq.heappush(heap, (cost + step, *pose))
    return found


@pytest.mark.parametrize("states", [300, 100_000])
def test_costs_are_those_of_a_plain_search(states: int) -> None:
    given = weights(room((1.4, 0.0, 1.6, 1.6), size=3.2))
    ends = np.zeros(given.clearance.shape, dtype=bool)
    frame = given.frame
    ends[:, round((1.0 - frame.y) / 0.1), round((0.8 - frame.x) / 0.1)] = True
    costs = CostToGo(given, ends & (given.clearance >= 0.0))
    while not costs.done:
        costs.expand(states)
    expected = searched(given, ends & (given.clearance >= 0.0))
    assert (np.isfinite(costs.costs) == np.isfinite(expected)).all()
    both = np.isfinite(expected)
    assert both.any()
    assert costs.costs[both] == pytest.approx(expected[both], abs=1e-3)


def test_way_leads_around_a_wall() -> None:
    given = weights(room(WALL))
    costs = CostToGo.to_point(given, (4.5, 1.2), 0.1)
    while not costs.done:
        costs.expand(20_000)
    assert costs.at_pose((1.2, 1.2, 0.0)) > 8.0
    way = costs.way(1.2, 1.2, 0.0, 30.0)
    assert math.dist(way[-1], (4.5, 1.2)) < 0.11
    assert max(y for _, y in way) > 4.4
    assert not any(2.6 < x < 2.9 and y < 4.2 for x, y in way)


def test_cost_falls_along_the_way_and_between_cells() -> None:
    given = weights(room())
    costs = CostToGo.to_point(given, (4.5, 3.0), 0.1)
    costs.expand(10**7)
    along = costs.at(np.linspace(1.5, 4.0, 60), np.full(60, 3.0), np.zeros(60))
    assert (np.diff(along) < 0.0).all()


def test_goal_where_the_body_does_not_fit_is_approached() -> None:
    given = weights(room((3.0, 3.0, 4.0, 4.0)))
    costs = CostToGo.to_point(given, (3.5, 3.5), 0.1)
    costs.expand(10**7)
    assert costs.at_pose((1.0, 1.0, 0.0)) < 10.0


def test_unreachable_place_has_no_cost() -> None:
    given = weights(room((2.6, 0.0, 2.9, 6.0)))
    costs = CostToGo.to_point(given, (4.5, 3.0), 0.1)
    costs.expand(10**7)
    assert costs.done
    assert costs.at_pose((1.2, 3.0, 0.0)) == math.inf
    assert len(costs.way(1.2, 3.0, 0.0, 3.0)) == 1
    assert costs.way(-50.0, 3.0, 0.0, 3.0) == []


def test_refreshed_weights_are_those_made_anew() -> None:
    given = weights(room()).copied()
    other = weights(room((2.0, 2.0, 2.4, 2.4)))
    given.clearance[...] = other.clearance
    given.refresh((8, 56), (8, 56))
    inside = (slice(None), slice(8, 56), slice(8, 56))
    assert (given.turn[inside] == other.turn[inside]).all()
    assert (np.isfinite(given.move[inside]) == np.isfinite(other.move[inside])).all()


def test_right_lane_of_a_passage_costs_least() -> None:
    corridor = weights(room((0.0, 0.0, 6.0, 1.8), (0.0, 4.2, 6.0, 6.0)))
    row = {y: round((y - corridor.frame.y) / 0.1) for y in (2.4, 3.0, 3.6)}
    column = round((3.0 - corridor.frame.x) / 0.1)
    eastward = [float(corridor.move[0, row[y], column]) for y in (2.4, 3.0, 3.6)]
    westward = [float(corridor.move[16, row[y], column]) for y in (2.4, 3.0, 3.6)]
    assert eastward == sorted(eastward)
    assert westward == sorted(westward, reverse=True)


def test_distances_are_to_the_nearest_point() -> None:
    frame = weights(room()).frame
    off = distances(frame, [(1.0, 1.0), (3.0, 1.0)])
    assert off[round((1.0 - frame.y) / 0.1), round((2.6 - frame.x) / 0.1)] == pytest.approx(0.4)
    assert np.isinf(distances(frame, [])).all()
