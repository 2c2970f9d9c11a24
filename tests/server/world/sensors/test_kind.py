"""Every kind of sensor keeps the form that the package asks of it."""

from __future__ import annotations

import pytest

from intellwheels_maps import floor
from intellwheels_schemas.messages import Corner
from intellwheels_server.world.sensors.catalogue import KINDS
from intellwheels_server.world.sensors.kind import Kind
from tests.every_case import every_case


@every_case("kind", KINDS.values(), ids=lambda kind: kind.field)
def test_each_kind_takes_samples_of_its_declarations(kind: Kind) -> None:
    for declaration in kind.examples(floor("room")):
        assert isinstance(declaration, kind.declaration)
        assert kind.width(declaration) >= 1
        assert kind.memory(declaration) >= 0
        assert kind.phase(declaration) >= 0


def test_kind_for_a_record_that_robots_do_not_list_is_refused() -> None:
    with pytest.raises(TypeError, match=r"Strange.declaration: expected a record that one field of Robot and Sensors"):
        type("Strange", (Kind,), {"declaration": Corner})
