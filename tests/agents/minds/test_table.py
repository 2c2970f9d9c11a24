"""A table answers and does nothing."""

from __future__ import annotations

from intellwheels_agents.minds.table import Mind
from intellwheels_schemas.messages import Actions, Measures, Robot
from tests.agents.kinematics import RUN, context


def test_table_does_nothing() -> None:
    assert Mind(context(Robot())).decide(Measures(run=RUN, tick=0, time=0.0)) == Actions()
