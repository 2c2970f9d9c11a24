"""Truth: the state itself."""

from __future__ import annotations

import pytest

from intellwheels_schemas.messages import Truth
from intellwheels_server.world import measures
from intellwheels_server.world.kernels import rows
from tests.server.worlds import cart, run, world


def test_truth_is_the_pose_and_the_twist_of_the_last_step_rounded_as_every_reading() -> None:
    state = world({"a": cart(1.0, 2.0, 0.5, truth=(Truth(id="t"),))}, truth=True)
    state, _ = run(state, 7, {"a": (0.4, 0.6)})
    sensors = measures(state, "a").sensors
    assert sensors is not None
    (reading,) = sensors.truth
    assert (reading.id, reading.tick) == ("t", None)
    assert (reading.x, reading.y, reading.heading) == tuple(state.numbers[[rows.X, rows.Y, rows.HEADING], 0].round(6))
    assert reading.speed == pytest.approx(0.5, abs=1e-12)
    assert reading.turn_rate == pytest.approx(0.2 / 0.5, abs=1e-12)
