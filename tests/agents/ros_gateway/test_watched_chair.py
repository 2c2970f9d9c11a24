"""A chair that another mind drives, without a network."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from msgspec.structs import replace

from intellwheels_agents.ros_gateway.watched_chair import WatchedChair
from intellwheels_schemas.codec import Encoding, encode
from intellwheels_schemas.crew_messages import crew_messages, for_crew
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import Body, Entity
from intellwheels_schemas.zenoh_inbox import Inbox, Put
from tests.agents.ros_gateway.made_up import CHAIR, RUN, measured, readings

KEYS = Keys("w")


class World:
    """A world with one chair, whose true pose may be hidden."""

    def __init__(self, *entities: Entity) -> None:
        self._entities = entities
        self.gone = False

    def body(self, _agent: str) -> Body:
        if self.gone:
            raise ConnectionError("no body")
        return Body(run=RUN, tick=0, robot=CHAIR)

    def entities(self) -> tuple[float, tuple[Entity, ...]]:
        return 0.0, self._entities


class Session:
    """Keeps which keys are subscribed to."""

    def __init__(self) -> None:
        self.keys: list[str] = []

    def declare_subscriber(self, key: str, _callback: object) -> Any:
        self.keys.append(key)
        return SimpleNamespace(undeclare=lambda: self.keys.remove(key))


class Node:
    """Keeps what is published."""

    def __init__(self) -> None:
        self.sent: list[tuple[str, Any]] = []

    def advertise(self, topics: Any) -> None:
        assert "/c_1/odom" in [topic.name for topic in topics]

    def publish(self, topic: str, message: Any) -> None:
        self.sent.append((topic, message))


def watched(world: World, node: Node, log: list[str], session: Any = None) -> WatchedChair:
    nothing: Any = None
    return WatchedChair(
        session, KEYS, world, "c-1", node, nothing, localisation="start",  # type: ignore[arg-type]
        tell_clock=lambda run, seconds, _now: log.append(f"{run[:2]} {seconds}"), log=log.append,
    )  # fmt: skip


def put(tick: int, x: float = 0.0) -> Put:
    return Put(KEYS.measures("c-1"), encode(measured(tick, readings(x))), "application/json")


def test_topics_begin_when_body_and_period_are_known() -> None:
    node, log, told = Node(), list[str](), list[str]()
    world = World(Entity(name="c-1", x=3.0, y=2.0, heading=0.0))
    chair = watched(world, node, log)
    chair._take(put(0), told.append)
    world.gone = True
    chair._take(put(1), told.append)
    assert node.sent == []
    world.gone = False
    chair._try_at = 0.0
    chair._take(put(2, 1.0), told.append)
    assert told == [f"watching agent=c-1 run={RUN}"]
    assert {"/tf_static", "/tf", "/c_1/odom", "/c_1/scan"} <= {topic for topic, _ in node.sent}
    (frames,) = (message for topic, message in node.sent if topic == "/tf")
    # A metre of odometry before it was watched: the origin of the odometry is a metre behind.
    assert frames.transforms[0].transform.translation.x == 2.0
    assert log == ["01 0.1"]


def test_hidden_pose_gives_no_place_on_the_map() -> None:
    node, log = Node(), list[str]()
    watched(World(), node, log)._take(put(2), lambda _: None)
    (frames,) = (message for topic, message in node.sent if topic == "/tf")
    assert [one.child_frame_id for one in frames.transforms] == ["c_1/base_link"]
    assert "the world hides true poses" in log[0]


def test_measures_that_cannot_be_read_are_dropped() -> None:
    node, log = Node(), list[str]()
    watched(World(), node, log)._take(Put(KEYS.measures("c-1"), b"{", "application/json"), lambda _: None)
    assert log[0].startswith("dropped key=iw/v1/w/out/c-1/measures")


def test_measures_that_no_simulator_sends_are_passed_over() -> None:
    node, world = Node(), World(Entity(name="c-1", x=3.0, y=2.0, heading=0.0))
    chair = watched(world, node, [])
    for tick, time in ((1, 0.0), (10**13, 1e9), (1, 1.5)):
        forged = replace(measured(1, readings(0.0)), tick=tick, time=time)
        chair._take(Put(KEYS.measures("c-1"), encode(forged), "application/json"), lambda _: None)
        assert node.sent == []
        chair._try_at = 0.0
    # It could be of a run with longer ticks, until others come.
    strange = replace(measured(1, readings(0.0)), tick=10**12, time=1e9)
    for data in (encode(strange), put(1).data):
        node.sent.clear()
        chair._try_at = 0.0
        chair._take(Put(KEYS.measures("c-1"), data, "application/json"), lambda _: None)
        assert "/c_1/odom" in [topic for topic, _ in node.sent]


def test_chair_of_a_crew_is_watched_through_its_crew() -> None:
    node, session, inbox = Node(), Session(), Inbox()
    chair = watched(World(Entity(name="c-1", x=3.0, y=2.0, heading=0.0)), node, [], session)
    chair._ask_crew(inbox)
    assert session.keys == []
    for crew in ("k", "k", "l", None, "k"):
        body = Body(run=RUN, tick=0, robot=replace(CHAIR, crew=crew))
        chair._take_body(Put(KEYS.body("c-1"), encode(body), "application/json"), inbox)
        assert session.keys == ([] if crew is None else [KEYS.crew_measures(crew)])
    own = encode(measured(2, readings(0.0)))
    items = [for_crew(own, agent, Encoding.JSON) for agent in ("other", "c-1")]
    for each, sent in ((items[:1], False), (items, True)):
        (data,) = crew_messages("Measures", "k", each, Encoding.JSON)
        chair._take(Put(KEYS.crew_measures("k"), data, "application/json"), lambda _: None)
        assert ("/c_1/odom" in [topic for topic, _ in node.sent]) == sent
    chair.close()
    assert session.keys == []
