from __future__ import annotations

import json
from pathlib import Path

from intellwheels_schemas.messages import Reset, Restore
from intellwheels_server.log.resimulate import resimulate
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


def test_joins_before_the_first_step_are_in_a_line_of_their_own(tmp_path: Path) -> None:
    stage = Stage(expect=("chair1",), log=tmp_path / "run.jsonl")
    stage.join("chair1")
    stage.act("chair1", 0.5, 0.5)
    assert stage.log is not None
    stage.log.close()
    joins, step = [json.loads(line) for line in (tmp_path / "run.jsonl").read_text().splitlines()[1:3]]
    assert (joins["Tick"], joins["Stepped"]) == (0, False)
    assert [change["Do"] for change in joins["Inputs"]["Changes"]] == ["Join"]
    assert (step["Tick"], "Changes" in step["Inputs"]) == (0, False)
    assert resimulate(tmp_path / "run.jsonl").ticks == 1
