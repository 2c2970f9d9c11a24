"""What is played to a program is what a simulator might send."""

from __future__ import annotations

from intellwheels_experiments.conformance.plausible_readings import readings
from intellwheels_schemas.codec import Encoding, decode, encode
from intellwheels_schemas.messages import Measures, Robot
from intellwheels_schemas.names import new_hex
from intellwheels_schemas.vectors import VALID
from tests.every_case import every_case


def robots() -> list[Robot]:
    return [message for message in VALID.values() if isinstance(message, Robot)]


@every_case("tick", range(0, 30, 3))
@every_case("encoding", [Encoding.JSON, Encoding.XML])
def test_readings_of_every_robot_of_the_vectors_are_valid(tick: int, encoding: Encoding) -> None:
    assert robots()
    for robot in robots():
        measures = Measures(run=new_hex(), tick=tick, time=0.05 * tick, sensors=readings(robot, tick))
        assert decode(Measures, encode(measures, encoding), encoding) == measures


def test_robot_without_sensors_reads_nothing() -> None:
    assert readings(Robot(), 3) is None
