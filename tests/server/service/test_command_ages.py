"""In a run that does not wait, an agent that is slower than a tick drives. Too old a command is dropped."""

from __future__ import annotations

from pathlib import Path

import pytest

from intellwheels_schemas.messages import Actions
from intellwheels_server.log.resimulate import resimulate
from intellwheels_server.service.command_ages import CommandAges
from tests.server.stage import RUN, Stage


def drive(delay: float, seconds: float = 2.0, log: Path | None = None) -> Stage:
    """Let a chair be driven by an agent that puts each answer so many seconds after the measures came."""
    stage = Stage(pace="realtime", log=log)
    stage.join("chair1")
    answered = 0
    waiting: list[tuple[float, int]] = []
    for _ in range(round(seconds / 0.01)):
        stage.work(0.01)
        for measures in stage.measures("chair1")[answered:]:
            waiting.append((stage.now + delay, measures.tick))
            answered += 1
        while waiting and waiting[0][0] <= stage.now + 1e-9:
            stage.act("chair1", 0.5, 0.5, tick=waiting.pop(0)[1])
    return stage


def x_of(stage: Stage) -> float:
    stage.work(0.1)
    return float(stage.of("state")[-1].entity[0].x)


@pytest.mark.parametrize(("delay", "age"), [(0.06, 0.05), (0.2, 0.2)])
def test_slow_agent_drives_and_the_mean_age_of_its_commands_is_shown(delay: float, age: float) -> None:
    stage = drive(delay)
    assert stage.errors("chair1") == []
    assert x_of(stage) > 1.2 + 0.4  # from start1
    assert stage.of("state")[-1].entity[0].command_age == pytest.approx(age, abs=0.05)


def test_agent_that_is_too_slow_is_told_and_does_not_drive() -> None:
    stage = drive(0.4)
    error = stage.errors("chair1")[-1]
    assert error.code == "late"
    assert "or later, at most 0.3 s late, got " in error.text
    assert x_of(stage) == 1.2
    assert stage.of("state")[-1].entity[0].command_age == 0.0


def test_agent_in_time_has_no_age() -> None:
    stage = drive(0.0)
    assert x_of(stage) > 1.2 + 0.4
    assert stage.of("state")[-1].entity[0].command_age == 0.0


def test_log_of_a_slow_agent_is_run_again_to_the_same_hashes(tmp_path: Path) -> None:
    stage = drive(0.2, seconds=1.0, log=tmp_path / "run.jsonl")
    assert stage.log is not None
    stage.log.close()
    text = (tmp_path / "run.jsonl").read_text()
    assert resimulate(tmp_path / "run.jsonl").ticks == stage.tick
    # The line is that of the tick at which the command acted; the command has the tick that it answers.
    line = next(line for line in text.splitlines() if '"Actions"' in line)
    assert line.startswith(('{"Tick":4,', '{"Tick":5,'))
    assert '"Tick":0,"Seq"' in line or '"Tick":0,"LeftMotor"' in line


def test_lockstep_takes_no_late_command() -> None:
    stage = Stage(strict=False)
    stage.join("chair1")
    stage.work(1.5)  # a missed deadline
    assert stage.tick == 1
    stage.act("chair1", 0.5, 0.5, tick=0)
    assert [error.code for error in stage.errors("chair1")] == ["late"]


# ---------------------------------------------------------------- which one is the newest


def ages_with(*taken: Actions, tick: int = 10) -> CommandAges:
    ages = CommandAges(0.05)
    for actions in taken:
        ages.take("a", actions, tick)
    return ages


@pytest.mark.parametrize(
    ("actions", "text"),
    [
        (Actions(run=RUN, tick=4), None),
        (
            Actions(run=RUN, tick=3),
            "Actions.Tick: expected 4 or later, at most 0.3 s late, got 3; it was not used, because the mind or the "
            "machine is too slow",
        ),
        (Actions(tick=9), "Actions.Tick: expected 10, or also a Run, got 9"),
        (Actions(run="f" * 16, tick=9), "Actions.Tick: expected 10, or also a Run, got 9"),
    ],
)
def test_late_command_counts_in_its_run_for_a_short_time(actions: Actions, text: str | None) -> None:
    fault = ages_with().check_late("a", actions, RUN, 10)
    assert (fault.text if fault else None) == text


@pytest.mark.parametrize(
    ("tick", "seq", "counts"), [(7, 7, False), (8, 8, False), (8, 9, True), (8, None, True), (9, 1, True)]
)
def test_command_older_than_the_newest_is_dropped(tick: int, seq: int | None, counts: bool) -> None:
    ages = ages_with(Actions(run=RUN, tick=8, seq=8))
    fault = ages.check_late("a", Actions(run=RUN, tick=tick, seq=seq, left_motor=0.1), RUN, 10)
    assert (fault is None) == counts
    if fault is not None:
        assert (fault.code, fault.text) == ("late", f"Actions.Tick: expected more than 8, which has acted, got {tick}")


def test_message_without_a_command_may_be_older_than_the_newest_command() -> None:
    ages = ages_with(Actions(run=RUN, tick=8, left_motor=0.1))
    assert ages.check_late("a", Actions(run=RUN, tick=7, mode="autonomous"), RUN, 10) is None


def test_message_without_a_command_does_not_make_a_late_command_old() -> None:
    stage = Stage(pace="realtime", strict=False)
    stage.join("chair1")
    stage.work(0.3)
    stage.act("chair1", mode="autonomous")
    stage.act("chair1", 0.5, 0.5, tick=stage.tick - 2)
    assert stage.errors("chair1") == []


def test_agent_that_is_late_now_and_then_is_not_slow() -> None:
    assert ages_with(Actions(tick=9), Actions(tick=10), Actions(tick=10)).means() == {}
    assert ages_with(Actions(tick=9), Actions(tick=10)).means() == {"a": 0.025}


def test_age_is_the_mean_of_a_run_and_is_forgotten_with_it() -> None:
    ages = ages_with(Actions(tick=9), Actions(tick=8), Actions(tick=10), Actions())
    assert ages.means() == {"a": 0.0375}
    ages.forget("a")
    assert ages.means() == {}
    ages = ages_with(Actions(tick=9))
    ages.clear()
    assert ages.means() == {}


def test_limit_is_whole_ticks_for_any_period() -> None:
    for period, limit in ((0.1, 3), (0.3, 1), (0.02, 15), (1.0, 0)):
        ages = CommandAges(period)
        assert ages.check_late("a", Actions(run=RUN, tick=100 - limit), RUN, 100) is None
        assert ages.check_late("a", Actions(run=RUN, tick=99 - limit), RUN, 100) is not None


def test_punctual_commands_count_together_as_each_by_itself() -> None:
    late, punctual = Actions(tick=8, seq=1), Actions(tick=10, seq=2)
    ages = ages_with(late)
    ages.take_punctual({"a": punctual, "b": punctual})
    assert ages.means() == ages_with(late, punctual).means() == {"a": 0.05}
    assert ages.check_late("b", Actions(run=RUN, tick=9, left_motor=0.1), RUN, 11) is not None
