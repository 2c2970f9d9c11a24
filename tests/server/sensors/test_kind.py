"""Every kind of sensor keeps the form that the package asks of it."""

from __future__ import annotations

from intellwheels_schemas.messages import Robot, Sensors
from intellwheels_server.sensors import KINDS


def test_each_kind_has_a_field_of_its_own_in_robot_and_in_sensors() -> None:
    fields = [kind.field for kind in KINDS.values()]
    assert len(set(fields)) == len(fields)
    for declaration, kind in KINDS.items():
        assert kind.field == declaration.__name__.lower()
        assert hasattr(Robot(), kind.field)
        assert hasattr(Sensors(), kind.field)
        assert kind.width >= 1
