"""What the simulator says becomes what is seen, in whatever order it comes and whatever is lost."""

from __future__ import annotations

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from intellwheels_maps import library
from intellwheels_schemas.messages import Events, Pose, Record, Robot
from intellwheels_viewer.snapshot import EVENTS_KEPT, HISTORY, USER, Snapshot, Utterance
from intellwheels_viewer.state_store import RETURNS, RUNS_KNOWN, StateStore
from tests.viewer.wire import HASH, OTHER, RUN, body, clock, entity, event, info, measures, state


def snapshot(store: StateStore) -> Snapshot:
    return store.snapshot("live", "w", ("w",), "tcp/127.0.0.1:1")


def names(store: StateStore) -> list[str]:
    return [each.name for each in snapshot(store).entities]


@pytest.fixture
def store() -> StateStore:
    made = StateStore()
    for name in "abc":
        made.on_body(body(name))
    return made


# ---------------------------------------------------------------- clocks and runs


def test_the_clock_is_the_one_with_the_newest_stamp(store: StateStore) -> None:
    store.on_clock(clock(5, stamp=100.5))
    store.on_clock(clock(4, stamp=100.4))
    found = snapshot(store).clock
    assert found is not None
    assert found.tick == 5


def test_the_clock_goes_on_after_the_wall_clock_was_set_back(store: StateStore) -> None:
    store.on_clock(clock(5, stamp=7200.0))
    store.on_clock(clock(6, stamp=3600.0))
    assert snapshot(store).clock == clock(6, stamp=3600.0)
    store.on_clock(clock(4, stamp=3599.9))
    assert snapshot(store).clock == clock(6, stamp=3600.0)
    store.on_clock(clock(0, OTHER, stamp=60.0))
    assert snapshot(store).clock == clock(0, OTHER, stamp=60.0)


def test_late_clock_of_a_playback_does_not_undo_a_seek(store: StateStore) -> None:
    for tick, stamp in ((900, 100.0), (5, 100.2), (901, 100.1)):
        store.on_clock(clock(tick, stamp=stamp, last=1000))
    found = snapshot(store).clock
    assert found is not None
    assert found.tick == 5


def test_another_run_makes_the_old_one_forgotten(store: StateStore) -> None:
    store.on_clock(clock(9))
    store.on_state(state(9, entity("a", say="hello")))
    store.on_event(event(0))
    store.on_measures("a", measures(9, 1.0))
    store.on_clock(clock(0, OTHER, stamp=100.1))
    now = snapshot(store)
    assert (now.run, now.tick, now.time) == (OTHER, 0, 0.0)
    assert not any((now.entities, now.events, now.utterances, now.measures, now.history, now.bodies))
    assert store.wants_events_since == 0


@pytest.mark.parametrize(
    "late",
    [
        ("on_clock", clock(12, stamp=100.2)), ("on_state", state(12, entity("a"))), ("on_event", event(3)),
        ("on_body", body("a")), ("on_map_info", info(hash_="0" * 16)),
        ("on_events", Events(run=RUN, oldest=0, next=9, event=(event(8),))),
    ],
)  # fmt: skip
def test_what_comes_late_of_an_old_run_is_not_taken(store: StateStore, late: tuple[str, Record]) -> None:
    store.on_clock(clock(9, stamp=100.0))
    store.on_clock(clock(0, OTHER, stamp=100.1))
    before = snapshot(store)
    getattr(store, late[0])(late[1])
    assert snapshot(store) == before


def test_a_strangers_message_with_another_run_blinds_only_until_the_next_newer_clock(store: StateStore) -> None:
    store.on_clock(clock(9, stamp=100.0))
    store.on_body(body("a", run=OTHER))
    store.on_clock(clock(10, stamp=100.05))
    assert snapshot(store).run == OTHER
    store.on_clock(clock(40, stamp=100.1 + RETURNS))
    assert snapshot(store).run == RUN
    assert store.wants_events_since == 0  # all else is asked for anew


def test_runs_that_are_known_as_past_are_bounded(store: StateStore) -> None:
    for number in range(200):
        store.on_clock(clock(0, f"{number:016x}", stamp=100.0 + number))
    assert len(store._past) == RUNS_KNOWN


# ---------------------------------------------------------------- states


def test_a_state_counts_when_all_its_parts_are_there_and_in_their_order(store: StateStore) -> None:
    store.on_state(state(1, entity("c"), part=1, parts=2))
    assert names(store) == []
    store.on_state(state(1, entity("a"), entity("b"), part=0, parts=2))
    assert names(store) == ["a", "b", "c"]
    assert snapshot(store).tick == 1


def test_a_lost_part_leaves_the_last_whole_state_until_the_next(store: StateStore) -> None:
    store.on_state(state(1, entity("a", 1.0)))
    store.on_state(state(2, entity("a", 2.0), part=0, parts=2))
    store.on_state(state(3, entity("a", 3.0), part=1, parts=2))
    assert snapshot(store).entities[0].x == 1.0
    store.on_state(state(3, entity("b", 3.0), part=0, parts=2))
    assert snapshot(store).tick == 3
    assert names(store) == ["b", "a"]


def test_parts_of_another_division_do_not_mix(store: StateStore) -> None:
    store.on_state(state(1, entity("a"), part=1, parts=3))
    store.on_state(state(1, entity("b"), part=0, parts=2))
    assert names(store) == []
    store.on_state(state(1, entity("c"), part=1, parts=2))
    assert names(store) == ["b", "c"]


def test_parts_beyond_their_number_are_not_kept(store: StateStore) -> None:
    for part in range(2, 50):
        store.on_state(state(1, entity("a"), part=part, parts=2))
    assert store._parts == {}


def test_an_older_tick_is_old_news(store: StateStore) -> None:
    store.on_state(state(5, entity("a", 5.0)))
    store.on_state(state(4, entity("a", 4.0)))
    assert (snapshot(store).tick, snapshot(store).entities[0].x) == (5, 5.0)


def test_bodies_are_seen_to_move_while_the_tick_stands(store: StateStore) -> None:
    store.on_state(state(5, entity("a", 5.0)))
    before = snapshot(store)
    store.on_state(state(5, entity("a", 7.0)))
    assert snapshot(store).entities[0].x == 7.0
    assert snapshot(store).version > before.version


def test_seeking_back_in_a_log_is_followed_and_the_future_forgotten(store: StateStore) -> None:
    store.on_clock(clock(90, last=100))
    for tick in (80, 85, 90):
        store.on_state(state(tick, entity("a", tick / 10, say="later")))
    store.on_measures("a", measures(90, 1.0))
    store.on_state(state(10, entity("a", 1.0)))
    store.on_measures("a", measures(10, 0.5))
    now = snapshot(store)
    assert (now.tick, now.last_tick) == (10, 100)
    assert [sample.time for sample in now.history["a"]] == [pytest.approx(0.5)]
    assert now.utterances == ()
    assert now.measures["a"].tick == 10


def test_only_who_has_a_body_is_seen_and_who_has_none_is_lacked(store: StateStore) -> None:
    store.on_state(state(1, entity("a"), entity("ghost")))
    assert names(store) == ["a"]
    assert store.missing_bodies == {"ghost"}
    store.on_body(body("ghost"))
    assert store.missing_bodies == frozenset()
    assert list(snapshot(store).bodies) == ["a", "ghost"]


def test_a_body_without_a_name_is_nobody_s(store: StateStore) -> None:
    store.on_body(msgspec.structs.replace(body("a"), robot=Robot()))
    assert set(store._bodies) == set("abc")


# ---------------------------------------------------------------- events


def test_a_number_too_high_tells_that_events_were_missed(store: StateStore) -> None:
    store.on_events(Events(run=RUN, oldest=0, next=0))
    store.on_event(event(0))
    assert store.wants_events_since is None
    store.on_event(event(4))
    store.on_event(event(9))
    assert store.wants_events_since == 1
    store.on_events(Events(run=RUN, oldest=0, next=10, event=tuple(event(k) for k in range(1, 10))))
    assert store.wants_events_since is None
    assert [each.number for each in snapshot(store).events] == list(range(10))


def test_events_that_came_twice_are_seen_once(store: StateStore) -> None:
    store.on_event(event(0))
    store.on_events(Events(run=RUN, oldest=0, next=1, event=(event(0),)))
    assert len(snapshot(store).events) == 1


def test_the_newest_events_are_kept(store: StateStore) -> None:
    for number in range(EVENTS_KEPT + 50):
        store.on_event(event(number))
    kept = [each.number for each in snapshot(store).events]
    assert kept == list(range(50, EVENTS_KEPT + 50))


# ---------------------------------------------------------------- measures, words, history


def test_measures_are_the_newest_and_those_of_who_is_there(store: StateStore) -> None:
    store.on_state(state(5, entity("a")))
    store.on_measures("a", measures(5, 1.0))
    store.on_measures("a", measures(4, 2.0))
    store.on_measures("elsewhere", measures(5, 2.0))
    assert {name: found.tick for name, found in snapshot(store).measures.items()} == {"a": 5}
    store.forget(["a", "nobody"])
    assert snapshot(store).measures == {}


def test_words_are_noted_once_while_they_sound_and_again_when_said_again(store: StateStore) -> None:
    for tick, text in ((1, "hi"), (2, "hi"), (3, None), (4, "hi"), (5, "bye")):
        store.on_state(state(tick, entity("a", say=text)))
    assert [(words.text, words.time) for words in snapshot(store).utterances] == [
        ("hi", 0.05), ("hi", pytest.approx(0.2)), ("bye", 0.25),
    ]  # fmt: skip


def test_the_history_has_ten_samples_a_second_of_the_last_seconds(store: StateStore) -> None:
    store.on_measures("a", measures(0, 1.5, 2.5))
    for tick in range(20 * 60):
        store.on_state(state(tick, entity("a", tick * 0.01, speed=0.2)))
    samples = snapshot(store).history["a"]
    assert samples[-1].time - samples[0].time == pytest.approx(HISTORY, abs=0.11)
    assert len(samples) == pytest.approx(HISTORY * 10, abs=2)
    assert samples[-1].ranges == (1.5, 2.5)
    assert samples[-1].speed == 0.2


def test_the_history_of_who_left_does_not_pile_up() -> None:
    store = StateStore()
    for tick in range(500):
        name = f"n{tick}"
        store.on_body(body(name))
        store.on_state(state(tick, entity(name)))
    assert len(store._history) < 20
    assert len(snapshot(store).history) == 1


# ---------------------------------------------------------------- the floor


def test_the_map_is_lacked_until_it_is_the_one_in_use(store: StateStore) -> None:
    room = library.floor("room")
    assert store.map_is_missing
    store.on_floor(room)
    assert not store.map_is_missing
    store.on_map_info(info())
    assert store.map_is_missing
    store.on_floor(room)
    assert not store.map_is_missing
    assert snapshot(store).revision == 0  # the same floor is not drawn again
    store.on_floor(library.floor("ward"))
    assert snapshot(store).revision == 1


def test_the_floor_stays_over_a_new_run_until_another_comes(store: StateStore) -> None:
    store.on_floor(library.floor("room"))
    store.on_clock(clock(0, OTHER, stamp=101.0))
    assert snapshot(store).floor is not None
    assert store.map_is_missing


def test_a_map_that_was_asked_for_before_another_was_loaded_is_not_taken_for_it(store: StateStore) -> None:
    store.on_map_info(info(hash_=HASH))
    asked = store.map_in_use
    store.on_map_info(info(hash_="0" * 16))
    store.on_floor(library.floor("room"), asked)
    assert snapshot(store).floor is None
    assert store.map_is_missing
    store.on_floor(library.floor("ward"), store.map_in_use)
    assert not store.map_is_missing


# ---------------------------------------------------------------- anything at all

_RUNS = st.sampled_from([RUN, OTHER])
_TICKS = st.integers(0, 5)
_NAMES = st.sampled_from("abcd")


def _a_clock(tick: int, run: str, stamp: float, last: int | None) -> tuple[str, tuple[object, ...]]:
    return "on_clock", (clock(tick, run, stamp=stamp, last=last),)


def _a_state(tick: int, run: str, part: int, parts: int, who: list[str]) -> tuple[str, tuple[object, ...]]:
    return "on_state", (state(tick, *map(entity, who), run=run, part=part, parts=parts),)


_ANYTHING = st.one_of(
    st.builds(_a_clock, _TICKS, _RUNS, st.floats(99, 103), st.none() | st.integers(0, 9)),
    st.builds(_a_state, _TICKS, _RUNS, st.integers(0, 3), st.integers(0, 3), st.lists(_NAMES, max_size=3)),
    st.builds(lambda number, run: ("on_event", (event(number, run=run),)), st.integers(0, 9), _RUNS),
    st.builds(lambda name, run: ("on_body", (body(name, run=run),)), _NAMES, _RUNS),
    st.builds(lambda tick, run: ("on_measures", ("a", measures(tick, 1.0, run=run))), _TICKS, _RUNS),
)


@settings(max_examples=150, deadline=None)
@given(st.lists(_ANYTHING, max_size=30))
def test_whatever_comes_in_whatever_order_there_is_something_to_see(
    messages: list[tuple[str, tuple[object, ...]]],
) -> None:
    store = StateStore()
    version = 0
    for method, arguments in messages:
        getattr(store, method)(*arguments)
        now = snapshot(store)
        assert {each.name for each in now.entities} == now.bodies.keys()
        runs = [each.run for each in now.bodies.values()] + [each.run for each in now.events]
        assert set(runs + [each.run for each in now.measures.values()]) <= {now.run}
        assert now.version >= version
        version = now.version


def test_a_reported_pose_is_seen_beside_the_truth_in_a_log_and_in_no_other_world(store: StateStore) -> None:
    pose = Pose(run=RUN, tick=5, x=1.0, y=2.0, heading=0.5)
    store.on_clock(clock(5))
    store.on_state(state(5, entity("a")))
    store.on_reported("a", pose)
    assert snapshot(store).reported == {}
    store.on_clock(msgspec.structs.replace(clock(5, stamp=2e9), last=100))
    before = snapshot(store).version
    for name in ("a", "nobody"):
        store.on_reported(name, pose)
    store.on_reported("a", msgspec.structs.replace(pose, run=OTHER, x=9.0))
    store.on_reported("a", pose)
    assert snapshot(store).reported == {"a": pose}
    assert snapshot(store).version > before
    store.on_state(state(50, entity("a")))  # sought: that of another tick is not shown
    assert snapshot(store).reported == {}


def test_what_a_user_says_is_kept_with_its_time_and_forgotten_with_the_run() -> None:
    store = StateStore()
    store.on_state(state(20, entity("a")))
    version = snapshot(store).version
    store.on_user_speech("hello", "a")
    assert snapshot(store).utterances == (Utterance(USER, 1.0, "hello", "a"),)
    assert snapshot(store).version > version
    store.on_state(state(0, entity("a"), run=OTHER))
    assert snapshot(store).utterances == ()


def test_a_real_body_has_one_steady_speed_in_the_state_and_in_the_history() -> None:
    store = StateStore()
    store.on_body(body("real1", type="real"))
    store.on_body(body("chair1"))
    x = 0.0
    for tick, new in enumerate([1, 0, 2] * 20):
        x += 0.02 * new
        moving = (entity(name, x, speed=0.4 * new) for name in ("chair1", "real1"))
        store.on_state(state(tick, *moving))
    shown = snapshot(store)
    simulated, real = shown.entities
    assert simulated.speed == 0.8
    assert real.speed == pytest.approx(0.4, abs=0.021)
    # The history has every second tick.
    assert shown.history["real1"][-1].speed == pytest.approx(0.4, abs=0.021)
