"""A result has the same content for people and for programs."""

from __future__ import annotations

import io
import json
import shlex

import msgspec
from rich.console import Console

from intellwheels_experiments.run.run_report import Result, lines, show, to_json, versions
from intellwheels_experiments.run.verdict import AgentResult

RESULT = Result(
    scene="figure6",
    map="room",
    seed="1",
    pace="lockstep",
    world="main",
    run="0" * 16,
    finish="ended",
    words="",
    held=False,
    failed=("agent 'chair1' did not end at 'goal1': it ended 1.00 m away",),
    hash="00000000000000ff",
    ticks=812,
    time=40.6,
    wall=2.0,
    factor=20.3,
    late=0,
    contacts=0,
    events={"joined": 1},
    agents=(
        AgentResult(name="chair1", mind="waypoints", robot="rear-wheel", place="goal1", distance=1.0, reached=False),
    ),
    versions={"python": "3.11.0"},
)


def test_json_has_the_hash_and_comes_back_whole() -> None:
    data = to_json(RESULT)
    assert json.loads(data)["hash"] == "00000000000000ff"
    assert msgspec.json.decode(data, type=Result) == RESULT


def test_lines_are_a_verb_and_values() -> None:
    assert list(lines(RESULT)) == [
        "agent name=chair1 mind=waypoints robot=rear-wheel place=goal1 reached=no distance=1.000m contacts=0 "
        "path=0.00m age=0.000s turned_deg=0",
        "run ticks=812 time=40.60s wall=2.00s factor=20.3 contacts=0 late=0 seed=1 hash=00000000000000ff",
        "failed agent 'chair1' did not end at 'goal1': it ended 1.00 m away",
        "not-held scene=figure6 finish=ended",
    ]


def test_no_terminal_gets_lines_however_long() -> None:
    text = io.StringIO()
    show(RESULT, Console(file=text, width=20))
    assert text.getvalue().splitlines() == list(lines(RESULT))


def test_terminal_gets_a_table() -> None:
    text = io.StringIO()
    show(RESULT, Console(file=text, force_terminal=True, width=120))
    assert "chair1" in text.getvalue()
    assert "\x1b[" in text.getvalue()


def test_versions_name_python_and_this_distribution() -> None:
    assert {"python", "intellwheels", "eclipse-zenoh"} <= versions().keys()


def test_command_line_of_a_program_is_one_value() -> None:
    agent = AgentResult(name="chair1", mind="./mine {name}", robot="", command_age=0.061)
    (line, *_) = lines(msgspec.structs.replace(RESULT, agents=(agent,)))
    assert shlex.split(line)[1:4] == ["name=chair1", "mind=./mine {name}", "robot=-"]
    assert " age=0.061s " in line


def test_a_result_that_further_runs_followed_says_which_run_it_is_of() -> None:
    printed = list(lines(msgspec.structs.replace(RESULT, further=2)))
    assert printed[-1] == "not-held scene=figure6 run=1 further=2 finish=ended"
    note = (
        "note this is the result of run 1; 2 further runs were started from the page, each with a line of its own above"
    )
    assert note in printed
    text = io.StringIO()
    show(msgspec.structs.replace(RESULT, further=1), Console(file=text, width=200, force_terminal=True))
    assert "the result of run 1; 1 further run was started" in text.getvalue()
