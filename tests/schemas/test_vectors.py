from __future__ import annotations

from pathlib import Path

import pytest

from intellwheels_schemas.codec import Encoding, decode
from intellwheels_schemas.messages import Actions, OperatorSay, PowerInForce, Say
from intellwheels_schemas.vectors import NAMES, VALID, class_of, encoding_of_file
from tests.every_case import every_case

FILES = sorted(
    path for path in (Path(__file__).parents[2] / "schemas" / "vectors").iterdir() if path.suffix in {".json", ".xml"}
)


def test_every_document_has_a_vector() -> None:
    assert {type(message) for message in VALID.values()} == set(NAMES.values())


def test_class_is_said_by_the_name_up_to_the_first_dash_or_point() -> None:
    assert class_of("Actions-say.json") is Actions
    assert class_of("Say.xml") is Say
    assert class_of("OperatorSay-all.xml") is OperatorSay
    assert class_of("Power-paused.xml") is PowerInForce
    with pytest.raises(ValueError, match="expected a name that begins with a class"):
        class_of("Aktion.json")


@every_case("path", FILES, ids=lambda path: path.name)
def test_committed_vector_is_the_message(path: Path) -> None:
    assert decode(class_of(path.name), path.read_bytes(), encoding_of_file(path.name)) == VALID[path.stem]
    assert encoding_of_file(path.name) is (Encoding.XML if path.suffix == ".xml" else Encoding.JSON)


# Byte for byte from the page that decided them, where nothing is left out there.
BYTES = {
    "Robot-chair.xml": (
        '<Robot Name="chair1" Kind="wheelchair" Instance="5f0c2a9be1d84377" Place="bed1" TopSpeed="1.0" '
        'AccelerationCurve="0.5" Track="0.572" WheelDiameter="0.368"><Part X="0.25" Y="0.0" Length="1.2" Width="0.66" '
        'Bottom="0.0" Top="0.5"/><Part X="0.0" Y="0.0" Length="0.7" Width="0.6" Bottom="0.5" Top="1.3"/>'
        '<Proximity Id="front" X="0.8" Y="0.0" Z="0.4" DirectionDeg="0.0" ConeDeg="30.0" MinRange="0.05" '
        'MaxRange="4.0"/><Encoders Id="wheels"/></Robot>'
    ),
    "Refused.xml": '<Refused Code="already-here"><![CDATA[agent \'chair1\' is already here]]></Refused>',
    "Refused.json": '{"Code":"already-here","Text":"agent \'chair1\' is already here"}',
    "Actions-say.xml": (
        '<Actions Run="9f3c21d4a0b1c2d3" Session="c0ffee0012345678" Tick="41" Seq="41" LeftMotor="0.5" '
        'RightMotor="0.4" Mode="autonomous"><Goal X="5.0" Y="1.0"/><Say><![CDATA[follow me]]></Say></Actions>'
    ),
    "Actions-say.json": (
        '{"Run":"9f3c21d4a0b1c2d3","Session":"c0ffee0012345678","Tick":41,"Seq":41,"LeftMotor":0.5,"RightMotor":0.4,'
        '"Mode":"autonomous","Goal":{"X":5.0,"Y":1.0},"Say":"follow me"}'
    ),
    "Actions-paper.xml": (
        '<Actions Session="c0ffee0012345678" LeftMotor="0.5" RightMotor="0.4">'
        "<Say><![CDATA[follow me]]></Say></Actions>"
    ),
    "Actions-answer.xml": '<Actions Session="c0ffee0012345678" Tick="5"/>',
    "Measures.xml": (
        '<Measures Run="9f3c21d4a0b1c2d3" Tick="42" Time="2.1" Collision="true"><Sensors><Proximity Id="a" '
        'Value="1.25"/><Proximity Id="b" Status="none"/><Proximity Id="c" Status="near"/><Proximity Id="d" '
        'Status="fault"/><Lidar Id="l" Tick="40" Stamp="2.0" StartDeg="-90.0" StepDeg="90.0" Ranges="1.0 - 2.5" '
        'Statuses="ok none ok"/><Encoders Id="wheels" Left="1200" Right="-3"/></Sensors><Message From="chair2" '
        'Tick="41" Seq="7" Distance="3.2"><![CDATA[here]]></Message></Measures>'
    ),
    "Measures.json": (
        '{"Run":"9f3c21d4a0b1c2d3","Tick":42,"Time":2.1,"Collision":true,"Sensors":{"Proximity":[{"Id":"a",'
        '"Value":1.25},{"Id":"b","Status":"none"},{"Id":"c","Status":"near"},{"Id":"d","Status":"fault"}],"Lidar":'
        '[{"Id":"l","Tick":40,"Stamp":2.0,"StartDeg":-90.0,"StepDeg":90.0,"Ranges":[1.0,null,2.5],"Statuses":'
        '["ok","none","ok"]}],"Encoders":[{"Id":"wheels","Left":1200,"Right":-3}]},"Message":[{"From":"chair2",'
        '"Tick":41,"Seq":7,"Distance":3.2,"Text":"here"}]}'
    ),
}  # fmt: skip


@every_case("name", BYTES)
def test_vector_is_as_it_was_decided(name: str) -> None:
    path = next(path for path in FILES if path.name == name)
    assert path.read_text(encoding="utf-8") == BYTES[name]


def test_parameters_of_a_join_are_as_they_were_decided() -> None:
    text = next(path for path in FILES if path.name == "Joined.xml").read_text(encoding="utf-8")
    assert text.startswith(
        '<Joined Run="9f3c21d4a0b1c2d3" Tick="12" Session="c0ffee0012345678"><Parameters World="main" Period="0.05" '
        'Pace="lockstep" SayLimit="100" SayRange="8.0" CommandTimeout="0.5" Grace="3.0"/>'
        '<Position X="1.0" Y="2.0" Heading="0.0"/><Robot '
    )
