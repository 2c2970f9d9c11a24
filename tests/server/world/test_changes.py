import math
from typing import get_args

import msgspec
import pytest

from intellwheels_schemas.file_records import (
    Change,
    DeleteBody,
    Depart,
    GoOn,
    Join,
    Note,
    Restart,
    SpawnBody,
    Speech,
    TakeBody,
    TeleportBody,
)
from intellwheels_schemas.messages import Encoders, Position, Robot
from intellwheels_server.world import State, apply, digest, measures
from intellwheels_server.world.kernels import rows
from tests.server.worlds import box_wall, cart, do, run, world


def codes(state: State, *changes: Change) -> tuple[State, list[str]]:
    state, outputs = apply(state, changes)
    return state, [event.code for event in outputs.events]


def test_body_is_here_from_the_tick_it_joined_at_until_it_leaves() -> None:
    state = world()
    state, outcome, events = do(state, Join(agent="a", robot=cart(1.0, 2.0, 0.5)))
    assert outcome.position == Position(x=1.0, y=2.0, heading=0.5)
    assert outcome.robot is not None
    assert outcome.robot.name == "a"
    assert [(event.code, event.agent, event.tick) for event in events] == [("joined", "a", 0)]
    state, found = codes(state, Depart(agent="a"))
    assert (state.names, found) == ((), ["left"])


def test_body_whose_token_is_lost_is_lost() -> None:
    assert codes(world({"a": cart()}), Depart(agent="a", lost=True))[1] == ["lost"]


def test_second_body_of_a_name_is_refused() -> None:
    _, outcome, _ = do(world({"a": cart()}), Join(agent="a", robot=cart(3.0)))
    assert (outcome.refused, outcome.text) == ("already-here", "agent 'a' is already here")


def test_mind_joins_a_body_that_is_here_and_leaves_it_standing() -> None:
    mind = Robot(role="mind", user_input=("drive",))
    state, outcome, _ = do(world(), Join(agent="a", robot=mind))
    assert outcome.refused == "no-body"
    state, outcome, _ = do(world({"a": cart(1.0)}), Join(agent="a", robot=mind))
    assert outcome.code == "ok"
    assert outcome.robot is not None
    assert outcome.robot.top_speed == 1.0
    assert state.body_set.models["a"].wants_user
    state, _, _ = do(state, Depart(agent="a", role="mind"))
    assert state.names == ("a",)
    assert not state.body_set.models["a"].wants_user


def test_columns_follow_their_names_when_bodies_come_and_go() -> None:
    state = world({"b": cart(2.0), "d": cart(4.0)})
    state, _ = run(state, 3, {"b": (0.2, 0.2), "d": (-0.2, -0.2)})
    before = {name: state.numbers[:, i].tolist() for i, name in enumerate(state.names)}
    state, outputs = apply(state, [Join(agent="a", robot=cart(0.0)), Join(agent="c", robot=cart(0.0, 5.0))])
    assert state.names == ("a", "b", "c", "d")
    assert [outcome.code for outcome in outputs.outcomes] == ["ok", "ok"]
    state, _ = apply(state, [Depart(agent="a"), Depart(agent="c")])
    assert {name: state.numbers[:, i].tolist() for i, name in enumerate(state.names)} == before


def test_bodies_that_join_at_one_tick_do_not_overlap() -> None:
    _, outputs = apply(world(), [Join(agent="a", robot=cart()), Join(agent="b", robot=cart(0.5))])
    assert [outcome.refused for outcome in outputs.outcomes] == [None, "overlaps"]
    assert outputs.outcomes[1].text == "agent 'b' would overlap agent 'a' at its position"


def test_spawned_body_needs_no_mind_and_can_be_deleted() -> None:
    state, outcome, events = do(
        world(), SpawnBody(robot=cart(name="crate1", top_speed=0.0), position=Position(x=3.0, y=1.0, heading=0.0))
    )
    assert outcome.position == Position(x=3.0, y=1.0, heading=0.0)
    assert [event.code for event in events] == ["spawned"]
    state, found = codes(state, DeleteBody(agent="crate1"))
    assert (state.names, found) == ((), ["deleted"])


def test_spawn_without_a_name_is_refused() -> None:
    assert do(world(), SpawnBody(robot=cart()))[1].refused == "name"


def test_teleported_body_is_there_at_once_and_keeps_its_speed() -> None:
    state, _ = run(world({"a": cart()}), 2, {"a": (1.0, 1.0)})
    state, outcome, events = do(state, TeleportBody(agent="a", position=Position(x=5.0, y=6.0, heading=1.0)))
    assert outcome.code == "ok"
    assert [event.code for event in events] == ["teleported"]
    assert state.numbers[[rows.X, rows.Y, rows.HEADING], 0].tolist() == [5.0, 6.0, 1.0]
    assert state.numbers[rows.LEFT_SPEED, 0] == 1.0
    state, outcome, _ = do(state, TeleportBody(agent="a", position=Position(x=5.0, y=6.0, heading=6.0)))
    assert outcome.position is not None
    assert state.numbers[rows.HEADING, 0] == outcome.position.heading == pytest.approx(6.0 - math.tau, abs=1e-15)


def test_command_that_timed_out_while_the_body_was_taken_does_not_come_back() -> None:
    state, _ = run(world({"a": cart()}), 1, {"a": (1.0, 1.0)})
    state, _ = run(state, 20)
    where = state.numbers[rows.X, 0]
    state, _, _ = do(state, TakeBody(agent="a"))
    state, _ = run(state, 20)
    state, _, _ = do(state, TakeBody(agent="a", on=False))
    state, _ = run(state, 20)
    assert state.numbers[rows.X, 0] == where


def test_body_that_leaves_and_returns_at_one_tick_has_new_sensors() -> None:
    robot = cart(encoders=(Encoders(id="wheels", latency=5),))
    state, _ = run(world({"a": robot}), 20, {"a": (1.0, 1.0)})
    assert measures(state, "a").sensors is not None
    state, _ = apply(state, [Depart(agent="a"), Join(agent="a", robot=robot)])
    assert measures(state, "a").sensors is None


def test_reset_returns_two_bodies_to_a_shared_start_and_both_can_leave() -> None:
    state, _ = run(world({"b": cart()}, command_timeout=10.0), 60, {"b": (1.0, 1.0)})
    state, _, _ = do(state, Join(agent="a", robot=cart()))
    state, outcome, _ = do(state, Restart(run="1" * 16, seed="2"))
    assert outcome.code == "ok", outcome.text
    assert state.numbers[rows.X].tolist() == [0.0, 0.0]
    assert state.numbers[rows.ALLOWED_PENETRATION].tolist() == pytest.approx([0.6, 0.6])
    state, _ = run(state, 60, {"a": (-1.0, -1.0), "b": (1.0, 1.0)})
    assert state.numbers[rows.X].tolist() == pytest.approx([-3.0, 3.0])
    assert state.numbers[rows.ALLOWED_PENETRATION].tolist() == [0.0, 0.0]


def test_teleport_into_something_is_refused_with_the_reason_and_changes_nothing() -> None:
    state = world({"a": cart(), "b": cart(3.0)}, [box_wall(5.0, -1.0, 6.0, 1.0)])
    before = digest(state)
    for x, words in [(3.2, "agent 'b'"), (5.2, "wall 1")]:
        state, outcome, events = do(state, TeleportBody(agent="a", position=Position(x=x, y=0.0, heading=0.0)))
        assert (outcome.code, outcome.refused) == ("failed", "overlaps")
        assert words in outcome.text
        assert not events
    assert digest(state) == before


def test_body_teleported_by_force_may_be_as_deep_as_it_is() -> None:
    state = world({"a": cart()}, [box_wall(5.0, -1.0, 6.0, 1.0)])
    state, outcome, _ = do(state, TeleportBody(agent="a", position=Position(x=4.8, y=0.0, heading=0.0), force=True))
    assert outcome.code == "ok"
    assert state.numbers[rows.ALLOWED_PENETRATION, 0] == pytest.approx(0.3, abs=1e-12)
    state, _ = run(state, 20, {"a": (1.0, 1.0)})
    assert state.numbers[rows.X, 0] == pytest.approx(4.8, abs=1e-9)
    state, _ = run(state, 20, {"a": (-1.0, -1.0)})
    assert state.numbers[rows.X, 0] == pytest.approx(3.8, abs=1e-9)
    assert state.numbers[rows.ALLOWED_PENETRATION, 0] == 0.0


def test_real_chair_cannot_be_teleported() -> None:
    state = world({"a": cart(type="real")})
    _, outcome, _ = do(state, TeleportBody(agent="a", position=Position(x=1.0, y=0.0, heading=0.0)))
    assert outcome.code == "failed"
    assert "real chair" in outcome.text


def test_real_chair_joins_where_it_says_it_is_whatever_stands_there() -> None:
    state = world({"a": cart()})
    state, outcome, _ = do(state, Join(agent="b", robot=cart(0.2, type="real")))
    assert outcome.code == "ok"
    # So deep the two may stay while they part: 0.6 m across is the shortest way out.
    assert state.numbers[rows.ALLOWED_PENETRATION, state.body_set.index["b"]] == pytest.approx(0.6)


@pytest.mark.parametrize(
    "change",
    [
        Depart(agent="x"),
        DeleteBody(agent="x"),
        TeleportBody(agent="x", position=Position(x=0.0, y=0.0, heading=0.0)),
        TakeBody(agent="x"),
        Speech(text="hi", to="x"),
    ],
)
def test_change_of_an_unknown_body_is_not_found(change: Change) -> None:
    _, outcome, events = do(world(), change)
    assert (outcome.code, outcome.text, events) == ("not-found", "no agent 'x' here", ())


def test_operator_is_heard_by_all_or_by_one() -> None:
    state = world({"a": cart(), "b": cart(100.0)})
    state, _ = apply(state, [Speech(text="all"), Speech(text="only b", to="b")])
    # The measures of this tick may be out already: who speaks between two ticks is heard at the next.
    assert measures(state, "b").message == ()
    state, _ = run(state, 1)
    heard = {name: [(one.sender, one.text, one.distance) for one in measures(state, name).message] for name in "ab"}
    assert heard == {"a": [("operator", "all", 0.0)], "b": [("operator", "all", 0.0), ("operator", "only b", 0.0)]}
    state, _ = run(state, 1)
    assert measures(state, "a").message == ()


def test_note_is_an_event_and_nothing_else() -> None:
    state = world({"a": cart()})
    new, found = codes(state, Note(code="speed", speed=2.0), Note(code="paused"))
    assert found == ["speed", "paused"]
    assert digest(new) == digest(state)
    assert new.event_count == state.event_count + 2


def test_go_on_before_an_end_is_no_waiver() -> None:
    assert not do(world(), GoOn())[0].end_waived


def test_every_change_can_be_written_and_read_again() -> None:
    for kind in get_args(Change):
        assert kind.__struct_config__.tag_field == "Do"
    change: Change = TakeBody(agent="a", on=False)
    assert msgspec.json.decode(msgspec.json.encode(change), type=Change) == change


def test_truth_sensor_is_refused_where_truth_is_not_allowed() -> None:
    from intellwheels_schemas.messages import Truth

    robot = cart(truth=(Truth(id="t"),))
    assert do(world(), Join(agent="a", robot=robot))[1].refused == "truth"
    assert do(world(truth=True), Join(agent="a", robot=robot))[1].code == "ok"
