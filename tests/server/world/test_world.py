import doctest

import msgspec
import numpy as np
import pytest

import intellwheels_server.world
from intellwheels_schemas.file_records import GoOn, Inputs, Join, Restart, TakeBody
from intellwheels_schemas.messages import (
    Actions,
    Compass,
    Encoders,
    End,
    Event,
    Place,
    Position,
    Proximity,
    Reach,
    Timeout,
)
from intellwheels_server.world import advance, apply, digest, entities, measures
from intellwheels_server.world.kernels import rows
from tests.server.worlds import RUN, box_wall, cart, do, floor_of, run, world


def test_example_of_the_documentation_holds() -> None:
    results = doctest.testmod(intellwheels_server.world)
    assert results.attempted > 0
    assert results.failed == 0


def test_measures_of_tick_t_describe_the_state_after_t_steps() -> None:
    state = world({"a": cart()})
    assert measures(state, "a").tick == 0
    state, _ = run(state, 3, {"a": (1.0, 1.0)})
    assert measures(state, "a").tick == 3
    assert measures(state, "a").time == pytest.approx(0.15)
    assert state.numbers[rows.X, 0] == pytest.approx(0.15, abs=1e-12)


def test_advance_does_not_change_its_argument() -> None:
    state = world({"a": cart(proximity=(front(),)), "b": cart(2.0)})
    before = digest(state)
    numbers = state.numbers.copy()
    samples = state.samples.copy()
    advance(state, Inputs(actions={"a": Actions(left_motor=1.0, right_motor=0.5)}))
    assert digest(state) == before
    assert np.array_equal(numbers, state.numbers)
    assert np.array_equal(samples, state.samples)


def test_same_inputs_give_the_same_hashes_and_another_seed_gives_others() -> None:
    def hashes(seed: str) -> list[str]:
        state = world({"a": cart(motor_noise=0.05), "b": cart(3.0)}, seed=seed)
        found = []
        for _ in range(20):
            state, _ = run(state, 1, {"a": (0.7, 0.5), "b": (-0.2, 0.3)})
            found.append(digest(state))
        return found

    assert hashes("1") == hashes("1")
    assert all(one != other for one, other in zip(hashes("1"), hashes("2"), strict=True))


@pytest.mark.parametrize("order", [["a", "b", "c"], ["c", "a", "b"], ["b", "c", "a"]])
def test_hash_does_not_depend_on_the_order_of_joining_or_of_messages(order: list[str]) -> None:
    robots = {name: cart(1.2 * k, motor_noise=0.02) for k, name in enumerate("abc")}
    state = world({name: robots[name] for name in order})
    powers = {name: Actions(left_motor=0.9, right_motor=0.6 + 0.1 * k) for k, name in enumerate("abc")}
    for _ in range(60):
        state, _ = advance(state, Inputs(actions={name: powers[name] for name in order}))
    reference = world(robots)
    for _ in range(60):
        reference, _ = advance(reference, Inputs(actions=powers))
    assert digest(state) == digest(reference)


def test_hash_does_not_depend_on_the_run_s_name() -> None:
    state = world({"a": cart()})
    assert digest(state) == digest(msgspec.structs.replace(state, run="f" * 16))


def test_state_with_a_number_that_is_not_finite_is_a_bug() -> None:
    state = world({"a": cart()})
    state.numbers[rows.X, 0] = np.nan
    with pytest.raises(FloatingPointError, match="expected finite numbers"):
        digest(state)


def test_run_ends_when_all_have_reached_their_places_and_no_step_follows() -> None:
    places = (Place(name="goal", x=1.0, y=0.0),)
    end = End(reach=(Reach(agent="a", place="goal", within=0.1),), timeout=Timeout(seconds=60.0))
    state = world({"a": cart()}, floor=floor_of((), places), end=end)
    events: list[Event] = []
    for _ in range(40):
        state, outputs = advance(state, Inputs(actions={"a": Actions(left_motor=1.0, right_motor=1.0)}))
        events.extend(outputs.events)
        if outputs.ended:
            break
    assert state.tick == 18
    assert state.ended
    assert events[-1].code == "ended"
    assert digest(state) in (events[-1].text or "")
    with pytest.raises(RuntimeError, match="expected GoOn or Restart"):
        advance(state, Inputs())
    state, _ = advance(state, Inputs(changes=(GoOn(),)))
    state, _ = advance(state, Inputs())
    assert state.tick == 20


def test_run_ends_at_its_time_out() -> None:
    state = world({"a": cart()}, end=End(timeout=Timeout(seconds=0.5)))
    ended = [advance(state, Inputs())[1].ended]
    for _ in range(9):
        state, outputs = advance(state, Inputs())
        ended.append(outputs.ended)
    assert not any(ended)
    assert advance(state, Inputs())[1].ended


def test_agent_that_is_not_here_has_reached_nothing() -> None:
    places = (Place(name="goal", x=0.0, y=0.0),)
    end = End(reach=(Reach(agent="ghost", place="goal", within=5.0),), timeout=Timeout(seconds=1.0))
    state = world({"a": cart()}, floor=floor_of((), places), end=end)
    state, events = run(state, 20)
    assert events[-1].text is not None
    assert events[-1].text.startswith("timeout")


def test_reset_begins_a_new_run_that_repeats_the_first() -> None:
    state = world({"a": cart(motor_noise=0.05, encoders=(Encoders(id="w"),))})
    first, _ = run(state, 30, {"a": (1.0, 0.8)})
    state, outcome, events = do(first, Restart(run="fedcba9876543210", seed="1"))
    assert outcome.code == "ok"
    assert (state.run, state.tick, state.names) == ("fedcba9876543210", 0, ("a",))
    assert [(event.run, event.number, event.code) for event in events] == [("fedcba9876543210", 0, "reset")]
    again, _ = run(state, 30, {"a": (1.0, 0.8)})
    assert digest(again) == digest(first)


def test_load_replaces_the_floor_and_counts_revisions() -> None:
    state = world({"a": cart()})
    other = floor_of([box_wall(5.0, -1.0, 6.0, 1.0)], [Place(name="spot", x=2.0, y=0.5, heading_deg=90.0)])
    state, outcome, events = do(state, Restart(run=RUN, seed="2", map=other))
    assert outcome.code == "ok"
    assert events[0].code == "loaded"
    assert (state.revision, state.setup.floor.name, state.setup.seed) == (1, "test", "2")


def test_load_of_a_floor_without_room_changes_nothing() -> None:
    state = world({"a": cart()})
    before = digest(state)
    state, outcome, events = do(state, Restart(run=RUN, seed="2", map=floor_of([box_wall(-9.0, -9.0, 9.0, 9.0)])))
    assert (outcome.code, outcome.refused) == ("failed", "overlaps")
    assert not events
    assert digest(state) == before


def test_taken_body_obeys_its_user_and_a_released_one_its_mind() -> None:
    state = world({"a": cart()})
    state, _, events = do(state, TakeBody(agent="a"))
    assert [event.code for event in events] == ["taken"]
    state, _ = run(state, 5, {"a": (1.0, 1.0)})
    assert state.numbers[rows.X, 0] == 0.0
    assert entities(state)[0].state == "taken"
    state, _, events = do(state, TakeBody(agent="a", on=False))
    assert [event.code for event in events] == ["released"]
    state, _ = run(state, 1, {"a": (1.0, 1.0)})
    assert state.numbers[rows.X, 0] == pytest.approx(0.05)


def test_nothing_to_apply_changes_nothing() -> None:
    state = world({"a": cart()})
    assert apply(state, [])[0] is state


def front() -> Proximity:
    return Proximity(id="front", x=0.5, y=0.0, z=0.4, direction_deg=0.0, cone_deg=30.0, max_range=4.0)


def test_joining_agent_changes_nobody_else_s_noise() -> None:
    def headings(robots: dict[str, object]) -> list[float | None]:
        state = world(robots)  # type: ignore[arg-type]
        found = []
        for _ in range(10):
            state, _ = run(state, 1)
            sensors = measures(state, "b").sensors
            assert sensors is not None
            found.append(sensors.compass[0].value)
        return found

    chair = cart(5.0, compass=(Compass(id="c", noise_deg=2.0),))
    assert headings({"b": chair}) == headings({"a": cart(compass=(Compass(id="c", noise_deg=2.0),)), "b": chair})


def test_positions_in_the_world_s_state_are_rounded_and_in_the_order_of_names() -> None:
    state = world({"b": cart(0.123456789, 1.0), "a": cart(3.0)})
    assert [(one.name, one.x) for one in entities(state)] == [("a", 3.0), ("b", 0.123457)]


def test_refused_join_changes_nothing() -> None:
    state = world({"a": cart()})
    before = digest(state)
    for robot, code in [
        (cart(0.2), "overlaps"),
        (cart(place="nowhere"), "no-place"),
        (cart(position=None), "no-place"),
    ]:
        state, outcome, events = do(state, Join(agent="b", robot=robot))
        assert (outcome.code, outcome.refused, events) == ("failed", code, ())
    assert digest(state) == before


def test_pose_after_a_quarter_turn_in_place() -> None:
    state = world({"a": cart()})
    # Wheels at -v and v turn by 2 v T / track a tick: 0.5 rad/s at v = 0.125 m/s.
    state, _ = run(state, 20, {"a": (-0.125, 0.125)})
    assert state.numbers[rows.HEADING, 0] == pytest.approx(0.5, abs=1e-12)
    assert (state.numbers[rows.X, 0], state.numbers[rows.Y, 0]) == (0.0, 0.0)
    assert Position(x=0.0, y=0.0, heading=0.0) is not None
