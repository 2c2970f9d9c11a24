import msgspec
import pytest

from intellwheels_maps import robot
from intellwheels_schemas.codec import decode, encode
from intellwheels_schemas.messages import Event, Part, Position
from intellwheels_server.world import entities, measures
from intellwheels_server.world.kernels import rows
from tests.server.worlds import box_wall, cart, run, world


def test_running_into_a_wall_is_one_episode_with_its_point_normal_and_closing_speed() -> None:
    state = world({"a": cart()}, [box_wall(1.0, -2.0, 2.0, 2.0)])
    state, events = run(state, 40, {"a": (0.6, 0.6)})
    assert [event.code for event in events] == ["contact"]
    event = events[0]
    assert (event.agent, event.other, event.part, event.other_part) == ("a", "wall", 0, 0)
    # The point lies in both as they were proposed: at most a sub-step, 2 cm, inside the wall.
    assert event.x == pytest.approx(1.0, abs=0.02)
    assert event.y == pytest.approx(0.0, abs=0.31)
    assert (event.normal_x, event.normal_y) == (-1.0, 0.0)
    assert event.speed == pytest.approx(0.6)
    entity = entities(state)[0]
    assert (entity.contacts, entity.collision, entity.contact) == (1, True, True)
    assert (measures(state, "a").collision, measures(state, "a").contact) == (True, True)


def test_body_that_is_hit_is_in_contact_and_did_not_collide() -> None:
    state = world({"a": cart(), "b": cart(1.5)})
    state, events = run(state, 15, {"a": (1.0, 1.0)})
    assert [(event.code, event.agent, event.other) for event in events] == [("contact", "a", "b")]
    first, second = entities(state)
    assert (first.contacts, first.collision, first.contact) == (1, True, True)
    assert (second.contacts, second.collision, second.contact) == (1, False, True)


def test_event_names_the_body_that_ran_into_the_other_first() -> None:
    state = world({"a": cart(1.5), "b": cart()})
    _, events = run(state, 15, {"b": (1.0, 1.0)})
    assert (events[0].agent, events[0].other) == ("b", "a")
    assert events[0].normal_x == -1.0


def test_episode_ends_a_quarter_of_a_second_after_the_last_touch() -> None:
    state = world({"a": cart()}, [box_wall(0.6, -2.0, 2.0, 2.0)])
    state, events = run(state, 10, {"a": (0.6, 0.6)})
    last_touch = state.tick
    state, events = run(state, 10, {"a": (-0.2, -0.2)})
    assert [(event.code, event.agent, event.other) for event in events] == [("parted", "a", "wall")]
    assert events[0].tick == last_touch + 5
    assert not entities(state)[0].contact


def test_touching_again_within_the_pause_counts_once_and_after_it_twice() -> None:
    state = world({"a": cart()}, [box_wall(0.6, -2.0, 2.0, 2.0)])
    state, _ = run(state, 6, {"a": (0.6, 0.6)})
    state, _ = run(state, 2, {"a": (-0.1, -0.1)})
    state, _ = run(state, 6, {"a": (0.6, 0.6)})
    assert state.flags[rows.CONTACTS, 0] == 1
    state, _ = run(state, 10, {"a": (-0.1, -0.1)})
    state, _ = run(state, 6, {"a": (0.6, 0.6)})
    assert state.flags[rows.CONTACTS, 0] == 2


def test_episode_of_a_body_that_left_is_forgotten() -> None:
    from intellwheels_schemas.file_records import Depart
    from tests.server.worlds import do

    state = world({"a": cart(), "b": cart(1.1)})
    state, _ = run(state, 5, {"a": (1.0, 1.0)})
    assert len(state.episodes) == 1
    state, _, _ = do(state, Depart(agent="b"))
    assert len(state.episodes) == 0


def test_real_chair_moved_into_another_flags_both_and_pushes_nobody() -> None:
    from intellwheels_schemas.file_records import Inputs
    from intellwheels_schemas.messages import Pose
    from intellwheels_server.world import advance

    state = world({"a": cart(type="real"), "b": cart(3.0)})
    state, outputs = advance(state, Inputs(poses={"a": Pose(x=2.5, y=0.0, heading=0.0)}))
    assert [(event.code, event.agent, event.other) for event in outputs.events] == [("contact", "a", "b")]
    first, second = entities(state)
    assert (first.contact, second.contact, second.x) == (True, True, 3.0)
    # What it was put into can leave.
    state, _ = run(state, 20, {"b": (0.5, 0.5)})
    assert entities(state)[1].x == pytest.approx(3.5)


def test_parts_are_counted_from_each_body_s_first() -> None:
    parts = (
        Part(x=-0.5, y=0.0, length=0.4, width=0.4, bottom=0.0, top=1.0),
        Part(x=0.5, y=0.0, length=0.4, width=0.4, bottom=0.0, top=1.0),
    )
    two = cart(0.0, length=None, width=None, center=None, top=None, part=parts)
    other = cart(2.0, length=None, width=None, center=None, top=None, part=parts)
    state = world({"a": two, "b": other}, [box_wall(3.0, -1.0, 4.0, 1.0)])
    _, events = run(state, 40, {"a": (1.0, 1.0), "b": (0.5, 0.5)})
    found = {(event.agent, event.other): (event.part, event.other_part) for event in events if event.code == "contact"}
    assert found == {("b", "wall"): (1, 0), ("a", "b"): (1, 0)}


def test_upper_body_of_a_chair_hits_a_table_s_top_under_which_its_base_has_gone() -> None:
    chair = msgspec.structs.replace(robot("rear-wheel"), position=Position(x=0.0, y=0.0, heading=0.0))
    table = msgspec.structs.replace(robot("table"), position=Position(x=4.0, y=0.0, heading=0.0))
    state = world({"chair": chair, "table": table})
    state, events = run(state, 120, {"chair": (0.5, 0.5)})
    (event,) = [event for event in events if event.code == "contact"]
    base, upper = chair.part
    top = table.part[event.other_part or 0]
    assert (event.agent, event.other, event.part) == ("chair", "table", 1)
    assert (top.bottom, top.top) == (0.69, 0.72)
    x = entities(state)[0].x
    edge = 4.0 + top.x - top.length / 2
    # The base is as far under the top as the upper body stands behind it.
    assert x + upper.x + upper.length / 2 == pytest.approx(edge, abs=1e-6)
    assert x + base.x + base.length / 2 > edge + 0.1


def test_touch_beyond_the_edge_of_the_world_is_reported_at_the_edge() -> None:
    state = world({"a": cart(10_000.0), "b": cart(10_000.0, 0.7, heading=0.1)})
    _, events = run(state, 5, {"b": (0.5, -0.5)})
    event = next(event for event in events if event.code == "contact")
    assert event.x == 10_000.0
    assert decode(Event, encode(event)) == event
