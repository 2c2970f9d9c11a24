from __future__ import annotations

import msgspec
import pytest

from intellwheels_schemas.codec import LIMITS, Encoding, decode, encode
from intellwheels_schemas.crew_messages import (
    JOIN_BYTES,
    PART_BYTES,
    WrongItem,
    alone,
    crew_join,
    crew_messages,
    for_crew,
    join_parts,
    read_actions,
    read_known_actions,
    split_measures,
)
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import (
    Actions,
    AgentActions,
    AgentLeave,
    AgentMeasures,
    CrewActions,
    CrewJoin,
    CrewLeave,
    CrewMeasures,
    Leave,
    Measures,
    Robot,
)
from intellwheels_schemas.vectors import VALID

SESSION = "c0ffee0012345678"
BOTH = pytest.mark.parametrize("encoding", list(Encoding))


@BOTH
@pytest.mark.parametrize("name", [name for name in VALID if name.partition("-")[0] in ("Measures", "Actions")])
def test_message_of_an_agent_becomes_an_element_of_that_of_its_crew(name: str, encoding: Encoding) -> None:
    message = VALID[name]
    item = for_crew(encode(message, encoding), "a1", encoding)
    (data,) = crew_messages("Measures" if isinstance(message, Measures) else "Actions", "c", [item], encoding)
    found: CrewMeasures | CrewActions = (
        decode(CrewMeasures, data, encoding) if isinstance(message, Measures) else decode(CrewActions, data, encoding)
    )
    assert encode(found, encoding) == data
    (one,) = found.measures if isinstance(found, CrewMeasures) else found.actions
    assert one.agent == "a1"
    assert all(getattr(one, field) == getattr(message, field) for field in type(message).__struct_fields__)


@BOTH
def test_many_measures_are_in_parts_that_can_be_taken_apart(encoding: Encoding) -> None:
    measures = VALID["Measures"]
    items = [for_crew(encode(measures, encoding), f"a{k}", encoding) for k in range(250)]
    parts = crew_messages("Measures", "c", items, encoding)
    assert len(parts) > 1
    assert all(len(data) <= PART_BYTES + 200 for data in parts)
    taken = [split_measures(data, encoding) for data in parts]
    assert [(one.part, one.parts) for one in taken] == [(number, len(parts)) for number in range(len(parts))]
    agents = [agent for one in taken for agent in one.measures]
    assert agents == [f"a{k}" for k in range(250)]
    assert decode(AgentMeasures, taken[0].measures["a3"], encoding, strict=False).agent == "a3"
    assert crew_messages("Measures", "c", [], encoding) == []


@BOTH
def test_all_agents_of_a_crew_leave_with_one_message(encoding: Encoding) -> None:
    leave = encode(Leave(run="9f3c21d4a0b1c2d3", session=SESSION), encoding)
    names = [f"{'x' * 28}{k:03d}" for k in range(250)]
    (data,) = crew_messages("Leave", "c", [for_crew(leave, name, encoding) for name in names], encoding)
    found = decode(CrewLeave, data, encoding)
    assert found.leave[7] == AgentLeave(run="9f3c21d4a0b1c2d3", session=SESSION, agent=names[7])


@BOTH
def test_robots_are_in_as_few_requests_as_the_limit_allows(encoding: Encoding) -> None:
    robot = Robot(name="a", length=1.0, width=1.0)
    data = crew_join("c", "0" * 16, [encode(robot, encoding)], encoding)
    assert decode(CrewJoin, data, encoding) == CrewJoin(crew="c", instance="0" * 16, robot=(robot,))
    assert [len(part) for part in join_parts([b"x" * 1000] * 900)] == [392, 392, 116]
    assert LIMITS[CrewJoin] > JOIN_BYTES


@BOTH
@pytest.mark.parametrize("data", [b"", b"?", b"[]", b"3", b'{"Measures":3}', b"<x/>", b"<CrewMeasures", b"\xff"])
def test_what_is_no_message_of_a_crew_is_refused(data: bytes, encoding: Encoding) -> None:
    with pytest.raises(WireError):
        split_measures(data, encoding)
    with pytest.raises(WireError):
        list(read_actions("c", data.replace(b"Measures", b"Actions"), encoding))


def items(encoding: Encoding, *actions: bytes) -> bytes:
    if encoding is Encoding.JSON:
        return b'{"Crew":"c","Actions":[%s]}' % b",".join(actions)
    return b'<CrewActions Crew="c">%s</CrewActions>' % b"".join(actions)


WRONG = {
    Encoding.JSON: (
        b'{"Agent":"a","Session":"%s","LeftMotor":3}' % SESSION.encode(),
        b'{"Agent":"b","Session":"%s","Speed":1}' % SESSION.encode(),
        b'{"Agent":"d"}',
        b'{"Agent":"e","Session":"%s"}' % SESSION.encode(),
        b'{"Agent":"e","Session":"%s"}' % SESSION.encode(),
        b'{"Session":"%s"}' % SESSION.encode(),
    ),
    Encoding.XML: (
        b'<Actions Agent="a" Session="%s" LeftMotor="3"/>' % SESSION.encode(),
        b'<Actions Agent="b" Session="%s" Speed="1"/>' % SESSION.encode(),
        b'<Actions Agent="d"/>',
        b'<Actions Agent="e" Session="%s"/>' % SESSION.encode(),
        b'<Actions Agent="e" Session="%s"/>' % SESSION.encode(),
        b'<Actions Session="%s"/>' % SESSION.encode(),
    ),
}


@BOTH
def test_wrong_actions_of_one_agent_do_not_affect_the_others(encoding: Encoding) -> None:
    found = read_actions("c", items(encoding, *WRONG[encoding]), encoding)
    assert [one.agent for one in found if isinstance(one, AgentActions)] == ["e"]
    wrong = [one for one in found if isinstance(one, WrongItem)]
    assert [(one.agent, one.error.where) for one in wrong] == [
        ("a", "CrewActions.Actions[0].LeftMotor"),
        ("b", "CrewActions.Actions[1].Speed"),
        ("d", "CrewActions.Actions[2].Session"),
        ("e", "CrewActions.Actions[4].Agent"),
        ("", "CrewActions.Actions[5].Agent"),
    ]
    assert wrong[0].error.text == "CrewActions.Actions[0].LeftMotor: expected a number in [-1, 1], got 3"


@pytest.mark.parametrize(
    ("rest", "where"),
    [
        (b'"Crew":"d"', "CrewActions.Crew"), (b'"Crew":"c","Part":1', "CrewActions.Part"),
        (b'"Crew":"c","X":1', "CrewActions.X"), (b'"Crew":"c","Crew":"c"', "CrewActions"),
    ],
)  # fmt: skip
def test_message_that_is_wrong_as_a_whole_is_refused(rest: bytes, where: str) -> None:
    for more in (b"", b',"Actions":[3]'):
        with pytest.raises(WireError) as caught:
            list(read_actions("c", b"{%s%s}" % (rest, more), Encoding.JSON))
        assert caught.value.where == where


def test_too_many_items_are_refused() -> None:
    with pytest.raises(WireError, match="at most 250"):
        read_actions("c", items(Encoding.JSON, *[b"{}"] * 251), Encoding.JSON)


def test_actions_of_a_crew_are_those_of_the_agent_without_its_name() -> None:
    actions = Actions(session=SESSION, left_motor=0.5, say="hello", leave=True)
    fields = msgspec.structs.asdict(actions)
    assert alone(AgentActions(agent="a", **fields)) == actions
    assert alone(actions) is actions


RUN, SESSIONS = "f" * 16, {"a1": "1" * 16, "a2": "2" * 16}
ITEM = b'{"Run":"ffffffffffffffff","Session":"1111111111111111","Tick":7,"LeftMotor":0.5,"Mode":"go","Agent":"a1"}'


@pytest.mark.parametrize("item", [ITEM, ITEM.replace(b":", b" : "), ITEM.replace(b',"LeftMotor":0.5', b"")])
def test_quick_way_reads_the_same_as_the_other_one(item: bytes) -> None:
    data = b'{"Crew":"c","Part":1,"Parts":2,"Actions":[%s]}' % item
    found = read_known_actions("c", data, RUN, 7, SESSIONS)
    (expected,) = read_actions("c", data, Encoding.JSON)
    assert found is not None
    assert isinstance(expected, AgentActions)
    assert list(found) == ["a1"]
    assert msgspec.structs.asdict(found["a1"]) == msgspec.structs.asdict(expected)
    assert encode(found["a1"]) == encode(expected)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (b'"Tick":7', b'"Tick":6'),
        (b'"Run":"ffffffffffffffff",', b""),
        (b'"Session":"1111111111111111"', b'"Session":"2222222222222222"'),
        (b'"Session":"1111111111111111",', b""),
        (b'"Agent":"a1"', b'"Agent":"a9"'),
        (b'"Session":"1111111111111111","Tick":7,"LeftMotor":0.5,"Mode":"go","Agent":"a1"', b'"Tick":7,"Agent":"a9"'),
        (b'"Mode":"go"', b'"Mode":"to go"'),
        (b'"Mode":"go"', b'"Mode":null'),
        (b'"Mode":"go"', b'"Mode":"go","Mode":"go"'),
        (b'"Mode":"go"', b'"Leave":true'),
        (b'"Mode":"go"', b'"Say":"hello"'),
        (b'"LeftMotor":0.5', b'"LeftMotor":1.5'),
        (b'"LeftMotor":0.5', b'"Motor":0.5'),
        (b"]}", b",%s]}" % ITEM),
        (b'"Crew":"c"', b'"Crew":"d"'),
        (b'"Crew":"c"', b'"Crew":"c","Part":1'),
        (b"]}", b"]"),
    ],
)
def test_quick_way_leaves_to_the_other_one_what_is_wrong_or_special(old: bytes, new: bytes) -> None:
    data = b'{"Crew":"c","Actions":[%s]}' % ITEM
    assert read_known_actions("c", data, RUN, 7, SESSIONS) is not None
    assert read_known_actions("c", data.replace(old, new), RUN, 7, SESSIONS) is None


def test_parts_are_as_large_as_the_limit_allows() -> None:
    for size, parts in ((23_999, [2, 1]), (24_000, [1, 1, 1]), (50_000, [1, 1, 1]), (10, [3])):
        found = crew_messages("Leave", "c", [b"x" * size] * 3, Encoding.JSON)
        assert [data.count(b"x" * size) for data in found] == parts
    assert crew_messages("Leave", "c", [], Encoding.JSON) == []
