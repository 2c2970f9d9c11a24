"""Every kind of sensor keeps the form that the package asks of it."""

from __future__ import annotations

from intellwheels_schemas.messages import Robot, SensorDeclaration, Sensors
from intellwheels_schemas.rules import sensors_of
from intellwheels_schemas.vectors import EVERY_SENSOR
from intellwheels_server.world.sensors import KINDS


def test_each_kind_has_a_field_of_its_own_in_robot_and_in_sensors() -> None:
    fields = [kind.field for kind in KINDS.values()]
    assert len(set(fields)) == len(fields)
    for declaration, kind in KINDS.items():
        assert kind.field == declaration.__name__.lower()
        assert hasattr(Robot(), kind.field)
        assert hasattr(Sensors(), kind.field)


def test_each_declaration_of_the_contract_has_a_kind_which_takes_samples_of_it() -> None:
    assert set(KINDS) == set(SensorDeclaration.__args__)
    for _, _, declaration in sensors_of(EVERY_SENSOR):
        kind = KINDS[type(declaration)]
        assert kind.width(declaration) >= 1
        assert kind.memory(declaration) >= 0
