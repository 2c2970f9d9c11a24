"""A crew's harness against the real service, in one process: what one puts, the other takes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import msgspec
import pytest

from intellwheels_agents import minds
from intellwheels_agents.crew_harness import (
    AskBodyOf,
    CrewHarness,
    CrewMember,
    CrewOutput,
    RequestCrewJoin,
    RequestCrewLeave,
)
from intellwheels_agents.harness_outputs import AskClock, Exit, Log, Print, Publish
from intellwheels_agents.mind import Context
from intellwheels_agents.options import OptionError, Options
from intellwheels_agents.robot_document import equipped, joining, split_options
from intellwheels_maps import robot, scene
from intellwheels_schemas.codec import Encoding, encode
from intellwheels_schemas.crew_messages import read_actions, split_measures
from intellwheels_schemas.messages import (
    Actions,
    Clock,
    CrewError,
    CrewJoined,
    CrewMeasures,
    Measures,
    Record,
)
from intellwheels_server.service.roster import presence_of
from intellwheels_server.world import digest
from tests.agents.arena import Arena
from tests.server.stage import JSON, Stage

INSTANCE = "c" * 16
CHAIR = msgspec.structs.replace(robot("rear-wheel"), format=None)


class Driver:
    """Drives ahead, and does what a test wants at a tick."""

    def __init__(self, context: Context) -> None:
        self.context = context
        self.map = context.map
        DRIVERS.append(self)

    def decide(self, measures: Measures) -> Actions:
        return ACTS.get(self.context.agent, ahead)(measures)


DRIVERS: list[Driver] = []
ACTS: dict[str, Callable[[Measures], Actions]] = {}


def ahead(_measures: Measures) -> Actions:
    return Actions(left_motor=0.5, right_motor=0.5)


@pytest.fixture(autouse=True)
def _nothing_special() -> None:
    DRIVERS.clear()
    ACTS.clear()


def member(name: str, **fields: Any) -> CrewMember:
    document = joining(CHAIR, agent=name, role="both", instance=INSTANCE, place=None, barrier=None)
    return CrewMember(msgspec.structs.replace(document, **fields), Driver, {})


class Crew:
    """A crew's harness and the service that it talks to."""

    def __init__(self, *members: CrewMember, stage: Stage | None = None, encoding: Encoding = JSON) -> None:
        self.stage = stage or Stage()
        self.maps = 0
        self.encoding = encoding
        self.harness = CrewHarness("c", INSTANCE, members, encoding=encoding, fetch_map=self._map, retry_for=5.0)
        self.outputs: list[CrewOutput] = []
        for each in members:
            self.stage.token(each.robot.name or "", each.robot.role, presence_of(INSTANCE, "c"))
        self._read = 0

    def _map(self) -> Any:
        self.maps += 1
        return self.stage.live_run.state.setup.floor

    def do(self, outputs: list[CrewOutput]) -> None:
        """Do what the harness wants, and give it the answers."""
        self.outputs += outputs
        stage, harness = self.stage, self.harness
        for output in outputs:
            if isinstance(output, RequestCrewJoin):
                ((reply, ok),) = stage.ask("crew-join", "c", output.payload, encoding=self.encoding)
                take = harness.joined if ok else harness.refused
                self.do(take((encode(reply), JSON), output.agents, stage.now))
            elif isinstance(output, Publish):
                stage.put("c", output.payload, "crew", self.encoding.value)
            elif isinstance(output, RequestCrewLeave):
                stage.ask("crew-leave", "c", output.payload, encoding=self.encoding)
            elif isinstance(output, AskClock):
                state = stage.live_run.state
                clock = Clock(
                    run=state.run, tick=state.tick, time=0.0, state="running", pace="lockstep", hash="0" * 16, stamp=1.0
                )
                self.do(harness.clocked([(encode(clock), JSON)]))
            elif isinstance(output, AskBodyOf):
                self.do(harness.bodied(output.agent, output.agent in stage.live_run.state.names))

    def pump(self) -> None:
        """Give the harness all that the service put for the crew and has not been given yet."""
        new, self._read = self.stage.sent[self._read :], len(self.stage.sent)
        for to, kind, message, encoding in new:
            if to == "c" and kind == "crew-measures":
                self.do(self.harness.measured([split_measures(encode(message, encoding), encoding)], encoding))
            elif to == "c" and kind == "crew-error":
                self.do(self.harness.erred((encode(message, encoding), encoding), self.stage.now))

    def start(self) -> None:
        self.do(self.harness.start(self.stage.now))

    def ticks(self, count: int) -> None:
        first = self.stage.tick
        for _ in range(20 * count):
            if self.stage.tick >= first + count:
                return
            self.pump()
            if self.stage.live_run._service.pacing.pace == "realtime":
                self.stage.work(0.05)
                self.pump()
        raise AssertionError(f"expected {count} ticks, got {self.stage.tick - first}")

    def of(self, kind: type[Any]) -> list[Any]:
        return [output for output in self.outputs if isinstance(output, kind)]

    def lines(self) -> list[str]:
        return [output.line for output in self.outputs if isinstance(output, Log)]


@pytest.mark.parametrize("encoding", list(Encoding))
def test_crew_answers_each_tick_with_one_message(encoding: Encoding) -> None:
    crew = Crew(member("c1"), member("c2"), member("c3"), encoding=encoding)
    crew.start()
    assert [output.line.split()[1] for output in crew.of(Print)] == ["agent=c1", "agent=c2", "agent=c3"]
    crew.ticks(5)
    assert len(crew.of(RequestCrewJoin)) == 1
    assert len(crew.of(Publish)) == crew.stage.tick
    assert len(DRIVERS) == 3
    # All of them have the same map, which is fetched once.
    assert crew.maps == 1
    crew.do(crew.harness.stop())
    assert crew.stage.live_run.state.names == ()
    assert len(crew.of(RequestCrewLeave)) == 1
    assert crew.of(Exit) == [Exit(0)]
    assert crew.lines()[-1] == "counted agents=3 missed=0 repeated=0 errors=0"


def test_cast_of_figure6_in_a_crew_has_the_hashes_that_it_has_without() -> None:
    script, arena, members = scene("figure6"), Arena.of(scene("figure6")), []
    for one in script.cast:
        of_robot, of_mind = split_options({each.name: each.value for each in one.option})
        source = minds.find(one.mind or "")
        body = source.equip(equipped(robot(one.robot or ""), of_robot), Options(of_mind))
        document = joining(body, agent=one.name, role="both", instance=INSTANCE, place=one.place, barrier=None)
        members.append(CrewMember(document, source.make, of_mind))
    crew = Crew(*members, stage=Stage(strict=True, expect=tuple(one.name for one in script.cast)))
    crew.start()
    for _ in range(60):
        crew.ticks(1)
        arena.step()
        assert digest(crew.stage.live_run.state) == digest(arena.state)


def test_measures_that_come_again_are_answered_again() -> None:
    crew = Crew(member("c1"), member("c2"))
    crew.start()
    (first,) = crew.stage.of("crew-measures", "c")
    whole = split_measures(encode(first), JSON)
    again = split_measures(encode(CrewMeasures(crew="c", measures=first.measures[1:])), JSON)
    (answer,) = crew.harness.measured([whole], JSON)
    (second,) = crew.harness.measured([again], JSON)
    assert isinstance(answer, Publish)
    assert isinstance(second, Publish)
    assert read_actions("c", second.payload, JSON) == read_actions("c", answer.payload, JSON)[1:]


def test_mind_that_fails_ends_alone() -> None:
    def fails(_measures: Measures) -> Actions:
        raise RuntimeError("oh")

    ACTS["c2"] = fails
    crew = Crew(member("c1"), member("c2"), member("c3"))
    crew.start()
    crew.ticks(3)
    assert crew.stage.live_run.state.names == ("c1", "c3")
    (line,) = [line for line in crew.lines() if line.startswith("ended")]
    assert line.startswith("ended agent=c2 why=")
    assert "RuntimeError: oh" in line
    assert crew.of(Exit) == []
    crew.do(crew.harness.stop())
    # The process says that something failed.
    assert crew.of(Exit) == [Exit(1)]


def test_wrong_option_ends_all() -> None:
    def refuses(context: Context) -> Driver:
        raise OptionError("option to: expected a place")

    crew = Crew(CrewMember(member("c1").robot, refuses, {}))
    with pytest.raises(OptionError, match="a place"):
        crew.start()


def test_refused_agent_ends_alone_and_the_last_one_ends_the_crew() -> None:
    stage = Stage()
    stage.join("c2", instance="b" * 16)
    crew = Crew(member("c1"), member("c2"), stage=stage)
    stage.live_run._service.pacing.paused = True
    crew.start()
    assert any('ended agent=c2 why="refused (already-here)' in line for line in crew.lines())
    assert "c1" in stage.live_run.state.names
    alone = Crew(member("c2"), stage=stage)
    alone.start()
    assert alone.of(Exit) == [Exit(1)]


def test_mind_that_leaves_ends_alone() -> None:
    ACTS["c1"] = lambda measures: Actions(leave=measures.tick >= 2)
    crew = Crew(member("c1"), member("c2"))
    crew.start()
    crew.ticks(5)
    assert crew.stage.live_run.state.names == ("c2",)
    assert "left agent=c1" in [output.line for output in crew.of(Print)]
    assert crew.of(Exit) == []


def test_new_run_makes_new_minds_with_a_new_map() -> None:
    crew = Crew(member("c1"), member("c2"), stage=Stage(pace="realtime"))
    crew.start()
    crew.ticks(2)
    crew.stage.result("reset", b"{}")
    crew.ticks(3)
    assert len(crew.of(AskClock)) == 1
    assert (len(DRIVERS), crew.maps) == (4, 2)


def test_forgotten_crew_joins_again_with_one_request() -> None:
    crew = Crew(member("c1"), member("c2"), member("c3"), stage=Stage(pace="realtime"))
    crew.start()
    crew.ticks(2)
    error = CrewError(run=crew.stage.live_run.state.run, tick=3, code="not-joined", text="expected a crew that joined")
    crew.do(crew.harness.erred((encode(error), JSON), crew.stage.now))
    (line,) = [line for line in crew.lines() if line.startswith("erred")]
    assert line.startswith("erred agents=3 first=c1 code=not-joined")
    assert crew.harness.deadline is not None
    crew.do(crew.harness.wake(crew.harness.deadline))
    assert [len(request.agents) for request in crew.of(RequestCrewJoin)] == [3, 3]
    # The simulator still knew them: nothing changes.
    assert len(DRIVERS) == 3


def test_error_about_one_agent_or_about_the_message_is_in_the_log() -> None:
    crew = Crew(member("c1"), member("c2"))
    crew.start()
    run = crew.stage.live_run.state.run
    for agent in ("c2", None, "strange"):
        error = CrewError(run=run, tick=3, code="late", text="too late", agent=agent)
        crew.do(crew.harness.erred((encode(error), JSON), 1.0))
    crew.do(crew.harness.erred((b"?", JSON), 1.0))
    erred = [line for line in crew.lines() if line.startswith(("erred", "dropped"))]
    assert [line.split()[1] for line in erred] == ["agent=c2", "crew=c", "message=CrewError"]


def test_deleted_agent_stays_away_and_the_others_go_on() -> None:
    crew = Crew(member("c1"), member("c2"), stage=Stage(pace="realtime"))
    crew.start()
    crew.ticks(1)
    crew.stage.result("delete", b'{"Agent":"c1"}')
    crew.ticks(3)
    assert crew.of(AskBodyOf) == [AskBodyOf("c1")]
    assert "removed agent=c1 reason=deleted" in [output.line for output in crew.of(Print)]
    assert crew.stage.live_run.state.names == ("c2",)


@pytest.mark.parametrize("reply", [b"?", b"{}"])
def test_reply_that_cannot_be_read_is_asked_for_again(reply: bytes) -> None:
    crew = Crew(member("c1"))
    crew.harness.start(0.0)
    outputs = crew.harness.joined((reply, JSON), ("c1",), 0.0)
    assert isinstance(outputs[0], Log)
    assert crew.harness.deadline == 1.0


def test_agent_that_the_reply_does_not_name_asks_again() -> None:
    crew = Crew(member("c1"), member("c2"), stage=Stage(pace="realtime"))
    crew.start()
    joined = crew.stage.ask("crew-join", "c", crew.of(RequestCrewJoin)[0].payload)[0][0]
    assert isinstance(joined, CrewJoined)
    fresh = CrewHarness("c", INSTANCE, [member("c1"), member("c2")], fetch_map=crew._map)
    fresh.start(0.0)
    part: Record = msgspec.structs.replace(joined, joined=joined.joined[:1])
    fresh.joined((encode(part), JSON), ("c1", "c2"), 0.0)
    (again,) = [each for each in fresh.wake(1.0) if isinstance(each, RequestCrewJoin)]
    assert again.agents == ("c2",)


def test_nobody_answers_until_the_time_is_over() -> None:
    crew = Crew(member("c1"), member("c2"))
    crew.harness.start(0.0)
    assert crew.harness.unanswered(("c1", "c2"), 1.0) == [
        Log("waiting agents=2 first=c1 why='no simulator at the simulator, or not allowed'")
    ]
    outputs = crew.harness.unanswered(("c1", "c2"), 2.0)
    assert outputs == []
    crew.harness.wake(3.0)
    assert crew.harness.unanswered(("c1", "c2"), 10.0)[-1] == Exit(1)


def test_robots_that_do_not_fit_into_one_request_are_in_several() -> None:
    parts = (
        tuple(msgspec.structs.replace(CHAIR.part[0], length=0.5 + k / 1000) for k in range(32)) if CHAIR.part else ()
    )
    large = [member(f"c{k}", part=parts or CHAIR.part, proximity=CHAIR.proximity) for k in range(250)]
    harness = CrewHarness("c", INSTANCE, large, fetch_map=lambda: None)  # type: ignore[arg-type, return-value]
    requests = [output for output in harness.start(0.0) if isinstance(output, RequestCrewJoin)]
    assert sum(len(request.agents) for request in requests) == 250
    assert len(requests) > 1
    assert all(len(request.payload) <= 512 * 1024 for request in requests)
