from __future__ import annotations

import math

import numpy as np
import pytest
import viser

from intellwheels_schemas.messages import Entity, Goal
from intellwheels_viewer.drawings.body_documents import BodyDocument, BodyDocuments
from intellwheels_viewer.drawings.body_look import Extent
from intellwheels_viewer.drawings.goals import GAP, LENGTH, Goals, arrow, edge, pointer, pointers, target
from intellwheels_viewer.palette import Colours
from tests.viewer.drawings.cast import body, entity, node

HULL = Extent(rear=-0.3, front=0.9, right=-0.35, left=0.35, bottom=0.0, top=1.3)


def documents(*names: str) -> dict[str, BodyDocument]:
    return BodyDocuments().of({name: body("rear-wheel") for name in names}, crowd=False)


def test_the_arrow_is_short_and_gets_smaller_towards_the_goal() -> None:
    vertices = pointer().vertices
    assert float(vertices[:, 0].min()) == 0.0
    assert float(vertices[:, 0].max()) <= LENGTH
    near, far = (abs(vertices[mask][:, 1]).max() for mask in (vertices[:, 0] < 0.3, vertices[:, 0] > 0.55))
    assert near > far


@pytest.mark.parametrize(("course", "far"), [(0.0, 0.9), (math.pi, 0.3), (math.pi / 2, 0.35), (-math.pi / 2, 0.35)])
def test_the_edge_of_a_body_is_as_far_as_it_extends(course: float, far: float) -> None:
    assert edge(HULL, course) == pytest.approx(far, abs=1e-6)


def test_a_centre_outside_its_body_is_at_its_edge() -> None:
    assert edge(Extent(0.2, 0.9, -0.3, 0.3, 0.0, 1.0), math.pi) == 0.0


def test_an_arrow_begins_beside_its_agent_and_does_not_reach_beyond_a_metre_and_a_half() -> None:
    # A straight line to this goal would lead through whatever is between.
    one = entity("a", 1.0, 1.0, heading=0.5, goal=Goal(x=40.0, y=50.0))
    shown, places, (course,) = pointers([one, entity("b")], documents("a", "b"))
    assert shown == [one]
    assert course == pytest.approx(math.atan2(49.0, 39.0))
    begin = float(np.hypot(places[0, 0] - 1.0, places[0, 1] - 1.0))
    assert begin > GAP
    assert begin + LENGTH < 2.0


def test_near_its_goal_an_agent_has_no_arrow() -> None:
    def shown(x: float) -> list[Entity]:
        return pointers([entity("a", goal=Goal(x=x, y=0.0))], documents("a"))[0]

    assert shown(1.5) == []
    assert len(shown(4.0)) == 1


def test_an_agent_whose_document_is_not_known_has_no_arrow() -> None:
    assert pointers([entity("a", goal=Goal(x=9.0, y=0.0))], {})[0] == []


def test_the_sign_is_round_and_the_arrow_outside_of_it() -> None:
    assert float(np.hypot(*target().vertices[:, :2].T).max()) == pytest.approx(0.28)
    assert float(arrow().vertices[:, 0].min()) > 0.28


def test_goals_are_shown_where_they_are_and_only_headed_ones_have_an_arrow(scene: viser.SceneApi) -> None:
    goals, known = Goals(scene), documents("a", "b")
    goals.show(
        [entity("a", goal=Goal(x=3.0, y=4.0)), entity("b", goal=Goal(x=5.0, y=6.0, heading=math.pi))], known, Colours()
    )
    assert node(scene, "/goals/targets").batched_positions[:, :2].tolist() == [[3.0, 4.0], [5.0, 6.0]]
    arrows = node(scene, "/goals/headings")
    assert arrows.batched_positions[:, 0].tolist() == [5.0]
    assert len(node(scene, "/goals/pointers").batched_positions) == 2
    goals.show([entity("a")], known, Colours())
    assert not arrows.visible
    assert not node(scene, "/goals/pointers").visible
