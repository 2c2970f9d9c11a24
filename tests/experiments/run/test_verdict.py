"""A run is judged by what its scene says must hold."""

from __future__ import annotations

import pytest
from msgspec.structs import replace

from intellwheels_experiments.run.run_record import RunRecord
from intellwheels_experiments.run.verdict import judge
from intellwheels_schemas.messages import (
    Cast,
    End,
    Entity,
    Event,
    Grid,
    Hold,
    Map,
    Place,
    Reach,
    Scene,
    WorldState,
)

RUN = "0" * 16
FLOOR = Map(format="iw.v1", name="room", grid=Grid(position=(Place(name="goal1", x=5.0, y=1.0),)))


def scene(hold: Hold | None) -> Scene:
    return Scene(
        format="iw.v1",
        name="test",
        map="room",
        cast=(
            Cast(name="chair1", robot="rear-wheel", mind="waypoints"),
            Cast(name="table", robot="table", mind="table"),
        ),
        end=End(reach=(Reach(agent="chair1", place="goal1", within=0.3),)),
        hold=hold,
    )


def seen(x: float, contacts: int = 0) -> RunRecord:
    record = RunRecord()
    chair = Entity(name="chair1", x=x, y=1.0, heading=0.0, contacts=contacts)
    record.on_state(
        WorldState(run=RUN, tick=9, time=0.45, entity=(chair, Entity(name="table", x=0.0, y=0.0, heading=0.0)))
    )
    for number in range(contacts):
        record.on_event(Event(run=RUN, tick=9, number=number, code="contact"))
    return record


BOTH = Hold(contacts=0, reached="all")


def test_everything_held() -> None:
    verdict = judge(scene(BOTH), FLOOR, seen(4.8))
    assert verdict.held
    assert verdict.failed == ()
    assert [row.reached for row in verdict.agents] == [True, None]
    assert verdict.agents[0].distance == pytest.approx(0.2)


def test_place_that_was_not_reached_is_reported_with_the_distance() -> None:
    verdict = judge(scene(BOTH), FLOOR, seen(4.0))
    assert verdict.failed == ("agent 'chair1' did not end at 'goal1': it ended 1.00 m away",)


def test_one_contact_too_many_does_not_hold() -> None:
    assert judge(scene(BOTH), FLOOR, seen(5.0, contacts=1)).failed == ("contacts: expected at most 0, got 1",)
    assert judge(scene(Hold(contacts=1)), FLOOR, seen(5.0, contacts=1)).held


def test_contacts_of_a_body_count_when_events_were_lost() -> None:
    record = seen(5.0, contacts=2)
    record.events.clear()
    record.counts.clear()
    assert not judge(scene(BOTH), FLOOR, record).held


def test_run_without_an_end_does_not_hold() -> None:
    assert judge(scene(BOTH), FLOOR, seen(5.0), ended=False).failed == ("the run did not reach its end",)


def test_run_that_never_began_reports_nothing_else() -> None:
    assert judge(scene(BOTH), FLOOR, RunRecord(), ended=False).failed == ("the run did not reach its end",)


def test_agent_never_seen_does_not_hold() -> None:
    verdict = judge(scene(None), FLOOR, RunRecord())
    assert verdict.failed == ("agent 'chair1' was never seen", "agent 'table' was never seen")
    assert verdict.agents[0].distance is None


def test_scene_without_demands_holds_wherever_its_agents_are() -> None:
    assert judge(scene(None), FLOOR, seen(0.0, contacts=5)).held


def test_program_and_age_of_its_commands_are_in_the_result() -> None:
    cast = (Cast(name="chair1", command="./mine {name}"), Cast(name="table", robot="table", mind="table"))
    record = RunRecord()
    slow = Entity(name="chair1", x=0.0, y=0.0, heading=0.0, command_age=0.06)
    record.on_state(WorldState(run=RUN, tick=1, time=0.05, entity=(slow,)))
    (chair, table) = judge(replace(scene(None), cast=cast), FLOOR, record).agents
    assert (chair.mind, chair.robot, chair.command_age) == ("./mine {name}", "", 0.06)
    assert (table.mind, table.command_age) == ("table", 0.0)
