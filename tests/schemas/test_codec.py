from __future__ import annotations

import math
from typing import Any
from unittest import mock

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from intellwheels_schemas import rules
from intellwheels_schemas.codec import LIMITS, MAX_BYTES, Encoding, decode, encode, encoding_of, from_plain, is_known
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import (
    ERROR_CODES,
    TEXT_PATTERN,
    Actions,
    Clock,
    Entity,
    Leave,
    LidarReading,
    Map,
    Measures,
    Record,
    Robot,
    Say,
    Sensors,
    UserInput,
    WorldState,
)
from intellwheels_schemas.shapes import Form, Member, Scalar, shape_of
from intellwheels_schemas.vectors import GROWN, NAMES, REFUSED, RUN, VALID, class_of, encoding_of_file
from tests.every_case import every_case

JSON, XML = Encoding.JSON, Encoding.XML
OURS = "c0ffee0012345678"
SESSION = b'"Session":"%s"' % OURS.encode()
HASH = "0123456789abcdef"


def refusal(cls: type[Record], data: bytes, encoding: Encoding = JSON, *, strict: bool = True) -> WireError:
    with pytest.raises(WireError) as caught:
        decode(cls, data, encoding, strict=strict)
    return caught.value


# ---------------------------------------------------------------- generated messages


@st.composite
def texts(draw: st.DrawFn, scalar: Scalar) -> str:
    if scalar.pattern is not None and scalar.pattern.pattern != TEXT_PATTERN:
        return draw(st.from_regex(scalar.pattern, fullmatch=True))
    characters = st.characters(exclude_categories=["Cs"]).filter(lambda c: c in "\t\n" or (c >= " " and c < "\ufffe"))
    most = min(scalar.max_length or 20, 20)
    return draw(st.text(characters | st.sampled_from("]>&<\"'\n\t😀"), min_size=scalar.min_length, max_size=most))


def scalars(scalar: Scalar) -> st.SearchStrategy[Any]:
    if scalar.kind == "truth":
        return st.booleans()
    if scalar.kind == "word":
        return st.sampled_from(scalar.words)
    if scalar.kind == "text":
        return texts(scalar)
    if scalar.kind == "integer":
        assert scalar.low is not None
        assert scalar.high is not None
        return st.integers(int(scalar.low), int(scalar.high))
    return st.floats(
        scalar.low, scalar.high, exclude_min=scalar.low_open, exclude_max=scalar.high_open, allow_nan=False
    )


def values(member: Member) -> st.SearchStrategy[Any]:
    if member.record is not None:
        one = messages(member.record)
    else:
        assert member.scalar is not None
        one = scalars(member.scalar)
        if member.scalar.nullable:
            one = st.none() | one
    if member.form in {Form.LIST, Form.RECORDS}:
        return st.lists(one, max_size=min(2, member.max_count or 2)).map(tuple)
    return one


def messages(cls: type[Record]) -> st.SearchStrategy[Any]:
    required = {m.name: values(m) for m in shape_of(cls).members if m.required}
    optional = {m.name: st.just(m.default) | values(m) for m in shape_of(cls).members if not m.required}
    return st.fixed_dictionaries(required, optional=optional).map(lambda fields: cls(**fields))


@settings(max_examples=150, deadline=None, suppress_health_check=list(HealthCheck))
@given(st.data())
def test_every_message_is_itself_again_in_both_encodings(data: st.DataObject) -> None:
    cls = data.draw(st.sampled_from(list(NAMES.values())))
    message = data.draw(messages(cls))
    # Random fields seldom keep the rules across fields, which have tests of their own.
    with mock.patch.object(rules, "check"):
        as_json, as_xml = encode(message, JSON), encode(message, XML)
        limit = LIMITS.get(cls, MAX_BYTES)
        if len(as_xml) <= limit and len(as_json) <= limit:
            assert decode(cls, as_json, JSON) == message
            assert decode(cls, as_xml, XML) == message
            assert encode(decode(cls, as_xml, XML), JSON) == as_json
            assert encode(decode(cls, as_json, JSON), XML) == as_xml


# ---------------------------------------------------------------- fuzz


def check(error: WireError) -> None:
    assert error.text.encode()
    assert error.code in ERROR_CODES


PLAIN = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(
        ["Tick", "Say", "Goal", "X", "Y", "Sensors", "Proximity", "Lidar", "Ranges", "Id", "Robot", "Part", "?"]
    ), inner, max_size=4),
    max_leaves=12,
)  # fmt: skip


@settings(max_examples=150, deadline=None)
@given(st.sampled_from(list(NAMES.values())), st.binary(max_size=60), st.sampled_from(Encoding), st.booleans())
def test_any_bytes_end_in_a_message_or_a_wire_error(
    cls: type[Record], data: bytes, encoding: Encoding, strict: bool
) -> None:
    try:
        decode(cls, data, encoding, strict=strict)
    except WireError as error:
        check(error)


@settings(max_examples=150, deadline=None)
@given(st.sampled_from([Actions, Robot, Measures, Map, UserInput]), PLAIN, st.booleans())
def test_any_json_ends_in_a_message_or_a_wire_error(cls: type[Record], plain: object, strict: bool) -> None:
    try:
        from_plain(cls, plain, strict=strict)
    except WireError as error:
        check(error)


@settings(max_examples=300, deadline=None)
@given(st.data())
def test_spoilt_documents_end_in_a_message_or_a_wire_error(data: st.DataObject) -> None:
    name = data.draw(st.sampled_from(sorted(VALID)))
    encoding = data.draw(st.sampled_from([JSON, XML]))
    document = bytearray(encode(VALID[name], encoding))
    for _ in range(data.draw(st.integers(1, 3))):
        at = data.draw(st.integers(0, max(len(document) - 1, 0)))
        piece = data.draw(
            st.sampled_from([b"", b"<", b">", b"&", b'"', b"\\", b"\x00", b"\xff", b"null", b"]]>", b"{"])
        )
        document[at : at + data.draw(st.integers(0, 3))] = piece
    try:
        decode(class_of(name), bytes(document), encoding, strict=data.draw(st.booleans()))
    except WireError as error:
        check(error)


# ---------------------------------------------------------------- vectors


@every_case("name", VALID)
@every_case("encoding", [JSON, XML])
def test_vector_is_read_and_written_again_to_the_byte(name: str, encoding: Encoding) -> None:
    data = encode(VALID[name], encoding)
    message = decode(class_of(name), data, encoding)
    assert message == VALID[name]
    assert encode(message, encoding) == data
    assert decode(class_of(name), data, encoding, strict=False) == message


@every_case("wrong", REFUSED, ids=lambda wrong: wrong.name)
def test_wrong_document_is_refused_with_place_and_code(wrong: Any) -> None:
    error = refusal(class_of(wrong.name), wrong.data, encoding_of_file(wrong.name))
    assert (error.code, error.where) == (wrong.code, wrong.where)
    assert error.text.startswith(wrong.where)


@pytest.mark.parametrize("grown", GROWN, ids=lambda grown: grown.name)
def test_unknown_fields_are_refused_by_the_simulator_and_ignored_by_peers(grown: Any) -> None:
    cls, encoding, data = class_of(grown.name), encoding_of_file(grown.name), grown.data.encode()
    assert refusal(cls, data, encoding).code == "field"
    assert decode(cls, data, encoding, strict=False) == VALID[grown.same]


def test_there_are_at_least_fifty_wrong_documents() -> None:
    assert len({wrong.name for wrong in REFUSED}) == len(REFUSED) >= 50


# ---------------------------------------------------------------- words of errors


@every_case(
    ("cls", "data", "text"),
    [
        (Actions, b'{%s,"LeftMotor":"fast"}' % SESSION, "Actions.LeftMotor: expected a number in [-1, 1], got 'fast'"),
        (
            Actions, b'{%s,"Tick":true}' % SESSION,
            "Actions.Tick: expected a whole number in [0, 9007199254740991], got true",
        ),
        (
            Actions, b'{"LeftMoter":1}',
            "Actions.LeftMoter: expected a field of Actions, got 'LeftMoter'; did you mean LeftMotor?",
        ),
        (Actions, b'{%s,"Goal":{"X":1}}' % SESSION, "Actions.Goal.Y: expected metres in [-10000, 10000], got nothing"),
        (Actions, b'{"Tick":1,"Tick":2}', "Actions: expected each name once, got 'Tick' twice"),
        (
            Actions, b'{%s,"Say":"%s"}' % (SESSION, b"x" * 1001),
            "Actions.Say: expected at most 1000 characters, got 1001",
        ),
        (
            Robot, b'{"Height":1}',
            "Robot.Height: expected a field of Robot, got 'Height'; in the paper Height is a size on the plan: "
            "write Length and Width, and Top for the upper face",
        ),
        (Robot, b'{"Role":"king"}', "Robot.Role: expected one of both, body, mind, got 'king'"),
        (
            Robot, b'{"Name":"*"}',
            "Robot.Name: expected a name of a-z, 0-9, _ and -, a letter first, at most 32 characters, got '*'",
        ),
    ],
)  # fmt: skip
def test_error_says_where_expected_and_got(cls: type[Record], data: bytes, text: str) -> None:
    assert refusal(cls, data).text == text


def test_error_is_the_same_in_both_encodings() -> None:
    sensor = b'"Id":"a","X":0,"Y":0,"Z":0,"DirectionDeg":0,"MaxRange":4'
    as_json = b'{"Length":1,"Width":1,"Proximity":[{%s,"ConeDeg":30},{%s,"ConeDeg":0}]}' % (sensor, sensor)
    attributes = 'Id="a" X="0" Y="0" Z="0" DirectionDeg="0" MaxRange="4"'
    sonars = f'<Proximity {attributes} ConeDeg="30"/><Proximity {attributes} ConeDeg="0"/>'
    as_xml = f'<Robot Length="1" Width="1">{sonars}</Robot>'
    text = "Robot.Proximity[1].ConeDeg: expected degrees in (0, 360], got 0"
    assert refusal(Robot, as_json).text == refusal(Robot, as_xml.encode(), XML).text == text


def test_words_of_a_stranger_are_shown_short_and_printable() -> None:
    error = refusal(Actions, ('{"Run":"' + "\\u0007" * 500 + '"}').encode())
    assert len(error.text) < 300
    assert error.text.isprintable()


# ---------------------------------------------------------------- encodings


@pytest.mark.parametrize(
    ("encoding", "data", "found"),
    [
        ("application/json", b"", JSON),
        ("application/json;iw.v1", b"<", JSON),
        ("application/xml;iw.v1", b"", XML),
        ("application/xml", b"", XML),
        ("zenoh/bytes", b"<Actions/>", XML),
        ("zenoh/string", b"{}", JSON),
        ("", b"{}", JSON),
    ],
)
def test_encoding_is_obeyed_and_the_first_byte_decides_where_none_is_said(
    encoding: str, data: bytes, found: Encoding
) -> None:
    assert encoding_of(encoding, data) is found


@every_case(
    ("encoding", "data", "code"),
    [
        ("application/json;iw.v2", b"{}", "version"),
        ("application/xml;iw.v10", b"{}", "version"),
        ("application/json;charset=latin-1", b"{}", "encoding"),
        ("image/png", b"{}", "encoding"),
        ("text/plain", b"hello", "encoding"),
        ("zenoh/bytes", b"hello", "encoding"),
        ("zenoh/bytes", b"", "encoding"),
        ("", b"\xef\xbb\xbf{}", "encoding"),
    ],
)
def test_other_encodings_are_refused_in_words(encoding: str, data: bytes, code: str) -> None:
    with pytest.raises(WireError) as caught:
        encoding_of(encoding, data)
    assert caught.value.code == code
    assert caught.value.text.startswith("encoding: expected ")


def test_encodings_are_written_without_a_suffix_and_known_with_the_version() -> None:
    assert [one.value for one in Encoding] == ["application/json", "application/xml"]
    assert all(is_known(f"{one.value}{suffix}") for one in Encoding for suffix in ("", ";iw.v1"))
    assert not any(is_known(text) for text in ("application/json;iw.v2", "zenoh/string", "", "image/png"))


@pytest.mark.parametrize(
    ("cls", "data"),
    [(Actions, b'{"Tick":1}'), (Say, b'{"Text":"a"}'), (Leave, b"{}"), (Leave, b'{"Run":"9f3c21d4a0b1c2d3"}')],
)
def test_message_of_an_agent_without_its_session_is_refused(cls: type[Record], data: bytes) -> None:
    error = refusal(cls, data)
    assert (error.code, error.where) == ("field", f"{cls.__name__}.Session")
    assert error.text == f"{cls.__name__}.Session: expected 16 lower-case hex digits, got nothing"


# ---------------------------------------------------------------- writing


def test_computed_defaults_are_not_written() -> None:
    zero = float("0")
    stick = UserInput(forward=zero, turn=0.5)
    assert encode(stick) == b'{"Turn":0.5}'
    assert encode(stick, XML) == b'<UserInput Turn="0.5"/>'
    state = WorldState(
        run=HASH, tick=0, time=0.0, entity=(Entity(name="a", x=0.0, y=0.0, heading=0.0, speed=zero, turn_rate=zero),)
    )
    assert b"Speed" not in encode(state)
    assert b"Speed" not in encode(state, XML)
    said = decode(Robot, b'{"Kind":"robot","EncoderTicks":2000,"Track":0.6,"Length":1.0,"Width":1.0}')
    assert encode(said) == b'{"Length":1.0,"Width":1.0}'


def test_lidar_keeps_its_nulls_and_text_may_say_null() -> None:
    scan = LidarReading(id="l", start_deg=0.0, step_deg=1.0, ranges=(None, 1.0), statuses=("none", "ok"))
    message = Measures(run=RUN, tick=0, time=0.0, sensors=Sensors(lidar=(scan,)))
    assert decode(Measures, encode(message)) == message
    assert b'Ranges="- 1.0"' in encode(message, XML)
    assert decode(Actions, encode(Actions(session=OURS, say="null"))) == Actions(session=OURS, say="null")


@pytest.mark.parametrize("number", [math.nan, math.inf])
@pytest.mark.parametrize("encoding", [JSON, XML])
def test_number_that_is_not_finite_is_our_bug(number: float, encoding: Encoding) -> None:
    with pytest.raises(ValueError, match="expected"):
        encode(Measures(run=RUN, tick=0, time=number), encoding)
    clock = Clock(
        run=RUN, tick=0, time=0.0, state="running", pace="free", hash=HASH, stamp=0.0, speed=number
    )  # fmt: skip
    with pytest.raises(ValueError, match="expected"):
        encode(clock, encoding)


def test_explicit_defaults_other_orders_and_spaces_are_taken() -> None:
    data = b' {"Session":"c0ffee0012345678" ,"Seq" : 1 ,"Leave":false,"Tick":7, "Say":"a\\u003ab" } '
    assert decode(Actions, data) == Actions(session=OURS, tick=7, seq=1, say="a:b")
    xml = b"<?xml version='1.0'?>\n<!-- c --><Actions  Session='c0ffee0012345678' Seq='1'\n Leave='false' Tick='7'>"
    xml += b"<Say>a<!-- c -->:b</Say>\n</Actions>\n"
    assert decode(Actions, xml, XML) == Actions(session=OURS, tick=7, seq=1, say="a:b")


def test_integer_stands_for_a_float() -> None:
    assert decode(Actions, b'{%s,"LeftMotor":1}' % SESSION) == decode(
        Actions, b'<Actions Session="%s" LeftMotor="1"/>' % OURS.encode(), XML
    )


def test_deep_and_long_strangers_are_refused() -> None:
    assert refusal(Robot, b'{"X":' + b"[" * 60_000).code == "malformed"
    assert refusal(Robot, b'{"X":' + b'{"a":' * 12_000, strict=False).code == "malformed"
    assert refusal(Robot, b"<Robot>" + b"<a>" * 9_000, XML, strict=False).code == "malformed"
    assert refusal(Actions, b'{%s,"Tick":%s}' % (SESSION, b"9" * 4_000)).code == "value"
    assert refusal(Actions, b" " * 4097).text == "Actions: expected at most 4096 bytes, got 4097"
    assert refusal(Measures, b" " * (MAX_BYTES + 1)).code == "too-long"


def test_openings_of_comments_do_not_take_long() -> None:
    # Would take minutes if the search for a document type tried anything twice.
    assert refusal(Map, b"<!--" * 200_000 + b"<!DOCTYPE", XML).code == "malformed"
