from __future__ import annotations

import msgspec
import pytest

from intellwheels_maps import floor
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Corner, Load, Wall
from intellwheels_server.service.load_floor import load_floor


def test_floor_is_found_by_name_or_taken_from_the_message() -> None:
    assert load_floor(Load(name="corner")) == floor("corner")
    carried = msgspec.structs.replace(floor("corner"), name="mine")
    assert load_floor(Load(map=carried)) is carried


def test_unknown_name_is_refused_with_the_names_there_are() -> None:
    with pytest.raises(WireError, match=r"expected one of the maps .*corner.*, got 'nowhere'"):
        load_floor(Load(name="nowhere"))


def test_faulty_map_is_refused_with_the_element_at_fault() -> None:
    room = floor("room")
    crossing = (Corner(x=0.0, y=0.0), Corner(x=1.0, y=1.0), Corner(x=1.0, y=0.0), Corner(x=0.0, y=1.0))
    faulty = msgspec.structs.replace(room, wall=(*room.wall, Wall(corner=crossing)))
    with pytest.raises(WireError, match=r"Load\.Map\.Wall"):
        load_floor(Load(map=faulty))
