from __future__ import annotations

import msgspec

from intellwheels_maps import robot
from intellwheels_schemas.messages import Body, Event, Position, Teleport
from intellwheels_server.service.truth_filter import nominal, without_positions
from tests.server.stage import Stage

EVENT = Event(
    run="0" * 16, tick=3, number=1, code="contact", agent="a", other="wall", x=1.0, y=2.0, normal_x=1.0, speed=0.3
)
CROOKED = msgspec.structs.replace(robot("rear-wheel"), wheel_ratio=1.002, wheel_scale=0.99, track_ratio=1.01)


def test_event_keeps_its_agent_and_loses_its_position() -> None:
    assert without_positions(EVENT) == Event(run="0" * 16, tick=3, number=1, code="contact", agent="a", other="wall")


def test_speed_of_the_clock_is_not_hidden() -> None:
    event = Event(run="0" * 16, tick=3, number=1, code="speed", speed=2.0)
    assert without_positions(event) is event


def test_robot_is_published_with_the_figures_of_its_data_sheet() -> None:
    assert nominal(CROOKED) == robot("rear-wheel")
    assert nominal(robot("rear-wheel")) == robot("rear-wheel")


def test_laboratory_publishes_no_state_no_position_and_no_true_figure() -> None:
    stage = Stage(pace="realtime", strict=False, hide_truth=True)
    joined = stage.join("chair1", CROOKED)
    for _ in range(20):
        stage.act("chair1", 1.0, 1.0)
        stage.work(0.0501)
    assert stage.tick >= 19
    assert stage.of("state") == []
    assert stage.of("clock")[-1].tick >= 15
    assert stage.ask("state", "") == []
    (body,) = [reply for reply, _ in stage.ask("body", "")]
    assert isinstance(body, Body)
    assert body.robot.wheel_ratio == body.robot.wheel_scale == body.robot.track_ratio == 1.0
    assert joined.robot.wheel_ratio == 1.0
    # The chair has moved; who comes back with the same body learns where it began.
    assert stage.live_run.state.numbers[0, 0] > joined.position.x + 0.1
    assert stage.join("chair1", CROOKED).position == joined.position
    stage.result("teleport", Teleport(agent="chair1", position=Position(x=5.0, y=1.0, heading=0.0)))
    assert all(event.x is None and event.speed is None for event in stage.of("event"))
