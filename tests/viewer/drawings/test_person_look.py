from __future__ import annotations

from intellwheels_viewer.drawings.person_look import person
from tests.viewer.drawings.cast import robot


def test_a_person_looks_forward_and_has_arms_on_both_sides() -> None:
    model = person(robot("person"))
    head = model.light.vertices[model.light.vertices[:, 2] > 1.5]
    assert float(head[:, 0].max()) > -float(head[:, 0].min()), "the nose"
    assert float(model.paint.vertices[:, 1].max()) > 0.2
    assert float(model.paint.vertices[:, 1].min()) < -0.2


def test_one_of_a_crowd_has_at_most_six_hundred_triangles() -> None:
    assert person(robot("person"), crowd=True).triangles <= 600
