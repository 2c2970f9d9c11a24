from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import viser

from intellwheels_schemas.messages import Event
from intellwheels_viewer.drawings.contact_flashes import Contacts, flashes, star
from tests.viewer.drawings.cast import RUN, node


def event(tick: int, **fields: Any) -> Event:
    return Event(**{"run": RUN, "tick": tick, "number": tick, "code": "contact", "x": 1.0, "y": 2.0, **fields})


def test_a_flash_fades_within_half_a_second_of_simulated_time() -> None:
    left = [[flash.left for flash in flashes([event(10)], tick, 0.05)] for tick in (9, 10, 15, 19, 20)]
    assert left[0] == left[4] == []
    assert [each[0] for each in left[1:4]] == pytest.approx([1.0, 0.5, 0.1])


def test_other_events_and_contacts_without_a_point_do_not_flash() -> None:
    assert flashes([event(1, code="parted"), event(1, x=None)], 1, 0.05) == []


def test_the_star_is_as_wide_as_a_wheel() -> None:
    assert float(np.hypot(*star().vertices[:, :2].T).max()) == pytest.approx(0.28)


def test_it_is_seen_at_the_point_and_gone_after(scene: viser.SceneApi) -> None:
    contacts = Contacts(scene)
    contacts.show([event(10)], 12, 0.05)
    handle = node(scene, "/contacts")
    assert handle.batched_positions[0, :2].tolist() == [1.0, 2.0]
    assert handle.batched_opacities == pytest.approx([0.8])
    contacts.show([event(10)], 30, 0.05)
    assert not handle.visible
