"""An agent on a real Zenoh link, against a minimal simulator."""

from __future__ import annotations

import queue
import socket
import threading
from collections.abc import Iterator

import pytest
import zenoh

from intellwheels_agents.agent_peer import run_agent
from intellwheels_agents.harness import PLACE_TAKEN
from intellwheels_agents.mind import Context
from intellwheels_agents.options import OptionError
from intellwheels_agents.robot_document import joining
from intellwheels_schemas import link
from intellwheels_schemas.channels import CHANNELS
from intellwheels_schemas.codec import Encoding, decode, encode, encoding_of
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import (
    Actions,
    Joined,
    Leave,
    Measures,
    Position,
    Refused,
    Result,
    Robot,
)
from tests.agents.kinematics import PARAMETERS, PLACES

pytestmark = pytest.mark.process

RUN, SESSION = "a" * 16, "b" * 16
KEYS = Keys("main")
ROBOT = Robot(top_speed=1.0, length=1.0, width=0.6)
DEADLINE = 5.0


class Simulator:
    """Accepts every join, publishes measures on request, and stores the answers."""

    def __init__(self, where: link.Link) -> None:
        session = link.open_session(where, threading.Event())
        assert session is not None
        self.session = session
        self.reply: Refused | None = None
        self.joined: queue.SimpleQueue[Robot] = queue.SimpleQueue()
        self.left: queue.SimpleQueue[Leave] = queue.SimpleQueue()
        self.actions: queue.SimpleQueue[Actions] = queue.SimpleQueue()
        self._kept = [
            session.declare_queryable(KEYS.every_join, self._join),
            session.declare_queryable(KEYS.every_leave, self._leave),
            session.declare_queryable(KEYS.map, self._map),
            session.declare_subscriber(KEYS.every_in, self._act),
            link.declare_token(session, KEYS.alive),
        ]
        self._publisher = link.declare(session, KEYS.measures("chair1"), CHANNELS["measures"])

    def _join(self, query: zenoh.Query) -> None:
        assert query.payload is not None
        data = query.payload.to_bytes()
        robot = decode(Robot, data, encoding_of(str(query.encoding), data))
        self.joined.put(robot)
        if self.reply is not None:
            query.reply_err(encode(self.reply), encoding=Encoding.JSON.value)
            return
        start = Position(x=0.0, y=0.0, heading=0.0)
        joined = Joined(run=RUN, tick=0, session=SESSION, parameters=PARAMETERS, position=start, robot=robot)
        query.reply(str(query.key_expr), encode(joined), encoding=Encoding.JSON.value)

    def _leave(self, query: zenoh.Query) -> None:
        assert query.payload is not None
        self.left.put(decode(Leave, query.payload.to_bytes()))
        query.reply(str(query.key_expr), encode(Result(code="ok")), encoding=Encoding.JSON.value)

    def _map(self, query: zenoh.Query) -> None:
        query.reply(str(query.key_expr), encode(PLACES), encoding=Encoding.JSON.value)

    def _act(self, sample: zenoh.Sample) -> None:
        self.actions.put(decode(Actions, sample.payload.to_bytes(), Encoding.JSON))

    def measure(self, tick: int) -> Actions:
        self._publisher.put(encode(Measures(run=RUN, tick=tick, time=tick * 0.05)))
        return self.actions.get(timeout=DEADLINE)

    def close(self) -> None:
        self.session.close()  # type: ignore[no-untyped-call]


class Agent:
    """`run_agent` in a thread of its own."""

    def __init__(self, where: link.Link, **options: str) -> None:
        self.stop = threading.Event()
        self.places: list[str] = []
        self.presence: queue.SimpleQueue[bool] = queue.SimpleQueue()
        self.result: queue.SimpleQueue[int | Exception] = queue.SimpleQueue()
        robot = joining(ROBOT, agent="chair1", role="both", instance="c" * 16, place=None, barrier=None)

        def body() -> None:
            try:
                code = run_agent(
                    robot, self.make, options, where=where, encoding=Encoding.JSON, retry_for=DEADLINE, stop=self.stop,
                    on_presence=self.presence.put,
                )  # fmt: skip
                self.result.put(code)
            except OptionError as error:
                self.result.put(error)

        self.thread = threading.Thread(target=body, daemon=True)
        self.thread.start()

    def make(self, context: Context) -> Agent:
        self.places = sorted(context.places)
        return self

    def decide(self, measures: Measures) -> Actions:
        return Actions(left_motor=measures.tick / 10.0)

    def end(self) -> int | Exception:
        self.stop.set()
        result = self.result.get(timeout=DEADLINE)
        self.thread.join(DEADLINE)
        return result


@pytest.fixture
def endpoint() -> str:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return f"tcp/127.0.0.1:{probe.getsockname()[1]}"


@pytest.fixture
def simulator(endpoint: str) -> Iterator[Simulator]:
    simulator = Simulator(link.Link(listen=(endpoint,)))
    yield simulator
    simulator.close()


def test_agent_joins_answers_ticks_and_leaves(
    simulator: Simulator, endpoint: str, capsys: pytest.CaptureFixture[str]
) -> None:
    agent = Agent(link.Link(connect=(endpoint,)))
    assert simulator.joined.get(timeout=DEADLINE).name == "chair1"
    for tick in range(3):
        answer = simulator.measure(tick)
        assert (answer.tick, answer.left_motor, answer.session) == (tick, tick / 10.0, SESSION)
    assert agent.end() == 0
    assert simulator.left.get(timeout=DEADLINE) == Leave(run=RUN, session=SESSION)
    assert agent.places == ["goal1", "goal2"]
    assert capsys.readouterr().out == f"joined agent=chair1 run={RUN} tick=0\nleft agent=chair1\n"


def test_the_coming_and_going_of_the_simulator_is_told(simulator: Simulator, endpoint: str) -> None:
    agent = Agent(link.Link(connect=(endpoint,)))
    assert agent.presence.get(timeout=DEADLINE)
    simulator.joined.get(timeout=DEADLINE)
    simulator.measure(0)  # its answer says that the mind is made, which needs the map
    simulator.close()
    assert not agent.presence.get(timeout=DEADLINE)
    assert agent.end() == 0


def test_refusal_ends_the_agent_with_the_simulators_text(
    simulator: Simulator, endpoint: str, capsys: pytest.CaptureFixture[str]
) -> None:
    simulator.reply = Refused(code="overlaps", text="bed1 is taken")
    agent = Agent(link.Link(connect=(endpoint,)))
    assert agent.result.get(timeout=DEADLINE) == PLACE_TAKEN
    agent.thread.join(DEADLINE)
    assert "refused (overlaps): bed1 is taken" in capsys.readouterr().err


def test_agent_with_an_unknown_option_leaves_before_it_fails(simulator: Simulator, endpoint: str) -> None:
    agent = Agent(link.Link(connect=(endpoint,)), sped="1")
    assert isinstance(agent.result.get(timeout=DEADLINE), OptionError)
    agent.thread.join(DEADLINE)
    assert simulator.left.get(timeout=DEADLINE).session == SESSION


def test_agent_ends_when_stopped_without_a_simulator(endpoint: str) -> None:
    agent = Agent(link.Link(connect=(endpoint,)))
    assert agent.end() == 0
