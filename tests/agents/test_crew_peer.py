"""A crew on a real Zenoh link, against a minimal simulator."""

from __future__ import annotations

import queue
import threading
from collections.abc import Iterator

import pytest
import zenoh

from intellwheels_agents.crew_harness import CrewMember
from intellwheels_agents.crew_peer import run_crew
from intellwheels_agents.mind import Context
from intellwheels_agents.robot_document import joining
from intellwheels_schemas import link
from intellwheels_schemas.channels import CHANNELS
from intellwheels_schemas.codec import Encoding, decode, encode
from intellwheels_schemas.crew_messages import crew_messages, for_crew
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import (
    Actions,
    AgentJoined,
    CrewActions,
    CrewJoin,
    CrewJoined,
    CrewLeave,
    Measures,
    Position,
    Result,
    Robot,
)
from tests.agents.kinematics import PARAMETERS, PLACES
from tests.e2e.stage import free_port

pytestmark = pytest.mark.process

RUN, SESSION, INSTANCE = "a" * 16, "b" * 16, "c" * 16
KEYS, JSON = Keys("main"), Encoding.JSON
DEADLINE = 10.0
NAMES = ("p1", "p2", "p3")


class Simulator:
    """Accepts every crew, publishes measures on request, and stores the answers."""

    def __init__(self, where: link.Link) -> None:
        session = link.open_session(where, threading.Event())
        assert session is not None
        self.session = session
        self.left: queue.SimpleQueue[CrewLeave] = queue.SimpleQueue()
        self.joins: queue.SimpleQueue[CrewJoin] = queue.SimpleQueue()
        self.actions: queue.SimpleQueue[CrewActions] = queue.SimpleQueue()
        self._kept = [
            session.declare_queryable(KEYS.every_crew_join, self._join),
            session.declare_queryable(KEYS.every_crew_leave, self._leave),
            session.declare_queryable(KEYS.map, self._map),
            session.declare_subscriber(KEYS.crew_actions("c"), self._act),
            link.declare_token(session, KEYS.alive),
        ]
        self._publisher = link.declare(session, KEYS.crew_measures("c"), CHANNELS["crew_measures"])

    def _join(self, query: zenoh.Query) -> None:
        assert query.payload is not None
        join = decode(CrewJoin, query.payload.to_bytes())
        self.joins.put(join)
        start = Position(x=0.0, y=0.0, heading=0.0)
        joined = tuple(
            AgentJoined(agent=one.name or "", session=SESSION, position=start, robot=one) for one in join.robot
        )
        reply = CrewJoined(crew="c", run=RUN, tick=0, parameters=PARAMETERS, joined=joined)
        query.reply(str(query.key_expr), encode(reply), encoding=JSON.value)

    def _leave(self, query: zenoh.Query) -> None:
        assert query.payload is not None
        self.left.put(decode(CrewLeave, query.payload.to_bytes()))
        query.reply(str(query.key_expr), encode(Result(code="ok")), encoding=JSON.value)

    def _map(self, query: zenoh.Query) -> None:
        query.reply(str(query.key_expr), encode(PLACES), encoding=JSON.value)

    def _act(self, sample: zenoh.Sample) -> None:
        self.actions.put(decode(CrewActions, sample.payload.to_bytes()))

    def measure(self, tick: int) -> CrewActions:
        data = encode(Measures(run=RUN, tick=tick, time=tick * 0.05))
        items = [for_crew(data, name, JSON) for name in NAMES]
        for part in crew_messages("Measures", "c", items, JSON):
            self._publisher.put(part)
        return self.actions.get(timeout=DEADLINE)


class Mind:
    def __init__(self, context: Context) -> None:
        self.places = sorted(context.places)

    def decide(self, measures: Measures) -> Actions:
        return Actions(left_motor=measures.tick / 10.0, right_motor=len(self.places) / 10.0)


@pytest.fixture
def simulator() -> Iterator[tuple[Simulator, link.Link]]:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    made = Simulator(link.Link(listen=(endpoint,)))
    yield made, link.Link(connect=(endpoint,))
    made.session.close()  # type: ignore[no-untyped-call]


def test_crew_joins_acts_and_leaves(simulator: tuple[Simulator, link.Link], capsys: pytest.CaptureFixture[str]) -> None:
    made, where = simulator
    stop, codes = threading.Event(), queue.SimpleQueue[int]()
    robot = Robot(top_speed=1.0, length=1.0, width=0.6)
    members = [
        CrewMember(joining(robot, agent=name, role="both", instance=INSTANCE, place=None, barrier=None), Mind, {})
        for name in NAMES
    ]

    def host() -> None:
        codes.put(run_crew("c", INSTANCE, members, where=where, encoding=JSON, retry_for=DEADLINE, stop=stop))

    thread = threading.Thread(target=host, daemon=True)
    thread.start()
    assert [one.name for one in made.joins.get(timeout=DEADLINE).robot] == [*NAMES]
    for tick in range(1, 4):
        actions = made.measure(tick).actions
        assert [(one.agent, one.tick, one.session) for one in actions] == [(name, tick, SESSION) for name in NAMES]
        assert {(one.left_motor, one.right_motor) for one in actions} == {(tick / 10.0, 0.2)}
    tokens = link.tokens(made.session, KEYS.every_crew_token)
    assert tokens == [KEYS.token(name, "both", INSTANCE, "c") for name in NAMES]
    stop.set()
    assert codes.get(timeout=DEADLINE) == 0
    thread.join(DEADLINE)
    assert [one.agent for one in made.left.get(timeout=DEADLINE).leave] == [*NAMES]
    out = capsys.readouterr().out.splitlines()
    assert [line.split()[:2] for line in out] == [
        [verb, f"agent={name}"] for verb in ("joined", "left") for name in NAMES
    ]


def test_without_a_simulator_it_ends_when_the_time_is_over() -> None:
    where = link.Link(connect=(f"tcp/127.0.0.1:{free_port()}",))
    code = run_crew("c", INSTANCE, [], where=where, encoding=JSON, retry_for=0.1, stop=threading.Event())
    assert code == 1
