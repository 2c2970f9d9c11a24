"""A service without a network, driven by hand: what arrives and what time it is are the test's to say."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import msgspec

from intellwheels_maps import floor, robot
from intellwheels_schemas.codec import Encoding, decode, encode
from intellwheels_schemas.file_records import Inputs
from intellwheels_schemas.keys import AGENT_VERBS
from intellwheels_schemas.messages import (
    Actions,
    AgentActions,
    Body,
    Clock,
    CrewActions,
    CrewError,
    CrewJoin,
    CrewJoined,
    CrewMeasures,
    End,
    Error,
    Event,
    Joined,
    MapInfo,
    Measures,
    Pose,
    Record,
    Result,
    Robot,
    Role,
    Say,
    WorldState,
)
from intellwheels_schemas.metal_codes import code_of, pose_line
from intellwheels_server import world
from intellwheels_server.log.input_log import Line, Log
from intellwheels_server.service.arrival import Put, PutKind, Query, Token, Topic
from intellwheels_server.service.live_run import LiveRun
from intellwheels_server.service.load_floor import LoadFault, LoadRequest, PackedFloor, load_floor
from intellwheels_server.service.roster import presence_of
from intellwheels_server.service.service_state import Options
from intellwheels_server.service.side_process import Outcome

RUN = "0123456789abcdef"
JSON = Encoding.JSON
NOBODY = "0" * 16
"""A session that no join gave."""


class FloorsAtOnce:
    """Loads floors in this process: at once, or when the test gives an outcome."""

    def __init__(self) -> None:
        self.holds = False
        self.begun: list[tuple[LoadRequest, float]] = []
        self.outcomes: list[Outcome[PackedFloor | LoadFault]] = []

    def begin(self, request: LoadRequest, limit: float) -> None:
        self.begun.append((request, limit))
        if not self.holds:
            self.finish()

    def finish(self) -> None:
        self.outcomes.append(Outcome("done", load_floor(self.begun[-1][0])))

    def take(self) -> Outcome[PackedFloor | LoadFault] | None:
        return self.outcomes.pop(0) if self.outcomes else None


class Stage:
    """A live run, its clock, and all that came out.

    Attributes:
        reads_state: Whether somebody reads the state.
    """

    reads_state = True

    def __init__(
        self, *, strict: bool | None = None, log: Path | None = None, end: End | None = None, **options: Any
    ) -> None:
        pace = options.setdefault("pace", "lockstep")
        strict = pace == "lockstep" if strict is None else strict
        setup = world.Setup(floor=floor("room"), strict=strict, end=end, truth=True)
        options.setdefault("deadline", 10.0 if strict else 1.0)
        options.setdefault("grace", 3.0)
        self.now = 100.0
        self.sent: list[tuple[str, str, Record, Encoding]] = []
        self.lines: list[str] = []
        self.notes: list[str] = []
        self.sessions: dict[str, str] = {}
        self.keys: dict[str, str] = {}
        self.log = Log(log, setup, RUN) if log else None
        self.floors = FloorsAtOnce()
        self.live_run = LiveRun(
            Options(world="main", setup=setup, **options),
            self,
            self.floors,
            lambda: 1.8e9 + self.now,
            record=self._record if log else None,
            run=RUN,
        )
        self.live_run.begin()
        self.work()

    # ------------------------------------------------------------ the outlet

    def agent(self, agent: str, kind: str, message: Record, encoding: Encoding) -> None:
        encode(message, encoding)
        self.sent.append((agent, kind, message, encoding))

    def put_measures(self, agent: str, data: bytes, encoding: Encoding, /) -> None:
        self.sent.append((agent, "measures", decode(Measures, data, encoding), encoding))

    def declare_agent(self, agent: str, mind: Encoding, body: Encoding) -> None:
        self.sent.append((agent, "declare", Robot(), mind))

    def undeclare_agent(self, agent: str) -> None:
        self.sent.append((agent, "undeclare", Robot(), JSON))

    def crew_measures(self, crew: str, data: bytes, encoding: Encoding) -> None:
        self.sent.append((crew, "crew-measures", decode(CrewMeasures, data, encoding), encoding))

    def crew_error(self, crew: str, error: CrewError, encoding: Encoding) -> None:
        encode(error, encoding)
        self.sent.append((crew, "crew-error", error, encoding))

    def undeclare_crew(self, crew: str) -> None:
        self.sent.append((crew, "undeclare-crew", Robot(), JSON))

    def body(self, agent: str, body: Body) -> None:
        self.sent.append((agent, "body", body, JSON))

    def pose(self, agent: str, pose: Pose) -> None:
        self.sent.append((agent, "pose", pose, JSON))

    def put_state(self, part: int, data: bytes) -> None:
        state = decode(WorldState, data)
        assert state.part == part
        self.sent.append(("", "state", state, JSON))

    def is_state_read(self) -> bool:
        return self.reads_state

    def event(self, event: Event) -> None:
        self.sent.append(("", "event", event, JSON))

    def clock(self, clock: Clock) -> None:
        encode(clock)
        self.sent.append(("", "clock", clock, JSON))

    def map(self, info: MapInfo) -> None:
        self.sent.append(("", "map", info, JSON))

    def print_line(self, line: str) -> None:
        self.lines.append(line)

    def log_line(self, line: str) -> None:
        self.notes.append(line)

    def _record(self, tick: int, inputs: Inputs, digest: str, *, stepped: bool) -> None:
        assert self.log is not None
        self.log.write(Line(tick=tick, inputs=inputs, hash=digest, stepped=stepped), self.now)

    # ------------------------------------------------------------ what happens

    def work(self, seconds: float = 0.0) -> None:
        """Let time pass, doing what is due when it is due."""
        until = self.now + seconds
        for _ in range(20_000 if seconds else 200):
            self.live_run.work(self.now)
            due = self.live_run.due(self.now)
            if due > until or self.live_run.exit is not None:
                break
            self.now = max(self.now, due)
            if due <= self.now and seconds == 0.0 and self._still():
                break
        self.now = until

    def _still(self) -> bool:
        tick = self.live_run.state.tick
        self.live_run.work(self.now)
        return self.live_run.state.tick == tick and self.live_run.due(self.now) >= self.now

    def token(self, agent: str, role: Role = "both", instance: str = "a" * 16, *, present: bool = True) -> None:
        self.live_run.take(Token(agent, role, instance, present), self.now)
        self.work()

    def ask(self, topic: Topic, name: str, message: Record | bytes = b"", **more: Any) -> list[tuple[Record, bool]]:
        """Ask, work, and return what was replied so far; the list grows when replies come later."""
        replies: list[tuple[Record, bool]] = []
        encoding = more.pop("encoding", JSON)
        data = message if isinstance(message, bytes) else encode(message, encoding)
        if topic == "ctl" and name in AGENT_VERBS and "agent" not in more:
            more["agent"] = json.loads(data)["Agent"]

        def send(reply: Record, reply_encoding: Encoding, ok: bool, _name: str | None) -> None:
            encode(reply, reply_encoding)
            replies.append((reply, ok))

        self.live_run.take(Query(topic, name, data, encoding.value, send, lambda: None, **more), self.now)
        self.work()
        return replies

    def result(self, verb: str, message: Record | bytes = b"") -> Result:
        replies = self.ask("ctl", verb, message)
        assert len(replies) == 1, replies
        reply = replies[0][0]
        assert isinstance(reply, Result)
        return reply

    def join(self, agent: str, kind: str | Robot = "rear-wheel", instance: str = "a" * 16, **more: Any) -> Joined:
        reply, ok = self.try_join(agent, kind, instance, **more)
        assert ok, reply
        assert isinstance(reply, Joined)
        self.sessions[agent] = reply.session
        if reply.key is not None:
            self.keys[agent] = reply.key
        return reply

    def join_two(self, **more: Any) -> None:
        """Join chair1 and chair2 at one tick: paused, so that the first one's barrier does not open between."""
        self.live_run._service.pacing.paused = True
        self.join("chair1")
        self.join("chair2", instance="b" * 16, **more)
        self.live_run._service.pacing.paused = False
        self.work()

    def try_join(
        self, agent: str, kind: str | Robot = "rear-wheel", instance: str = "a" * 16, **more: Any
    ) -> tuple[Record, bool]:
        encoding = more.pop("encoding", JSON)
        parameters = more.pop("parameters", {})
        wanted = robot(kind) if isinstance(kind, str) else kind
        wanted = msgspec.structs.replace(wanted, name=agent, instance=instance, format=None, **more)
        self.token(agent, wanted.role, instance)
        replies = self.ask("join", agent, wanted, encoding=encoding, parameters=parameters)
        assert len(replies) == 1, replies
        return replies[0]

    def put(self, agent: str, message: Record | bytes, kind: PutKind = "actions", encoding: str = JSON.value) -> None:
        """Put a message of an agent, with the session and the code of its last join unless it has others."""
        if isinstance(message, Actions | Pose | Say) and message.session is None:
            message = msgspec.structs.replace(message, session=self.sessions.get(agent, NOBODY))
        if isinstance(message, Pose) and message.code is None and agent in self.keys:
            message = msgspec.structs.replace(message, code=code_of(self.keys[agent], pose_line(message)))
        data = message if isinstance(message, bytes) else encode(message)
        self.live_run.take(Put(agent, kind, data, encoding), self.now)
        self.work()

    def act(self, agent: str, left: float | None = None, right: float | None = None, **more: Any) -> None:
        """Answer the current tick as the harness does."""
        state = self.live_run.state
        more.setdefault("tick", state.tick)
        actions = Actions(run=state.run, session=self.sessions[agent], left_motor=left, right_motor=right, **more)
        self.put(agent, actions)

    def join_crew(
        self, name: str, *agents: str, instance: str = "c" * 16, encoding: Encoding = JSON, **fields: Any
    ) -> Record:
        """Join with agents as a crew and return the reply; `fields` are those of their robots."""
        wanted = tuple(
            msgspec.structs.replace(robot("rear-wheel"), **({"format": None, "name": agent} | fields))
            for agent in agents
        )
        crew = name
        for each in wanted:
            self.token(each.name or "", each.role, presence_of(instance, crew))
        join = CrewJoin(crew=crew, instance=instance, robot=wanted)
        replies = self.ask("crew-join", crew, join, encoding=encoding)
        assert len(replies) == 1, replies
        reply = replies[0][0]
        if isinstance(reply, CrewJoined):
            self.sessions |= {each.agent: each.session for each in reply.joined}
        return reply

    def crew_act(self, crew: str, *agents: str, **more: Any) -> None:
        """Answer the current tick for agents of a crew, with their sessions unless another is given."""
        state = self.live_run.state
        fields: dict[str, Any] = {"run": state.run, "tick": state.tick, "left_motor": 0.5, "right_motor": 0.5} | more
        actions = tuple(
            AgentActions(agent=agent, **{"session": self.sessions.get(agent, NOBODY), **fields}) for agent in agents
        )
        self.put(crew, CrewActions(crew=crew, actions=actions), "crew")

    # ------------------------------------------------------------ what came out

    @property
    def tick(self) -> int:
        return self.live_run.state.tick

    def of(self, kind: str, agent: str = "") -> list[Any]:
        return [message for to, what, message, _ in self.sent if what == kind and to == agent]

    def measures(self, agent: str) -> list[Measures]:
        return self.of("measures", agent)

    def errors(self, agent: str) -> list[Error]:
        return self.of("error", agent)

    def events(self) -> list[str]:
        return [event.code for event in self.of("event")]


def real(**more: Any) -> Robot:
    return msgspec.structs.replace(robot("rear-wheel"), type="real", **more)
