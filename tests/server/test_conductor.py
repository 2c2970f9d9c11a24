"""The service without a network: a clock made of numbers, messages kept in lists."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import msgspec
import pytest

from intellwheels_maps import floor, robot
from intellwheels_schemas.codec import Encoding, encode
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import (
    Actions,
    Body,
    Clock,
    End,
    Error,
    Event,
    Joined,
    Leave,
    Load,
    Map,
    MapInfo,
    Measures,
    Pose,
    Position,
    PowerInForce,
    Record,
    Refused,
    Reset,
    Result,
    Robot,
    Role,
    Say,
    Spawn,
    Speed,
    Step,
    Take,
    Teleport,
    Timeout,
    UserInput,
    WorldState,
)
from intellwheels_server import world
from intellwheels_server.arrival import Ask, Put, PutKind, Token, Topic
from intellwheels_server.conductor import Conductor
from intellwheels_server.desk import Options
from intellwheels_server.inputs import Inputs
from intellwheels_server.log import Line, Log
from intellwheels_server.resimulate import resimulate

RUN = "0123456789abcdef"
JSON = Encoding.JSON


class Stage:
    """A conductor, its clock, and all that came out."""

    def __init__(
        self, *, strict: bool | None = None, log: Path | None = None, end: End | None = None, **options: Any
    ) -> None:
        pace = options.setdefault("pace", "lockstep")
        strict = pace == "lockstep" if strict is None else strict
        setup = world.Setup(floor=floor("room"), strict=strict, end=end, truth=True)
        options.setdefault("deadline", 10.0 if strict else 1.0)
        self.now = 100.0
        self.sent: list[tuple[str, str, Record, Encoding]] = []
        self.lines: list[str] = []
        self.notes: list[str] = []
        self.sessions: dict[str, str] = {}
        self.log = Log(log, setup, RUN) if log else None
        self.conductor = Conductor(
            Options(world="main", setup=setup, **options),
            self,
            self._floor_of,
            lambda: 1.8e9 + self.now,
            record=self._record if log else None,
            run=RUN,
        )
        self.conductor.begin()
        self.work()

    # ------------------------------------------------------------ the outlet

    def agent(self, agent: str, kind: str, message: Record, encoding: Encoding) -> None:
        encode(message, encoding)
        self.sent.append((agent, kind, message, encoding))

    def welcome(self, agent: str, mind: Encoding, body: Encoding) -> None:
        self.sent.append((agent, "welcome", Robot(), mind))

    def farewell(self, agent: str) -> None:
        self.sent.append((agent, "farewell", Robot(), JSON))

    def body(self, agent: str, body: Body) -> None:
        self.sent.append((agent, "body", body, JSON))

    def state(self, state: WorldState) -> None:
        self.sent.append(("", "state", state, JSON))

    def event(self, event: Event) -> None:
        self.sent.append(("", "event", event, JSON))

    def clock(self, clock: Clock) -> None:
        encode(clock)
        self.sent.append(("", "clock", clock, JSON))

    def map(self, info: MapInfo) -> None:
        self.sent.append(("", "map", info, JSON))

    def tell(self, line: str) -> None:
        self.lines.append(line)

    def note(self, line: str) -> None:
        self.notes.append(line)

    def _floor_of(self, load: Load) -> Map:
        if load.map is not None:
            return load.map
        if load.name != "corner":
            raise WireError("value", f"no floor {load.name}")
        return floor("corner")

    def _record(self, tick: int, inputs: Inputs, digest: str, *, stepped: bool) -> None:
        assert self.log is not None
        self.log.write(Line(tick=tick, inputs=inputs, hash=digest, stepped=stepped), self.now)

    # ------------------------------------------------------------ what happens

    def work(self, seconds: float = 0.0) -> None:
        """Let time pass, doing what is due when it is due."""
        until = self.now + seconds
        for _ in range(20_000 if seconds else 200):
            self.conductor.work(self.now)
            due = self.conductor.due(self.now)
            if due > until or self.conductor.exit is not None:
                break
            self.now = max(self.now, due)
            if due <= self.now and seconds == 0.0 and self._still():
                break
        self.now = until

    def _still(self) -> bool:
        tick = self.conductor.state.tick
        self.conductor.work(self.now)
        return self.conductor.state.tick == tick and self.conductor.due(self.now) >= self.now

    def token(self, agent: str, role: Role = "both", instance: str = "a" * 16, *, present: bool = True) -> None:
        self.conductor.take(Token(agent, role, instance, present), self.now)
        self.work()

    def ask(self, topic: Topic, name: str, message: Record | bytes = b"", **more: Any) -> list[tuple[Record, bool]]:
        """Ask, work, and return what was replied so far; the list grows when replies come later."""
        replies: list[tuple[Record, bool]] = []
        encoding = more.pop("encoding", JSON)
        data = message if isinstance(message, bytes) else encode(message, encoding)

        def send(reply: Record, reply_encoding: Encoding, ok: bool, _name: str | None) -> None:
            encode(reply, reply_encoding)
            replies.append((reply, ok))

        self.conductor.take(Ask(topic, name, data, encoding.value, send, lambda: None, **more), self.now)
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
        return reply

    def join_two(self, **more: Any) -> None:
        """Join chair1 and chair2 at one tick: paused, so that the first one's barrier does not open between."""
        self.conductor._desk.paused = True
        self.join("chair1")
        self.join("chair2", instance="b" * 16, **more)
        self.conductor._desk.paused = False
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
        data = message if isinstance(message, bytes) else encode(message)
        self.conductor.take(Put(agent, kind, data, encoding), self.now)
        self.work()

    def act(self, agent: str, left: float | None = None, right: float | None = None, **more: Any) -> None:
        """Answer the current tick as the harness does."""
        state = self.conductor.state
        more.setdefault("tick", state.tick)
        actions = Actions(run=state.run, session=self.sessions[agent], left_motor=left, right_motor=right, **more)
        self.put(agent, actions)

    # ------------------------------------------------------------ what came out

    @property
    def tick(self) -> int:
        return self.conductor.state.tick

    def of(self, kind: str, agent: str = "") -> list[Any]:
        return [message for to, what, message, _ in self.sent if what == kind and to == agent]

    def measures(self, agent: str) -> list[Measures]:
        return self.of("measures", agent)

    def errors(self, agent: str) -> list[Error]:
        return self.of("error", agent)

    def events(self) -> list[str]:
        return [event.code for event in self.of("event")]


# ---------------------------------------------------------------- lockstep


def test_measures_0_come_before_any_command_and_a_tick_follows_each_answer() -> None:
    stage = Stage()
    joined = stage.join("chair1")
    assert (joined.run, joined.tick) == (RUN, 0)
    for tick in range(5):
        assert [m.tick for m in stage.measures("chair1")] == list(range(tick + 1))
        stage.act("chair1", 0.5, 0.5)
    assert stage.tick == 5
    assert stage.errors("chair1") == []


def test_the_barrier_waits_for_every_member() -> None:
    stage = Stage()
    stage.join_two()
    stage.act("chair1")
    assert stage.tick == 0
    stage.act("chair2")
    assert stage.tick == 1


def test_tick_0_is_held_until_those_expected_are_there() -> None:
    stage = Stage(expect=("chair1", "chair2"))
    stage.join("chair1")
    assert stage.lines == []
    assert stage.measures("chair1") == []
    clock = stage.of("clock")[-1]
    stage.work(1.0)
    clock = stage.of("clock")[-1]
    assert (clock.state, clock.waiting) == ("waiting", ("chair2",))
    stage.join("chair2", instance="b" * 16)
    assert stage.lines == ["running tick=0"]
    assert [m.tick for m in stage.measures("chair1")] == [0]


def test_a_join_in_a_running_lockstep_takes_effect_at_the_next_barrier() -> None:
    stage = Stage()
    stage.join("chair1")
    stage.act("chair1")
    stage.token("chair2", instance="b" * 16)
    wanted = msgspec.structs.replace(robot("rear-wheel"), name="chair2", instance="b" * 16, format=None)
    replies = stage.ask("join", "chair2", wanted)
    assert replies == []
    stage.act("chair1")
    joined = replies[0][0]
    assert isinstance(joined, Joined)
    assert joined.tick == 2
    assert [m.tick for m in stage.measures("chair2")] == [2]
    stage.act("chair1")
    assert stage.tick == 2


def test_a_leave_takes_effect_at_the_next_barrier_and_names_its_tick() -> None:
    stage = Stage()
    stage.join_two()
    replies = stage.ask("leave", "chair2", Leave(session=stage.sessions["chair2"]))
    assert replies == []
    stage.act("chair1")
    result = replies[0][0]
    assert isinstance(result, Result)
    assert (result.code, result.tick) == ("ok", 1)
    assert stage.conductor.state.names == ("chair1",)


def test_leave_in_the_last_actions_leaves() -> None:
    stage = Stage()
    stage.join("chair1")
    stage.act("chair1", 1.0, 1.0, leave=True)
    assert stage.conductor.state.names == ()
    assert stage.tick == 1
    assert "left" in stage.events()


def test_an_answer_counts_once_and_the_same_bytes_are_silent() -> None:
    stage = Stage()
    stage.join_two()
    stage.act("chair1", 0.1, 0.1, seq=1)
    stage.act("chair1", 0.1, 0.1, seq=1)
    assert stage.errors("chair1") == []
    stage.act("chair1", 0.2, 0.2, seq=2)
    assert [(e.code, e.seq) for e in stage.errors("chair1")] == [("answered", 2)]


def test_a_second_answer_to_measures_put_twice_is_silent_after_the_barrier_too() -> None:
    stage = Stage()
    stage.join("chair1")
    stage.act("chair1", tick=0)
    stage.act("chair1", tick=0)
    assert stage.tick == 1
    assert stage.errors("chair1") == []


def test_old_and_future_ticks_and_old_runs_are_told() -> None:
    stage = Stage()
    stage.join("chair1")
    for _ in range(3):
        stage.act("chair1", 0.1, 0.1)
    stage.act("chair1", 0.2, 0.2, tick=1)
    stage.act("chair1", 0.2, 0.2, tick=7)
    stage.put("chair1", Actions(run="f" * 16, tick=3))
    assert [e.code for e in stage.errors("chair1")] == ["late", "early", "late"]
    assert stage.tick == 3


def test_the_papers_form_counts_for_the_current_tick() -> None:
    stage = Stage()
    stage.join("chair1")
    stage.put(
        "chair1", b'<Actions LeftMotor="0.5" RightMotor="0.4"><Say><![CDATA[follow me]]></Say></Actions>', encoding=""
    )
    assert stage.tick == 1


def test_unanswered_measures_are_put_again() -> None:
    stage = Stage()
    stage.join("chair1")
    stage.work(0.15)
    assert [m.tick for m in stage.measures("chair1")] == [0, 0, 0, 0]


def test_a_strict_miss_ends_the_run_with_exit_1() -> None:
    stage = Stage()
    stage.join("chair1")
    stage.act("chair1")
    stage.work(10.1)
    assert stage.conductor.exit == 1
    assert stage.lines[-1] == "miss agent=chair1 tick=1"


def test_an_elastic_run_goes_on_rests_a_body_after_three_misses_and_takes_it_back() -> None:
    stage = Stage(strict=False)
    stage.join_two()
    for _ in range(3):
        stage.act("chair1")
        stage.work(1.01)
    assert stage.tick == 3
    assert [code for code in stage.events() if code in ("late", "rested")] == ["late", "late", "late", "rested"]
    stage.act("chair2", 0.5, 0.5)
    stage.act("chair1")
    assert stage.events()[-1] == "back"
    tick = stage.tick
    stage.act("chair1")
    assert stage.tick == tick


def test_a_resting_agent_that_is_always_late_is_awaited_again() -> None:
    stage = Stage(strict=False)
    stage.join_two()
    for _ in range(4):
        stage.act("chair1")
        stage.work(1.01)
    stage.act("chair2", tick=stage.tick - 1)
    assert stage.errors("chair2")[-1].code == "late"
    stage.act("chair1")
    tick = stage.tick
    stage.act("chair1")
    assert stage.tick == tick


def test_a_member_of_lockstep_without_barrier_is_not_awaited() -> None:
    stage = Stage()
    stage.join("watcher", instance="b" * 16, barrier=False)
    stage.join("chair1")
    stage.act("chair1")
    assert stage.tick == 1
    assert [m.tick for m in stage.measures("watcher")] == [0, 1]


def test_a_lockstep_of_nobody_waits() -> None:
    stage = Stage()
    stage.work(5.0)
    assert stage.tick == 0
    assert stage.of("clock")[-1].state == "waiting"
    assert 8 <= len(stage.of("clock")) <= 13


# ---------------------------------------------------------------- who is here


def test_two_of_one_name_are_refused_in_words() -> None:
    stage = Stage()
    stage.join("chair1")
    stage.result("pause")
    refused, ok = stage.try_join("chair1", instance="b" * 16)
    assert not ok
    assert isinstance(refused, Refused)
    assert (refused.code, refused.text) == ("already-here", "agent 'chair1' is already here")


def test_a_join_waits_a_moment_for_its_token() -> None:
    stage = Stage()
    wanted = msgspec.structs.replace(robot("rear-wheel"), name="chair1", instance="a" * 16, format=None)
    replies = stage.ask("join", "chair1", wanted)
    assert replies == []
    stage.token("chair1")
    assert isinstance(replies[0][0], Joined)


def test_a_join_without_token_is_refused() -> None:
    stage = Stage()
    wanted = msgspec.structs.replace(robot("rear-wheel"), name="chair1", instance="a" * 16, format=None)
    replies = stage.ask("join", "chair1", wanted)
    stage.work(0.5)
    refused, ok = replies[0]
    assert not ok
    assert isinstance(refused, Refused)
    assert refused.code == "no-token"


@pytest.mark.parametrize(
    ("data", "code"),
    [
        (b"<Robot", "value"),
        (b'{"Instance":"aaaaaaaaaaaaaaaa","Wheels":3}', "field"),
        (b'{"Instance":"aaaaaaaaaaaaaaaa","TopSpeed":"fast"}', "value"),
        (b"{" + b" " * 70_000 + b"}", "limit"),
    ],
)
def test_a_robot_that_cannot_be_read_is_refused_with_place_and_code(data: bytes, code: str) -> None:
    stage = Stage()
    stage.token("chair1")
    refused, ok = stage.ask("join", "chair1", data)[0]
    assert not ok
    assert isinstance(refused, Refused)
    assert refused.code == code
    assert refused.text.startswith("Robot")


def test_a_successor_within_the_grace_time_gets_the_body_where_it_is() -> None:
    stage = Stage()
    first = stage.join("chair1")
    for _ in range(20):
        stage.act("chair1", 0.5, 0.5)
    stage.token("chair1", present=False)
    stage.result("pause")
    second = stage.join("chair1", instance="b" * 16)
    assert second.session != first.session
    assert second.position.x > first.position.x + 0.1
    assert [code for code in stage.events() if code in ("lost", "returned", "left", "joined")] == [
        "joined",
        "lost",
        "returned",
    ]


def test_the_old_twin_is_told_that_its_session_is_over() -> None:
    stage = Stage()
    old = stage.join("chair1").session
    stage.token("chair1", present=False)
    stage.result("pause")
    stage.join("chair1", instance="b" * 16)
    stage.put("chair1", Actions(session=old, left_motor=1.0, right_motor=1.0))
    assert [e.code for e in stage.errors("chair1")] == ["session"]


def test_a_lost_token_removes_the_body_after_the_grace_time() -> None:
    stage = Stage(strict=False, pace="realtime")
    stage.join("chair1")
    stage.token("chair1", present=False)
    stage.work(2.9)
    assert stage.conductor.state.names == ("chair1",)
    stage.work(0.2)
    assert len(stage.conductor.state.names) == 0
    assert [code for code in stage.events() if code != "timeout"] == ["joined", "lost", "left"]


def test_a_token_that_returns_within_the_grace_time_is_as_if_nothing_was() -> None:
    stage = Stage(strict=False, pace="realtime")
    stage.join("chair1")
    stage.token("chair1", present=False)
    stage.work(1.0)
    stage.token("chair1")
    stage.work(5.0)
    assert stage.conductor.state.names == ("chair1",)
    assert "returned" in stage.events()


def test_in_strict_lockstep_a_member_lost_for_the_grace_time_is_a_miss() -> None:
    stage = Stage()
    stage.join("chair1")
    stage.token("chair1", present=False)
    stage.work(3.1)
    assert stage.conductor.exit == 1


def test_who_has_not_joined_is_told_a_few_times() -> None:
    stage = Stage()
    for number in range(50):
        stage.put("ghost", Actions(seq=number))
    assert {e.code for e in stage.errors("ghost")} == {"not-joined"}
    assert len(stage.errors("ghost")) <= 10


def test_a_flood_is_told_and_bounded() -> None:
    stage = Stage()
    stage.join_two()
    for number in range(5000):
        stage.put("chair1", Actions(seq=number))
    assert len(stage.errors("chair1")) <= 20
    stage.work(1.0)
    stage.put("chair1", b"rubbish")
    assert stage.errors("chair1")[-1].suppressed > 4000


def test_a_flood_of_user_input_leaves_the_agent_its_voice() -> None:
    stage = Stage()
    stage.join("chair1")
    for number in range(1000):
        stage.put("chair1", UserInput(seq=number), "user")
    stage.act("chair1", 0.5, 0.5)
    assert stage.tick == 1


def test_a_mind_joins_the_body_of_another_process() -> None:
    stage = Stage()
    mind = Robot(role="mind")
    refused, ok = stage.try_join("chair1", mind, "b" * 16)
    assert not ok
    assert isinstance(refused, Refused)
    assert refused.code == "no-body"
    stage.join("chair1", msgspec.structs.replace(robot("rear-wheel"), role="body"))
    joined = stage.join("chair1", mind, "b" * 16, encoding=Encoding.XML)
    assert joined.robot.top_speed > 0.0
    assert [(e, m.tick) for a, k, m, e in stage.sent if k == "measures" and isinstance(m, Measures)][-1] == (
        Encoding.XML,
        0,
    )
    stage.act("chair1", 0.5, 0.5)
    assert stage.tick == 1


def test_the_reserved_name_and_crews_are_refused() -> None:
    stage = Stage()
    for agent, more, code in (("operator", {}, "name"), ("chair1", {"crew": "many"}, "value")):
        refused, ok = stage.try_join(agent, **more)
        assert not ok
        assert isinstance(refused, Refused)
        assert refused.code == code


# ---------------------------------------------------------------- real time and free


def test_real_time_keeps_its_ticks_at_any_speed() -> None:
    stage = Stage(pace="realtime", speed=4.0)
    stage.work(10.01)
    assert stage.tick == 800
    clock = stage.of("clock")[-1]
    assert (clock.state, clock.late, clock.speed) == ("running", 0, 4.0)
    assert clock.factor == pytest.approx(4.0, rel=0.05)


def test_state_and_clock_go_out_sixty_times_a_second_at_most() -> None:
    stage = Stage(pace="realtime", speed=50.0)
    stage.work(1.0)
    assert stage.tick >= 999
    assert 50 <= len(stage.of("clock")) <= 62


def test_the_last_state_before_a_pause_goes_out() -> None:
    stage = Stage(pace="realtime", speed=50.0)
    stage.work(0.503)
    stage.result("pause")
    assert stage.of("state")[-1].tick == stage.tick
    assert stage.of("clock")[-1].state == "paused"


def test_newest_wins_for_who_is_not_awaited() -> None:
    stage = Stage(pace="realtime")
    stage.join("chair1")
    stage.act("chair1", 1.0, 1.0, seq=2)
    stage.act("chair1", -1.0, -1.0, seq=1)
    stage.work(0.3)
    assert stage.of("state")[-1].entity[0].speed > 0.0


def test_running_free_refuses_who_wants_to_be_waited_for() -> None:
    stage = Stage(pace="free")
    stage.result("pause")
    refused, ok = stage.try_join("chair1")
    assert not ok
    assert isinstance(refused, Refused)
    assert "--open-loop" in refused.text
    assert isinstance(stage.join("chair1", barrier=False), Joined)


# ---------------------------------------------------------------- verbs


def test_pause_stops_resume_goes_on_and_both_name_tick_and_hash() -> None:
    stage = Stage(pace="realtime")
    stage.work(1.0)
    paused = stage.result("pause")
    tick = stage.tick
    assert (paused.code, paused.tick, paused.hash) == ("ok", tick, stage.conductor.digest())
    stage.work(5.0)
    assert stage.tick == tick
    assert stage.result("resume").code == "ok"
    stage.work(1.01)
    assert stage.tick == tick + 20
    assert stage.of("clock")[-1].late == 0
    assert stage.events() == ["paused", "resumed"]


def test_steps_are_made_while_paused_and_answered_when_made() -> None:
    stage = Stage(pace="realtime")
    assert stage.result("step", Step(count=3)).code == "incorrect-state"
    stage.result("pause")
    replies = stage.ask("ctl", "step", Step(count=3))
    stage.work(0.5)
    result = replies[0][0]
    assert isinstance(result, Result)
    assert (result.code, result.tick) == ("ok", stage.tick)
    assert stage.tick == 3


def test_steps_in_lockstep_wait_for_answers() -> None:
    stage = Stage()
    stage.join("chair1")
    stage.result("pause")
    replies = stage.ask("ctl", "step", Step(count=2))
    stage.act("chair1")
    stage.act("chair1")
    assert (stage.tick, len(replies)) == (2, 1)
    stage.act("chair1")
    assert stage.tick == 2


def test_a_paused_strict_run_misses_nobody() -> None:
    stage = Stage()
    stage.join("chair1")
    stage.result("pause")
    stage.work(60.0)
    assert stage.conductor.exit is None
    stage.result("resume")
    stage.work(9.0)
    assert stage.conductor.exit is None


def test_a_reset_begins_a_new_run_with_the_same_joins_and_sessions() -> None:
    stage = Stage()
    stage.join("chair1")
    for _ in range(10):
        stage.act("chair1", 0.5, 0.5)
    result_later = stage.ask("ctl", "reset", Reset(seed="2"))
    stage.act("chair1", 0.5, 0.5)
    result = result_later[0][0]
    assert isinstance(result, Result)
    assert (result.code, result.tick) == ("ok", 0)
    assert result.run not in (None, RUN)
    assert stage.measures("chair1")[-1].run == result.run
    stage.act("chair1", 0.5, 0.5)
    assert stage.tick == 1
    assert stage.of("map")[-1].run == result.run


def test_load_puts_another_floor_in_or_says_why_not() -> None:
    stage = Stage()
    stage.join("chair1")
    stage.result("pause")
    assert stage.result("load", Load(name="nowhere")).code == "not-found"
    assert stage.conductor.state.run == RUN
    assert stage.result("load", Load(name="corner")).code == "ok"
    info = stage.of("map")[-1]
    assert (info.name, info.revision) == ("corner", 1)
    assert isinstance(stage.ask("map", "")[0][0], Map)


def test_speed_is_for_real_time() -> None:
    assert Stage().result("speed", Speed(factor=2.0)).code == "incorrect-state"
    stage = Stage(pace="realtime")
    assert stage.result("speed", Speed(factor=10.0)).code == "ok"
    stage.work(1.001)
    assert stage.tick == 200


def test_bodies_are_spawned_teleported_and_deleted() -> None:
    stage = Stage(pace="realtime")
    spawned = msgspec.structs.replace(robot("table"), name="table9", format=None)
    assert stage.result("spawn", Spawn(robot=spawned)).code == "ok"
    body = stage.of("body", "table9")[-1]
    assert (body.owner, body.roles) == (None, ())
    at = stage.conductor.state
    x, y = float(at.numbers[0, 0]), float(at.numbers[1, 0])
    teleport = Teleport(agent="table9", position=Position(x=x + 0.2, y=y, heading=0.0))
    assert stage.result("teleport", teleport).code == "ok"
    assert stage.result("delete", b'{"Agent":"table9"}').code == "ok"
    assert stage.result("delete", b'{"Agent":"table9"}').code == "not-found"


@pytest.mark.parametrize("verb", ["save", "restore", "seek"])
def test_what_is_not_there_yet_is_unsupported(verb: str) -> None:
    data = {"save": b"", "restore": b'{"Slot":"one"}', "seek": b'{"Tick":3}'}[verb]
    assert Stage().result(verb, data).code == "unsupported"


def test_an_operators_words_are_heard_at_once() -> None:
    stage = Stage()
    stage.join("chair1")
    replies = stage.ask("ctl", "say", b'{"Text":"stop please"}')
    stage.act("chair1")
    assert isinstance(replies[0][0], Result)
    assert [(h.sender, h.text) for h in stage.measures("chair1")[-1].message] == [("operator", "stop please")]


def test_quit_ends_with_0() -> None:
    stage = Stage()
    assert stage.result("quit").code == "ok"
    assert stage.conductor.exit == 0


def test_a_bad_verb_is_told_why() -> None:
    stage = Stage()
    reply, ok = stage.ask("ctl", "speed", b'{"Factor":0}')[0]
    assert not ok
    assert isinstance(reply, Result)
    assert reply.text is not None
    assert reply.text.startswith("Speed.Factor: ")
    reply, ok = stage.ask("ctl", "")[0]
    assert isinstance(reply, Result)
    assert reply.code == "unsupported"


def test_the_end_is_told_with_tick_and_hash_and_resume_goes_on() -> None:
    stage = Stage(end=End(timeout=Timeout(seconds=0.1)))
    stage.join("chair1")
    stage.act("chair1")
    stage.act("chair1")
    assert stage.lines[-1] == f"ended tick=2 hash={stage.conductor.digest()}"
    assert stage.of("clock")[-1].state == "ended"
    stage.act("chair1")
    assert stage.tick == 2
    assert stage.result("resume").code == "ok"
    assert stage.tick == 3


def test_the_end_may_be_the_end_of_the_service() -> None:
    stage = Stage(end=End(timeout=Timeout(seconds=0.05)), quit_at_end=True)
    stage.join("chair1")
    stage.act("chair1")
    assert stage.conductor.exit == 0


# ---------------------------------------------------------------- users, says, events


def test_a_taken_chair_obeys_the_user_until_the_lease_ends() -> None:
    stage = Stage(pace="realtime", strict=False)
    stage.join("chair1")
    taken = stage.result("take", Take(agent="chair1"))
    assert taken.lease is not None
    stage.put("chair1", UserInput(lease=taken.lease, forward=1.0, seq=1), "user")
    stage.work(0.25)
    assert stage.of("state")[-1].entity[0].speed > 0.1
    assert stage.of("state")[-1].entity[0].state == "taken"
    stage.put("chair1", UserInput(forward=-1.0), "user")
    assert stage.errors("chair1")[-1].code == "lease"
    stage.work(2.0)
    assert stage.of("state")[-1].entity[0].speed == pytest.approx(0.0, abs=1e-3)
    assert [code for code in stage.events() if code in ("taken", "released")] == ["taken", "released"]


def test_a_lease_is_renewed_and_freed_by_its_holder_only() -> None:
    stage = Stage(pace="realtime", strict=False)
    stage.join("chair1")
    lease = stage.result("take", Take(agent="chair1")).lease
    assert stage.result("take", Take(agent="chair1")).code == "incorrect-state"
    stage.work(1.5)
    assert stage.result("take", Take(agent="chair1", lease=lease)).lease == lease
    stage.work(1.5)
    assert stage.result("take", Take(agent="chair1", lease=lease, seconds=0.0)).code == "ok"
    assert stage.events().count("released") == 1
    assert stage.result("take", Take(agent="chair9")).code == "not-found"


def test_user_input_rides_in_the_measures_of_who_declares_it() -> None:
    stage = Stage(pace="realtime", strict=False)
    stage.join("chair1", user_input=("drive",))
    stage.put("chair1", UserInput(forward=0.5, turn=0.1, seq=3), "user")
    stage.work(0.06)
    heard = stage.measures("chair1")[-1].user_input
    assert heard is not None
    assert (heard.forward, heard.turn) == (0.5, 0.1)
    stage.work(0.5)
    heard = stage.measures("chair1")[-1].user_input
    assert heard is None or heard.forward == 0.0


def test_words_are_heard_in_the_next_measures_in_any_encoding() -> None:
    stage = Stage()
    stage.join_two()
    for data, encoding in ((b"hello", "text/plain"), (b'<Say Seq="2"><![CDATA[hello]]></Say>', "application/xml")):
        stage.put("chair1", data, "say", encoding)
        stage.act("chair1", seq=stage.tick)
        stage.act("chair2", seq=stage.tick)
        assert [(h.sender, h.text) for h in stage.measures("chair2")[-1].message] == [("chair1", "hello")]


def test_a_long_say_is_told_and_the_motors_count() -> None:
    stage = Stage()
    stage.join("chair1")
    stage.act("chair1", 0.5, 0.5, say="x" * 101)
    assert stage.errors("chair1")[-1].code == "too-long"
    assert stage.tick == 1
    stage.put("chair1", Say(text="y" * 101), "say")
    assert stage.errors("chair1")[-1].where == "Say"


def test_events_are_numbered_and_asked_for() -> None:
    stage = Stage()
    stage.join("chair1")
    stage.result("pause")
    events = stage.ask("event", "", parameters={"since": "1"})[0][0]
    assert [event.code for event in events.event] == ["paused"]  # type: ignore[attr-defined]
    assert not stage.ask("event", "", parameters={"since": "x"})[0][1]


def test_state_and_bodies_are_asked_for_by_late_viewers() -> None:
    stage = Stage()
    stage.join("chair1")
    assert [type(reply) for reply, _ in stage.ask("state", "")] == [WorldState]
    assert [type(reply) for reply, _ in stage.ask("body", "")] == [Body]
    assert stage.ask("body", "", matches=lambda name: name == "chair2") == []


# ---------------------------------------------------------------- real chairs


def real(**more: Any) -> Robot:
    return msgspec.structs.replace(robot("rear-wheel"), type="real", **more)


def test_real_hardware_is_refused_where_time_is_not_real() -> None:
    for options in ({"pace": "lockstep"}, {"pace": "realtime", "speed": 2.0}):
        stage = Stage(**options)
        refused, ok = stage.try_join("chair1", real())
        assert not ok
        assert isinstance(refused, Refused)
        assert refused.code == "real-in-lockstep"
    assert Stage().try_join("chair1", real(hardware="simulated"))[1]


def test_a_real_chair_is_where_its_bridge_says_and_gets_power_each_tick() -> None:
    stage = Stage(pace="realtime", strict=False)
    session = stage.join("chair1", real()).session
    for tick in range(10):
        stage.put("chair1", Pose(session=session, x=2.0, y=2.0 + 0.01 * tick, heading=0.0), "pose")
        stage.act("chair1", 0.5, 0.5)
        stage.work(0.0501)
    assert stage.of("state")[-1].entity[0].y == pytest.approx(2.09, abs=0.011)
    powers = stage.of("power", "chair1")
    assert [p.tick for p in powers] == list(range(len(powers)))
    assert (powers[-1].left_motor, powers[-1].state) == (0.5, "drive")


def test_a_real_chair_needs_its_session() -> None:
    stage = Stage(pace="realtime", strict=False)
    stage.join("chair1", real())
    stage.put("chair1", Pose(x=2.0, y=2.0, heading=0.0), "pose")
    stage.put("chair1", Actions(left_motor=1.0))
    assert [e.code for e in stage.errors("chair1")] == ["session", "session"]


def test_a_simulated_chair_reports_no_pose() -> None:
    stage = Stage(pace="realtime", strict=False)
    stage.join("chair1")
    stage.put("chair1", Pose(x=2.0, y=2.0, heading=0.0), "pose")
    assert [e.code for e in stage.errors("chair1")] == ["role"]


def test_a_bridge_that_falls_silent_makes_its_chair_stale_until_it_reports() -> None:
    stage = Stage(pace="realtime", strict=False)
    session = stage.join("chair1", real()).session
    stage.work(1.0)
    stage.put("chair1", Pose(session=session, x=2.0, y=2.0, heading=0.0), "pose")
    stage.work(0.2)
    assert [code for code in stage.events() if code in ("stale", "fresh")] == ["stale", "fresh"]


def test_pause_and_speed_stop_real_chairs() -> None:
    stage = Stage(pace="realtime", strict=False)
    session = stage.join("chair1", real()).session

    def drive() -> PowerInForce:
        stage.put("chair1", Pose(session=session, x=2.0, y=2.0, heading=0.0), "pose")
        stage.act("chair1", 0.5, 0.5)
        stage.work(0.06)
        power: PowerInForce = stage.of("power", "chair1")[-1]
        return power

    assert drive().left_motor == 0.5
    stage.result("pause")
    stage.work(0.2)
    power = stage.of("power", "chair1")[-1]
    assert (power.left_motor, power.state) == (0.0, "paused")
    stage.result("resume")
    assert drive().left_motor == 0.5
    stage.result("speed", Speed(factor=2.0))
    assert drive().left_motor == 0.0
    stage.result("speed", Speed(factor=1.0))
    assert drive().left_motor == 0.5
    stage.conductor.finish(stage.now)
    assert stage.of("power", "chair1")[-1].left_motor == 0.0


def test_in_lockstep_a_simulated_bridge_answers_with_its_pose() -> None:
    stage = Stage()
    stage.result("pause")
    body = stage.join("chair1", real(hardware="simulated", role="body")).session
    mind = stage.join("chair1", Robot(role="mind"), "b" * 16).session
    stage.result("resume")
    stage.put("chair1", Pose(session=body, tick=0, x=2.0, y=2.0, heading=0.0), "pose")
    assert stage.tick == 0
    stage.put("chair1", Actions(session=mind, tick=0, left_motor=0.25, right_motor=0.25))
    assert stage.tick == 1
    assert stage.of("power", "chair1")[-1].tick == 0


# ---------------------------------------------------------------- the log


def same(path: Path) -> None:
    found = resimulate(path)
    assert found.differs is None
    assert not found.cut


def test_a_log_of_an_elastic_run_with_everything_in_it_gives_the_same_hashes(tmp_path: Path) -> None:
    path = tmp_path / "run.jsonl"
    stage = Stage(strict=False, log=path)
    stage.join_two(user_input=("drive",))
    lease = stage.ask("ctl", "take", Take(agent="chair1", seconds=2.0))
    for tick in range(30):
        stage.act("chair1", 0.5, 0.4, say="hello" if tick % 5 == 0 else None)
        if tick % 3:
            stage.put("chair2", UserInput(forward=0.5, seq=tick), "user")
            stage.act("chair2", 0.2, 0.3)
        stage.work(1.01)
    assert isinstance(lease[0][0], Result)
    stage.token("chair2", instance="b" * 16, present=False)
    stage.work(4.0)
    stage.ask("ctl", "reset", Reset(seed="7"))
    stage.work(1.1)
    for _ in range(5):
        stage.act("chair1", -0.3, 0.4)
    stage.result("pause")
    stage.result("load", Load(name="corner"))
    stage.result("resume")
    for _ in range(5):
        stage.act("chair1", 0.3, 0.4)
    stage.result("pause")
    stage.conductor.finish(stage.now)
    assert stage.log is not None
    stage.log.close()
    assert stage.tick >= 5
    same(path)


def test_a_changed_log_differs_at_the_tick_it_was_changed(tmp_path: Path) -> None:
    path = tmp_path / "run.jsonl"
    stage = Stage(log=path)
    stage.join("chair1")
    for _ in range(10):
        stage.act("chair1", 0.5, 0.5)
    stage.conductor.finish(stage.now)
    assert stage.log is not None
    stage.log.close()
    same(path)
    lines = path.read_bytes().splitlines(keepends=True)
    lines[5] = lines[5].replace(b'"LeftMotor":0.5', b'"LeftMotor":0.6')
    path.write_bytes(b"".join(lines))
    found = resimulate(path)
    assert found.differs is not None
    assert found.differs.startswith(f"tick 4 of run {RUN} (line 6): expected hash ")


def test_two_strict_runs_with_one_seed_give_one_hash_whatever_the_timing() -> None:
    hashes = []
    for delay in (0.0, 0.3):
        stage = Stage()
        stage.join_two()
        order: list[str] = ["chair1", "chair2"] if delay else ["chair2", "chair1"]
        for tick in range(40):
            for agent in order:
                stage.act(agent, 0.5, 0.4 + 0.005 * tick)
                stage.work(delay)
        hashes.append(stage.conductor.digest())
    assert hashes[0] == hashes[1]
