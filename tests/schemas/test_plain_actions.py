"""Whatever the fast reader takes, the codec reads as the same actions; and it takes what most agents send."""

from __future__ import annotations

import pytest

from intellwheels_schemas import plain_actions
from intellwheels_schemas.codec import Encoding, decode, encode
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Actions

RUN, SESSION = "0123456789abcdef", "fedcba9876543210"
ORDINARY = [
    Actions(run=RUN, session=SESSION, tick=12, seq=3, left_motor=0.25, right_motor=-1.0),
    Actions(run=RUN, session=SESSION, tick=0, left_motor=1e-7, right_motor=0.0),
    Actions(run=RUN, session=SESSION, tick=2**53 - 1, seq=2**53 - 1),
]
HEAD = f'"Run":"{RUN}","Session":"{SESSION}"'
XML_HEAD = f'<Actions Run="{RUN}" Session="{SESSION}"'
JSON = [
    f'{{"LeftMotor": 1, {HEAD} ,"Tick":4}}',
    f'{{{HEAD},"Tick":4,"Tick":5}}',
    f'{{{HEAD},"T\\u0069ck":4,"Tick":5}}',
    f'{{{HEAD},"Tick":null}}',
    f'{{{HEAD},"Tick":null,"Seq":1}}',
    f'{{{HEAD},"LeftMotor":1.01}}',
    f'{{{HEAD},"LeftMotor":NaN}}',
    f'{{{HEAD},"LeftMotor":-0}}',
    f'{{{HEAD},"Tick":-0}}',
    f'{{{HEAD},"Tick":1.0}}',
    f'{{{HEAD},"Tick":9007199254740992}}',
    f'{{{HEAD},"Say":"a:b"}}',
    f'{{{HEAD},"Leave":true}}',
    f'{{{HEAD},"Power":1}}',
    f'{{"Run":"{RUN}"}}',
    f'{{"Run":"x","Session":"{SESSION}"}}',
    f'{{"Run":"{RUN[:-1]}:","Session":"{SESSION}"}}',
    f"{{{HEAD}}} x",
    "[" * 3000,
    "",
]
XML = [
    f'{XML_HEAD} Tick="04"/>',
    f'{XML_HEAD} Tick="9007199254740992"/>',
    f'{XML_HEAD} Tick="1" Tick="2"/>',
    f'{XML_HEAD} LeftMotor="1.01"/>',
    f'{XML_HEAD} RightMotor="-1.01"/>',
    f'{XML_HEAD} RightMotor="1e999"/>',
    f'{XML_HEAD} LeftMotor="-0" RightMotor="1E-3" />',
    f'{XML_HEAD} LeftMotor=".5"/>',
    f'{XML_HEAD} Tick="1\n"/>',
    f"{XML_HEAD}><Say>hello</Say></Actions>",
    f'<Actions Session="{SESSION}" Run="{RUN}"/>',
    f'<Actions Run="{RUN}"/>',
    f'{XML_HEAD} Mode="\u00e9"/>',
]


def read(data: bytes, encoding: Encoding) -> Actions | tuple[str, str, str]:
    try:
        return decode(Actions, data, encoding)
    except WireError as error:
        return error.code, error.text, error.where


def slowly(data: bytes, encoding: Encoding, monkeypatch: pytest.MonkeyPatch) -> Actions | tuple[str, str, str]:
    with monkeypatch.context() as patch:
        for name in ("from_json", "from_xml"):
            patch.setattr(plain_actions, name, lambda _data: None)
        return read(data, encoding)


@pytest.mark.parametrize("encoding", Encoding)
@pytest.mark.parametrize("actions", ORDINARY)
def test_ordinary_actions_are_read_fast_once_their_run_and_session_are_known(
    actions: Actions, encoding: Encoding
) -> None:
    data = encode(actions, encoding)
    plain_actions._known.clear()
    if encoding is Encoding.JSON:
        assert plain_actions.from_json(data) is None
    assert decode(Actions, data, encoding) == actions
    reader = plain_actions.from_json if encoding is Encoding.JSON else plain_actions.from_xml
    assert reader(data) == actions


@pytest.mark.parametrize(
    ("text", "encoding"), [(text, Encoding.JSON) for text in JSON] + [(text, Encoding.XML) for text in XML]
)
def test_result_and_error_are_those_of_the_codec(
    text: str, encoding: Encoding, monkeypatch: pytest.MonkeyPatch
) -> None:
    decode(Actions, encode(ORDINARY[0]))
    data = text.encode()
    expected = slowly(data, encoding, monkeypatch)
    found = read(data, encoding)
    assert repr(found) == repr(expected)


def test_what_is_remembered_is_bounded() -> None:
    for number in range(plain_actions.REMEMBERED):
        plain_actions.remember(Actions(run=f"{number:016x}", session=f"{number:015x}a"))
    assert len(plain_actions._known) <= plain_actions.REMEMBERED + 1
