from __future__ import annotations

from intellwheels_schemas.messages import Reset, Restore
from tests.server.stage import Stage


def test_body_at_rest_in_the_saved_state_is_not_waited_for_until_it_answers() -> None:
    stage = Stage(strict=False)
    stage.join_two()
    for _ in range(4):
        stage.act("chair1")
        stage.work(1.1)
    assert "rested" in stage.events()
    stage.result("pause")
    stage.result("save")
    stage.result("restore", Restore(slot="s1"))
    stage.result("resume")
    tick = stage.tick
    stage.act("chair1")
    assert stage.tick == tick + 1
    stage.act("chair2")
    stage.act("chair1")
    assert stage.events()[-1] == "back"


def test_inputs_of_the_earlier_run_do_not_act_in_the_new_one() -> None:
    stage = Stage(pace="realtime")
    stage.join("chair1")
    stage.result("pause")
    stage.act("chair1", 1.0, 1.0)
    stage.result("reset", Reset())
    stage.result("resume")
    stage.work(0.2)
    assert stage.of("state")[-1].entity[0].speed == 0.0
