from __future__ import annotations

import pytest

from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import (
    Bumper,
    Compass,
    Encoders,
    End,
    GPSReading,
    Part,
    Proximity,
    Reach,
    Record,
    Robot,
    Scene,
    Sensors,
)
from intellwheels_schemas.rules import (
    check,
    check_sensors,
    has_motors,
    joins_barrier,
    parts_of,
    sensors_of,
)
from intellwheels_schemas.vectors import CHAIR, DOOR, EVERY_SENSOR, VALID
from tests.every_case import every_case


@every_case("name", VALID)
def test_valid_messages_keep_the_rules(name: str) -> None:
    check(VALID[name])


def test_one_part_form_is_a_box_measured_from_the_rear_edge() -> None:
    # The paper's door: a leaf of 1 m hinged 1 cm from one end.
    assert parts_of(DOOR) == (Part(x=-0.49, y=0.0, length=1.0, width=0.1, bottom=0.0, top=2.0),)


def test_one_part_form_without_center_and_top_is_centred_and_as_high_as_a_seated_person() -> None:
    assert parts_of(Robot(length=1.0, width=0.5)) == (Part(x=0.0, y=0.0, length=1.0, width=0.5, bottom=0.0, top=1.3),)


def test_parts_are_themselves_and_a_mind_has_none() -> None:
    assert parts_of(CHAIR) == CHAIR.part
    assert parts_of(Robot(role="mind")) == ()


def test_barrier_is_what_the_robot_says_else_whether_it_has_motors() -> None:
    assert joins_barrier(Robot(top_speed=1.0))
    assert not joins_barrier(Robot())
    assert joins_barrier(Robot(barrier=True))
    assert not joins_barrier(Robot(top_speed=1.0, barrier=False))
    assert joins_barrier(Robot(role="mind"))
    assert has_motors(CHAIR)


def test_sensors_come_in_declaration_order_with_their_places() -> None:
    robot = Robot(
        length=1.0, width=1.0, bumper=(Bumper(id="b"),), encoders=(Encoders(id="e"), Encoders(id="f")),
        compass=(Compass(id="c"),),
    )  # fmt: skip
    assert [(kind, index, sensor.id) for kind, index, sensor in sensors_of(robot)] == [
        ("Encoders", 0, "e"),
        ("Encoders", 1, "f"),
        ("Compass", 0, "c"),
        ("Bumper", 0, "b"),
    ]
    assert len(list(sensors_of(EVERY_SENSOR))) == 11


def refusal(message: Record) -> str:
    with pytest.raises(WireError) as caught:
        check(message)
    return caught.value.text


def test_broken_rules_are_told_in_words() -> None:
    sonar = Proximity(id="s", x=0.0, y=0.0, z=0.4, direction_deg=0.0, cone_deg=30.0, min_range=4.0, max_range=4.0)
    body = Robot(length=1.0, width=1.0, proximity=(sonar,))
    assert refusal(body) == "Robot.Proximity[0].MaxRange: expected more than MinRange 4, got 4"
    assert refusal(Robot(length=1.0, width=1.0, encoders=(Encoders(id="e", source="real"),))) == (
        "Robot.Encoders[0].Source: expected simulated for a simulated robot, got 'real'"
    )
    assert refusal(Robot(length=1.0)) == "Robot.Width: expected Part, or Length and Width, got no Width"
    assert refusal(
        Scene(format="iw.v1", name="s", map="m", end=End(reach=(Reach(agent="a", place="p", within=1.0),)))
    ) == ("Scene.End.Reach[0].Agent: expected an agent of the cast, got 'a'")


def test_fix_without_ok_has_no_place() -> None:
    with pytest.raises(WireError, match=r"S\.GPS\[0\]\.Y: expected no value where Status is fault, got 1"):
        check_sensors(Sensors(gps=(GPSReading(id="g", y=1.0, status="fault"),)), "S")
