"""A world as messages of ROS for a bag."""

from __future__ import annotations

import math

import pytest
from msgspec.structs import replace

from intellwheels_agents.record_gateway import ros_translator
from intellwheels_agents.record_gateway.ros_translator import PATIENCE, BagEntry, RosTranslator
from intellwheels_agents.record_gateway.translator import Translator
from intellwheels_maps import floor, robot
from intellwheels_schemas.codec import encode
from intellwheels_schemas.file_records import Inputs, Join
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import (
    Body,
    Clock,
    Entity,
    Measures,
    OdometryReading,
    Record,
    Robot,
    Sensors,
    WorldState,
)
from intellwheels_server.world import Setup, advance, apply, begin, measures

RUN = "0123456789abcdef"
KEYS = Keys("bag")
JSON = "application/json"


class Both:
    """The translator of a recording, and that of a bag behind it, as the recorder has them."""

    def __init__(self) -> None:
        self.translator = Translator(KEYS, lambda: 1000.0)
        self.ros = RosTranslator(KEYS, self.translator)

    def take(self, key: str, message: Record | bytes) -> list[BagEntry]:
        data = message if isinstance(message, bytes) else encode(message)
        self.translator.take(key, data, JSON)
        return self.ros.take(key, data, JSON)

    def body(self, agent: str = "c", of: Robot | None = None) -> None:
        self.take(KEYS.body(agent), Body(run=RUN, tick=0, robot=of or robot("lidar-chair")))

    def clock(self, tick: int) -> list[BagEntry]:
        return self.take(KEYS.clock, Clock(run=RUN, tick=tick, time=tick * 0.05, state="running", pace="realtime",
                                           hash=RUN, stamp=1.0))  # fmt: skip

    def state(self, tick: int, *agents: str) -> list[BagEntry]:
        entities = tuple(Entity(name=agent, x=3.0, y=2.0, heading=math.pi / 2) for agent in agents or ("c",))
        return self.take(KEYS.state(0), WorldState(run=RUN, tick=tick, time=tick * 0.05, entity=entities))


def sensed(ticks: int) -> list[Measures]:
    state = begin(Setup(floor=floor("room"), seed="1"), run=RUN)
    state, _ = apply(state, [Join(agent="c", robot=robot("lidar-chair"))])
    found = []
    for _ in range(ticks):
        state, _ = advance(state, Inputs())
        found.append(measures(state, "c"))
    return found


def names(entries: list[BagEntry]) -> list[str]:
    return [entry.topic.name for entry in entries]


def test_a_chair_begins_where_it_truly_is_and_has_the_topics_of_iw_ros() -> None:
    both, ticks = Both(), sensed(3)
    both.body()
    assert names(both.clock(1)) == ["/clock"]
    assert both.take(KEYS.measures("c"), ticks[0]) == []
    first = both.state(1)
    assert names(first)[0] == "/tf_static"
    assert {"/c/odom", "/tf", "/c/scan", "/c/imu", "/diagnostics"} <= set(names(first))
    (tf,) = (entry for entry in first if entry.topic.name == "/tf")
    change = tf.message.transforms[0]
    assert (change.header.frame_id, change.child_frame_id) == ("map", "c/odom")
    assert change.transform.translation.x == pytest.approx(3.0)
    # The recording began with the body at 1000 s, and the run at 0.
    assert {entry.time for entry in first} == {1_000_050_000_000}
    second = both.take(KEYS.measures("c"), ticks[1])
    assert "/tf_static" not in names(second)
    assert {entry.time for entry in second} == {1_000_100_000_000}
    assert all(entry.topic.qos.transient_local for entry in first if entry.topic.name == "/tf_static")


def test_the_state_may_come_first_and_the_clock_counts_once() -> None:
    both, ticks = Both(), sensed(1)
    both.body()
    both.clock(1)
    assert both.clock(1) == []
    both.state(1)
    assert "/c/odom" in names(both.take(KEYS.measures("c"), ticks[0]))


def test_a_state_in_parts_and_an_older_one_keep_the_poses() -> None:
    both, ticks = Both(), sensed(3)
    for agent in ("c", "d"):
        both.body(agent)
    both.clock(2)
    for part, agent in enumerate(("c", "d")):
        entity = Entity(name=agent, x=3.0, y=2.0, heading=0.0)
        state = WorldState(run=RUN, tick=2, time=0.1, part=part, parts=2, entity=(entity,))
        both.take(KEYS.state(part), state)
    both.state(1, "other")
    for agent in ("c", "d"):
        assert "/tf_static" in names(both.take(KEYS.measures(agent), ticks[1]))


def test_another_robot_of_the_same_name_begins_anew() -> None:
    both, ticks = Both(), sensed(2)
    for tick, kind in ((1, "lidar-chair"), (2, "intellwheels")):
        both.body(of=robot(kind))
        both.clock(tick)
        both.state(tick)
        assert "/tf_static" in names(both.take(KEYS.measures("c"), ticks[tick - 1]))


def test_without_true_poses_a_chair_goes_without_a_place_on_the_map() -> None:
    both, ticks = Both(), sensed(PATIENCE + 2)
    both.body()
    both.clock(1)
    found = [both.take(KEYS.measures("c"), one) for one in ticks]
    began = next(entries for entries in found if entries)
    (tf,) = (entry for entry in began if entry.topic.name == "/tf")
    assert [change.header.frame_id for change in tf.message.transforms] == ["c/odom"]


def test_a_new_run_begins_anew_and_a_stranger_does_not_count() -> None:
    both, ticks = Both(), sensed(1)
    both.body()
    both.clock(1)
    both.state(1)
    both.take(KEYS.measures("c"), ticks[0])
    for data in (b"", b"{", b"\xff" * 30, b"[" * 10_000):
        for key in (KEYS.clock, KEYS.state(0), KEYS.measures("c"), KEYS.map, "x/y"):
            assert both.take(key, data) == []
    assert both.take(KEYS.measures("nobody"), ticks[0]) == []
    forged = ticks[0].__class__(run="ffffffffffffffff", tick=9, time=0.45)
    assert both.take(KEYS.measures("c"), forged) == []


def test_measures_that_no_simulator_sends_are_left_out() -> None:
    both, ticks = Both(), sensed(3)
    both.body()
    both.clock(1)
    both.state(1)
    odometry = OdometryReading(id="odometry", tick=2**40, x=0.0, y=0.0, heading=0.0)
    forged = [
        replace(ticks[0], time=0.0), replace(ticks[0], tick=2, time=1e9), replace(ticks[0], tick=10**12, time=1e9),
        replace(ticks[0], sensors=Sensors(odometry=(odometry,))), replace(ticks[0], tick=0, time=0.0),
        replace(ticks[0], tick=1, time=1.0), replace(ticks[0], tick=10**6, time=5e4),
    ]  # fmt: skip
    found = [both.take(KEYS.measures("c"), one) for one in (*forged, ticks[0], *forged, ticks[1])]
    assert [bool(entries) for entries in found] == [False] * 7 + [True] + [False] * 7 + [True]


def test_a_chair_that_began_with_a_strangers_measures_begins_again() -> None:
    both, ticks = Both(), sensed(2)
    both.body()
    both.state(1)
    assert both.take(KEYS.measures("c"), replace(ticks[0], time=1.0))
    both.clock(1)
    both.state(2)
    assert "/tf_static" in names(both.take(KEYS.measures("c"), ticks[1]))


def test_agents_whose_names_are_one_in_ros_are_left_out_but_for_the_first() -> None:
    both, ticks = Both(), sensed(2)
    for agent in ("a-b", "a_b"):
        both.body(agent)
    both.clock(1)
    both.state(1, "a-b", "a_b")
    assert both.take(KEYS.measures("a-b"), ticks[0])
    assert both.take(KEYS.measures("a_b"), ticks[0]) == []
    assert both.ros.refused == {"a_b": "expected a name that is not a_b in ROS, as that of a-b is"}


def test_a_bag_has_a_bounded_number_of_topics(monkeypatch: pytest.MonkeyPatch) -> None:
    both, ticks = Both(), sensed(1)
    monkeypatch.setattr(ros_translator, "MOST_TOPICS", 12)
    agents = ("a", "b", "c")
    for agent in agents:
        both.body(agent)
    both.clock(1)
    both.state(1, *agents)
    assert [bool(both.take(KEYS.measures(agent), ticks[0])) for agent in agents] == [True, True, False]
    assert both.ros.refused == {"c": "expected at most 12 topics of a bag, got more"}


def test_a_map_is_the_grid_of_ros() -> None:
    both = Both()
    both.clock(1)
    (entry,) = both.ros.take_map(floor("room"))
    assert (entry.topic.name, entry.message.header.frame_id) == ("/map", "map")
    assert entry.message.data.max() == 100
