"""Fixed and scripted motor powers, exact to the tick."""

from __future__ import annotations

import pytest

from intellwheels_agents.minds.drive import Mind
from intellwheels_agents.options import OptionError
from intellwheels_schemas.messages import Measures, Robot
from tests.agents.kinematics import RUN, context

ROBOT = Robot(top_speed=1.0)


def powers_at(mind: Mind, tick: int) -> tuple[float | None, float | None]:
    actions = mind.decide(Measures(run=RUN, tick=tick, time=tick * 0.05))
    return actions.left_motor, actions.right_motor


def test_fixed_powers_stay() -> None:
    mind = Mind(context(ROBOT, left="0.5", right="-0.25"))
    assert {powers_at(mind, tick) for tick in range(10)} == {(0.5, -0.25)}


def test_script_changes_powers_at_its_times() -> None:
    mind = Mind(context(ROBOT, script="0.1:0.5,0.5; 0.3:-1,1;"))
    assert [powers_at(mind, tick) for tick in (0, 1, 2, 5, 6, 99)] == [
        (0.0, 0.0), (0.0, 0.0), (0.5, 0.5), (0.5, 0.5), (-1.0, 1.0), (-1.0, 1.0),
    ]  # fmt: skip


@pytest.mark.parametrize("script", ["1", "0:1", "0:1,2", "0:x,1", "1:0,0; 1:0,0", "-1:0,0", "nan:0,0"])
def test_malformed_script_is_refused(script: str) -> None:
    with pytest.raises(OptionError, match="option script: expected"):
        Mind(context(ROBOT, script=script))


def test_message_is_said_once() -> None:
    mind = Mind(context(ROBOT, say="open"))
    said = [mind.decide(Measures(run=RUN, tick=tick, time=0.0)).say for tick in range(3)]
    assert said == ["open", None, None]
