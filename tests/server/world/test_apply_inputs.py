import math

import pytest

from intellwheels_schemas.file_records import Depart, Inputs, Said, TakeBody, Verdict
from intellwheels_schemas.messages import Actions, Goal, Pose, Proximity, ProximityReading, Sensors, UserInput
from intellwheels_server.world import State, advance, entities, measures
from intellwheels_server.world.kernels import rows
from tests.server.worlds import cart, do, run, world


def act(state: State, **actions: Actions) -> State:
    return advance(state, Inputs(actions=actions))[0]


def test_motor_that_is_left_out_keeps_its_command() -> None:
    state = act(world({"a": cart()}), a=Actions(left_motor=0.5, right_motor=0.5))
    state = act(state, a=Actions(left_motor=0.2))
    assert state.numbers[rows.SPEED, 0] == pytest.approx(0.35)


def test_motor_that_one_of_many_leaves_out_keeps_its_command_too() -> None:
    names = [f"a{k:02d}" for k in range(40)]
    state = world({name: cart(x=3.0 * k) for k, name in enumerate(names)})
    both = {name: Actions(left_motor=0.5, right_motor=-0.5) for name in names}
    state = act(state, **both)
    assert state.numbers[rows.LEFT_COMMAND].tolist() == [0.5] * 40
    state = act(state, **{**both, "a07": Actions(right_motor=0.25)})
    assert state.numbers[rows.LEFT_COMMAND].tolist() == [0.5] * 40
    assert state.numbers[rows.RIGHT_COMMAND, 6:9].tolist() == [-0.5, 0.25, -0.5]
    state = act(state, **both, ghost=Actions(left_motor=1.0, right_motor=1.0))
    assert state.numbers[rows.RIGHT_COMMAND].tolist() == [-0.5] * 40


def test_actions_without_motors_do_not_restart_the_time_out() -> None:
    state = act(world({"a": cart()}), a=Actions(left_motor=1.0, right_motor=1.0))
    for _ in range(30):
        state = act(state, a=Actions(mode="idle"))
    # 0.5 s of the default time-out at 1 m/s, then nothing.
    assert state.numbers[rows.X, 0] == pytest.approx(0.5, abs=1e-12)


def test_actions_of_an_unknown_agent_are_ignored() -> None:
    state = act(world({"a": cart()}), ghost=Actions(left_motor=1.0, say="boo"))
    assert measures(state, "a").message == ()


def test_mode_and_goal_stand_until_replaced() -> None:
    state = act(world({"a": cart()}), a=Actions(mode="autonomous", goal=Goal(x=1.0, y=2.0)))
    state = act(state, a=Actions())
    entity = entities(state)[0]
    assert (entity.mode, entity.goal) == ("autonomous", Goal(x=1.0, y=2.0))


def test_what_is_said_at_t_is_heard_at_t_plus_1_and_shown_for_three_seconds() -> None:
    state = world({"a": cart(), "b": cart(3.0), "c": cart(20.0)})
    state = act(state, a=Actions(seq=7, say="follow me"))
    heard = measures(state, "b").message
    assert [(one.sender, one.tick, one.seq, one.distance, one.text) for one in heard] == [("a", 0, 7, 3.0, "follow me")]
    assert measures(state, "a").message == ()
    assert measures(state, "c").message == ()
    assert entities(state)[0].say == "follow me"
    state, _ = run(state, 60)
    assert measures(state, "b").message == ()
    assert entities(state)[0].say == "follow me"
    state, _ = run(state, 1)
    assert entities(state)[0].say is None


def test_say_on_its_own_key_is_heard_too_and_one_counts_per_tick() -> None:
    state = world({"a": cart(), "b": cart(3.0)})
    inputs = Inputs(actions={"a": Actions(say="one")}, says=(Said(agent="a", text="two"), Said(agent="b", text="yes")))
    state, _ = advance(state, inputs)
    assert [one.text for one in measures(state, "b").message] == ["one"]
    assert [one.text for one in measures(state, "a").message] == ["yes"]


def test_measures_carry_declared_user_input_without_its_lease() -> None:
    state = world({"a": cart(user_input=("drive",)), "b": cart(3.0)})
    wish = UserInput(lease="0" * 16, seq=3, forward=0.5, word="left", goal=Goal(x=1.0, y=1.0))
    state, _ = advance(state, Inputs(user_input={"a": wish, "b": wish}))
    assert measures(state, "a").user_input == UserInput(seq=3, forward=0.5, word="left", goal=Goal(x=1.0, y=1.0))
    assert measures(state, "b").user_input is None


def test_input_of_a_silent_user_is_zero() -> None:
    state = world({"a": cart(user_input=("drive",))})
    state, _ = advance(state, Inputs(user_input={"a": UserInput(seq=3, forward=0.5, word="left")}))
    state, _ = advance(state, Inputs(verdicts=(Verdict(agent="a", code="silent"),)))
    assert measures(state, "a").user_input == UserInput(seq=3)


def test_in_strict_lockstep_silence_is_counted_in_simulated_time() -> None:
    state = world({"a": cart(user_input=("drive",))}, strict=True)
    state, _, _ = do(state, TakeBody(agent="a"))
    state, _ = advance(state, Inputs(user_input={"a": UserInput(seq=1, forward=1.0)}))
    state, _ = run(state, 20)
    # 0.3 s at 1 m/s.
    assert state.numbers[rows.X, 0] == pytest.approx(0.3, abs=1e-12)
    assert measures(state, "a").user_input == UserInput(seq=1)


def test_user_s_turn_is_to_the_left_and_never_more_than_full_power() -> None:
    state, _, _ = do(world({"a": cart()}), TakeBody(agent="a"))
    state, _ = advance(state, Inputs(user_input={"a": UserInput(forward=1.0, turn=1.0)}))
    # left = 0, right = 2, both halved.
    assert state.numbers[rows.SPEED, 0] == pytest.approx(0.5)
    assert state.numbers[rows.TURN_RATE, 0] == pytest.approx(2.0)


def test_real_chair_is_at_its_reported_pose_in_the_next_state() -> None:
    state = world({"a": cart(type="real"), "b": cart(9.0)})
    pose = Pose(x=0.04, y=0.0, heading=0.1)
    state, _ = advance(state, Inputs(poses={"a": pose, "b": pose}))
    assert state.numbers[[rows.X, rows.Y, rows.HEADING], 0].tolist() == [0.04, 0.0, 0.1]
    assert state.numbers[rows.SPEED, 0] == pytest.approx(0.8)
    assert state.numbers[rows.TURN_RATE, 0] == pytest.approx(2.0)
    assert state.numbers[rows.X, 1] == 9.0


def test_speed_of_a_real_chair_is_over_the_time_since_its_last_pose() -> None:
    state = world({"a": cart(type="real")})
    x = 0.0
    for silent in (0, 0, 2, 0):
        for _ in range(silent):
            state, _ = advance(state, Inputs())
        x += 0.04 * (silent + 1)
        state, _ = advance(state, Inputs(poses={"a": Pose(x=x, y=0.0, heading=0.0)}))
        assert state.numbers[rows.SPEED, 0] == pytest.approx(0.8)


def test_agent_that_leaves_is_heard_from_where_it_spoke() -> None:
    state = world({"a": cart(), "b": cart(3.0)})
    state = act(state, a=Actions(say="bye"))
    state, _, _ = do(state, Depart(agent="a"))
    assert [(one.sender, one.distance) for one in measures(state, "b").message] == [("a", 3.0)]


def test_heading_of_a_pose_is_brought_into_its_range() -> None:
    state = world({"a": cart(type="real")})
    for given, kept in [(3 * math.pi / 2, -math.pi / 2), (-math.pi, math.pi), (2 * math.pi, 0.0)]:
        state, _ = advance(state, Inputs(poses={"a": Pose(x=0.0, y=0.0, heading=given)}))
        assert state.numbers[rows.HEADING, 0] == pytest.approx(kept, abs=1e-15)


def test_real_chair_is_never_moved_by_its_power() -> None:
    state = world({"a": cart(type="real")})
    state, _ = run(state, 5, {"a": (1.0, 1.0)})
    assert state.numbers[rows.X, 0] == 0.0


def test_real_chair_that_falls_silent_is_stale_by_simulated_time_and_fresh_again() -> None:
    state = world({"a": cart(type="real")}, strict=True)
    pose = Inputs(poses={"a": Pose(x=0.0, y=0.0, heading=0.0)})
    state, _ = advance(state, pose)
    state, events = run(state, 6)
    assert [(event.code, event.tick) for event in events] == [("stale", 7)]
    assert entities(state)[0].state == "stale"
    state, outputs = advance(state, pose)
    assert [event.code for event in outputs.events] == ["fresh"]
    assert entities(state)[0].state == "drive"


def test_real_chair_s_own_sensors_reach_its_mind_beside_the_virtual_ones_and_no_others_do() -> None:
    def sonar(name: str, source: str) -> Proximity:
        return Proximity(
            id=name,
            x=0.5,
            y=0.0,
            z=0.4,
            direction_deg=0.0,
            cone_deg=30.0,
            max_range=4.0,
            source=source,  # type: ignore[arg-type]
        )

    state = world({"a": cart(type="real", proximity=(sonar("virtual", "simulated"), sonar("own", "real")))})
    readings = (ProximityReading(id="own", value=1.5), ProximityReading(id="virtual", value=0.1))
    pose = Pose(x=0.0, y=0.0, heading=0.0, sensors=Sensors(proximity=readings))
    for inputs in (Inputs(poses={"a": pose}), Inputs()):
        state, _ = advance(state, inputs)
        sensors = measures(state, "a").sensors
        assert sensors is not None
        # What the bridge has not told anew was sampled when it told it.
        assert [(one.id, one.value, one.status, one.tick) for one in sensors.proximity] == [
            ("virtual", None, "none", None),
            ("own", 1.5, "ok", None if inputs.poses else 1),
        ]


@pytest.mark.parametrize(
    ("code", "state_word", "back"),
    [("rested", "rested", "back"), ("halt", "paused", "unhalt"), ("stale", "stale", "fresh")],
)
def test_verdict_stops_a_body_until_the_opposite_verdict(code: str, state_word: str, back: str) -> None:
    state = world({"a": cart()})
    go = {"a": Actions(left_motor=1.0, right_motor=1.0)}
    state, _ = advance(state, Inputs(actions=go, verdicts=(Verdict(agent="a", code=code),)))  # type: ignore[arg-type]
    assert entities(state)[0].state == state_word
    assert state.numbers[rows.X, 0] == 0.0
    state, _ = advance(state, Inputs(actions=go, verdicts=(Verdict(agent="a", code=back),)))  # type: ignore[arg-type]
    assert state.numbers[rows.X, 0] == pytest.approx(0.05)


def test_late_answer_is_an_event_and_changes_no_body() -> None:
    _, outputs = advance(
        world({"a": cart()}), Inputs(verdicts=(Verdict(agent="a", code="late"), Verdict(agent="x", code="late")))
    )
    assert [(event.code, event.agent) for event in outputs.events] == [("late", "a")]
