import math

import pytest

from intellwheels_schemas.codec import Encoding, decode, encode
from intellwheels_schemas.file_records import Inputs, TakeBody, Verdict
from intellwheels_schemas.messages import Actions, Measures, MotorState, Pose, WorldState
from intellwheels_server.world import advance, entities, measures, power_in_force
from tests.every_case import every_case
from tests.server.worlds import cart, run, world


def test_power_in_force_is_the_command_and_then_nothing_once_it_is_too_old() -> None:
    state = world({"a": cart(type="real")})
    state, _ = advance(state, Inputs(actions={"a": Actions(left_motor=0.5, right_motor=-0.5)}))
    power = power_in_force(state, "a")
    assert (power.tick, power.left_motor, power.right_motor, power.state) == (1, 0.5, -0.5, "drive")
    state, events = run(state, 10)
    power = power_in_force(state, "a")
    assert (power.left_motor, power.right_motor, power.state) == (0.0, 0.0, "timeout")
    assert [(event.code, event.agent) for event in events] == [("timeout", "a")]


def test_robot_may_ask_for_its_own_time_out() -> None:
    state = world({"a": cart(command_timeout=0.1)})
    state, _ = advance(state, Inputs(actions={"a": Actions(left_motor=1.0, right_motor=1.0)}))
    state, _ = run(state, 10)
    assert entities(state)[0].x == pytest.approx(0.1)


def test_time_out_is_reported_once_per_command() -> None:
    state = world({"a": cart()})
    codes = []
    for _ in range(2):
        state, _ = advance(state, Inputs(actions={"a": Actions(left_motor=1.0, right_motor=1.0)}))
        state, events = run(state, 30)
        codes.append([event.code for event in events])
    assert codes == [["timeout"], ["timeout"]]


def test_body_without_motors_never_times_out() -> None:
    state, events = run(world({"a": cart(top_speed=0.0)}), 30)
    assert entities(state)[0].state == "drive"
    assert not events


@every_case("encoding", [Encoding.JSON, Encoding.XML])
@every_case(
    ("inputs", "told"),
    [
        (Inputs(verdicts=(Verdict(agent="a", code="rested"),)), "rested"),
        (Inputs(verdicts=(Verdict(agent="a", code="stale"),)), "stale"),
        (Inputs(verdicts=(Verdict(agent="a", code="halt"),)), "paused"),
        (Inputs(changes=(TakeBody(agent="a"),)), "taken"),
    ],
)
def test_agent_is_told_why_its_body_does_not_obey(inputs: Inputs, told: MotorState, encoding: Encoding) -> None:
    state, _ = advance(world({"a": cart(type="real")}), Inputs(actions={"a": Actions(left_motor=0.5, right_motor=0.5)}))
    state, _ = advance(state, inputs)
    message = decode(Measures, encode(measures(state, "a"), encoding), encoding)
    assert message.state == told
    assert message.state == entities(state)[0].state == power_in_force(state, "a").state


def test_agent_whose_commands_are_too_old_is_told_and_one_that_drives_is_not() -> None:
    state, _ = advance(world({"a": cart()}), Inputs(actions={"a": Actions(left_motor=0.5, right_motor=0.5)}))
    assert b"State" not in encode(measures(state, "a"))
    state, _ = run(state, 10)
    assert b'"State":"timeout"' in encode(measures(state, "a"))
    state, _ = advance(state, Inputs(actions={"a": Actions(left_motor=0.5, right_motor=0.5)}))
    assert b"State" not in encode(measures(state, "a"))


def test_unknown_body_has_no_measures() -> None:
    with pytest.raises(KeyError):
        measures(world(), "a")


def test_speed_after_a_jump_is_limited_to_the_range_of_a_message() -> None:
    state = world({"a": cart(type="real")})
    state, _ = advance(state, Inputs(poses={"a": Pose(x=10_000.0, y=-10_000.0, heading=3.0)}))
    (entity,) = entities(state)
    message = WorldState(run=state.run, tick=state.tick, time=state.time, entity=(entity,))
    assert decode(WorldState, encode(message)) == message
    assert abs(entity.speed) == 100.0


def test_rounded_heading_stays_in_its_range() -> None:
    for heading in (math.pi, -math.pi + 1e-9):
        assert entities(world({"a": cart(heading=heading)}))[0].heading == math.pi


def test_state_shows_the_output_of_the_papers_formula_beside_the_mean_speed_of_the_tick() -> None:
    state = world({"a": cart(acceleration_curve=0.5), "box": cart(9.0, top_speed=0.0)})
    shown = []
    for _ in range(3):
        state, _ = run(state, 1, {"a": (1.0, -1.0)})
        shown.append((entities(state)[0].left_output, entities(state)[0].right_output))
    assert shown == [(0.5, -0.5), (0.75, -0.75), (0.875, -0.875)]
    state = world({"a": cart(acceleration_curve=0.5), "box": cart(9.0, top_speed=0.0)})
    speeds = []
    for _ in range(3):
        state, _ = run(state, 1, {"a": (1.0, 1.0)})
        speeds.append(round(entities(state)[0].speed, 4))
    assert speeds == [0.2787, 0.6393, 0.8197]
    assert (entities(state)[1].left_output, entities(state)[1].right_output) == (0.0, 0.0)


def test_output_of_wheels_that_differ_is_a_share_of_their_own_full_speed() -> None:
    state = world({"a": cart(wheel_ratio=1.1, wheel_scale=0.9, acceleration_curve=0.5)})
    state, _ = run(state, 100, {"a": (1.0, 0.5)})
    (entity,) = entities(state)
    assert (entity.left_output, entity.right_output) == (1.0, 0.5)
