from __future__ import annotations

import json
from pathlib import Path

import jsonschema
import msgspec
import pytest

from intellwheels_schemas.errors import WireError
from intellwheels_schemas.file_records import (
    CHAINED,
    LINES,
    VERSION,
    FileRecord,
    GoOn,
    InputEnd,
    InputHeader,
    Inputs,
    InputTick,
    Join,
    Restart,
    Said,
    TakeBody,
    TraceBody,
    TraceHeader,
    TraceTick,
    Verdict,
    WorldRules,
    read_header,
)
from intellwheels_schemas.messages import Actions, End, Event, Timeout, UserInput
from intellwheels_schemas.vectors import CHAIR, HASH, ROOM, RUN

SCHEMAS = Path(__file__).parents[2] / "schemas"
RULES = WorldRules(say_limit=100, say_range=8.0, command_timeout=0.5, truth=False, strict=True)
INPUT = InputHeader(log="iw.v1", run=RUN, map=ROOM, seed="7", period=0.05, setup=RULES)
TRACE = TraceHeader(run=RUN, seed="7", period=0.05, floor="room")
EXAMPLES: list[FileRecord] = [
    INPUT,
    msgspec.structs.replace(INPUT, setup=msgspec.structs.replace(RULES, end=End(timeout=Timeout(seconds=9.0)))),
    InputTick(
        tick=3,
        inputs=Inputs(
            changes=(Join(agent="chair1", robot=CHAIR), TakeBody(agent="chair1"), Restart(run=RUN, seed="8"), GoOn()),
            actions={"chair1": Actions(left_motor=0.5, say="open")},
            says=(Said(agent="door", text="it is", seq=4),),
            user_input={"chair1": UserInput(forward=1.0)},
            verdicts=(Verdict(agent="chair1", code="late"),),
        ),
        hash=HASH,
        stepped=False,
    ),
    InputEnd(end="closed", lines=2, chain=HASH),
    TRACE,
    TraceTick(
        tick=3,
        body={
            "chair1": TraceBody(
                pose=(1.0, 2.0, 0.5), speed=0.25, power=(0.5, 0.5), wheels=(3, -4), odometry=(0.0, 0.1, 0.2),
                user=(1.0, 0.0), mode="manual", contacts=1,
            ),
            "table": TraceBody(pose=(4.0, 4.0, 0.0)),
        },
        event=(Event(run=RUN, tick=3, number=0, code="contact", agent="chair1", other="wall"),),
        hash=HASH,
    ),
]  # fmt: skip


@pytest.mark.parametrize("line", EXAMPLES, ids=lambda line: type(line).__name__)
def test_line_is_valid_and_read_as_it_was_written(line: FileRecord) -> None:
    data = msgspec.json.encode(line)
    assert msgspec.json.decode(data, type=type(line)) == line
    schema = json.loads((SCHEMAS / "json" / "reader" / f"{type(line).__name__}.json").read_bytes())
    jsonschema.Draft202012Validator.check_schema(schema)
    assert [error.message for error in jsonschema.Draft202012Validator(schema).iter_errors(json.loads(data))] == []


def test_every_kind_of_line_has_an_example() -> None:
    assert {type(line) for line in EXAMPLES} == set(LINES)


def test_line_with_a_wrong_command_is_not_valid() -> None:
    schema = json.loads((SCHEMAS / "json" / "reader" / "InputTick.json").read_bytes())
    validator = jsonschema.Draft202012Validator(schema)
    wrong = {"Tick": 3, "Inputs": {"Actions": {"chair1": {"LeftMotor": 2.0}}}, "Hash": HASH}
    assert not validator.is_valid(wrong)
    assert not validator.is_valid({"Tick": 3, "Inputs": {"Changes": [{"Do": "Join", "Agent": "a"}]}, "Hash": HASH})


@pytest.mark.parametrize(("cls", "header"), [(InputHeader, INPUT), (TraceHeader, TRACE)])
def test_header_carries_its_version_and_one_without_is_version_1(
    cls: type[InputHeader] | type[TraceHeader], header: FileRecord
) -> None:
    data = msgspec.json.encode(header)
    assert b'"Version":1,' in data
    assert read_header(cls, data, "f:1") == header
    assert read_header(cls, data.replace(b'"Version":1,', b""), "f:1") == header


def test_header_of_a_log_with_checksums_is_read() -> None:
    header = msgspec.structs.replace(INPUT, version=CHAINED)
    assert read_header(InputHeader, msgspec.json.encode(header), "f:1") == header


@pytest.mark.parametrize(
    ("cls", "header", "words"),
    [
        (
            InputHeader,
            INPUT,
            "f:1: expected an input log of version 1 or 2, got 3",
        ),
        (TraceHeader, TRACE, "f:1: expected a trace of version 1, got 2"),
    ],
)
def test_header_of_another_version_is_refused_whatever_else_it_has(
    cls: type[InputHeader] | type[TraceHeader], header: FileRecord, words: str
) -> None:
    newest = CHAINED if cls is InputHeader else VERSION
    later = msgspec.json.encode(header).replace(b'"Version":1', f'"Version":{newest + 1}'.encode())
    with pytest.raises(WireError) as caught:
        read_header(cls, later.replace(b'"Seed"', b'"Seeds"'), "f:1")
    assert (caught.value.code, caught.value.text) == ("version", words)


def test_header_of_another_contract_is_refused() -> None:
    data = msgspec.json.encode(INPUT).replace(b'"Log":"iw.v1"', b'"Log":"iw.v2"')
    with pytest.raises(WireError, match=r"^f:1: expected an input log of format iw\.v1, got 'iw\.v2'$"):
        read_header(InputHeader, data, "f:1")


@pytest.mark.parametrize("data", [b"", b"{}", b"\xff", b"hello", b'{"Version":"1"}', b"[1]"])
def test_what_is_no_header_is_said_so(data: bytes) -> None:
    with pytest.raises(WireError, match=r"^f:1: expected the header of a trace, got ") as caught:
        read_header(TraceHeader, data, "f:1")
    assert caught.value.code == "malformed"


def test_header_of_the_other_file_is_no_header() -> None:
    with pytest.raises(WireError, match="expected the header of an input log, got "):
        read_header(InputHeader, msgspec.json.encode(TRACE), "f:1")
