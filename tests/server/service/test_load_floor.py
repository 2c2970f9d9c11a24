from __future__ import annotations

import msgspec
import numpy as np
import pytest

from intellwheels_maps import floor
from intellwheels_schemas.codec import Encoding, encode
from intellwheels_schemas.messages import Corner, End, Load, Timeout, Wall
from intellwheels_server.service.load_floor import LoadFault, LoadRequest, PackedFloor, load_floor, unpack
from intellwheels_server.world.map_geometry import walls_of


def request(load: Load, encoding: Encoding = Encoding.JSON) -> LoadRequest:
    return LoadRequest(encode(load, encoding), encoding.value)


def fault(found: PackedFloor | LoadFault) -> LoadFault:
    assert isinstance(found, LoadFault)
    return found


@pytest.mark.parametrize("encoding", [Encoding.JSON, Encoding.XML])
def test_floor_is_found_by_name_or_taken_from_the_message(encoding: Encoding) -> None:
    carried = msgspec.structs.replace(floor("corner"), name="mine")
    for load, expected in ((Load(name="corner"), floor("corner")), (Load(map=carried), carried)):
        found = load_floor(request(load, encoding))
        assert isinstance(found, PackedFloor)
        loaded = unpack(found)
        assert loaded.floor == expected
        for one, other in zip(loaded.walls, walls_of(expected), strict=True):
            assert np.array_equal(one, other)
        assert (loaded.seed, loaded.end) == (None, None)


def test_seed_and_end_condition_come_along() -> None:
    end = End(timeout=Timeout(seconds=3.0))
    found = load_floor(request(Load(name="corner", seed="7", end=end)))
    assert isinstance(found, PackedFloor)
    assert unpack(found)[2:] == ("7", end)


def test_unknown_name_is_refused_with_the_names_there_are() -> None:
    found = fault(load_floor(request(Load(name="nowhere"))))
    assert found.code == "not-found"
    assert "expected one of the maps" in found.text
    assert found.text.endswith("got 'nowhere'")


def test_faulty_map_is_refused_with_the_element_at_fault() -> None:
    room = floor("room")
    crossing = (Corner(x=0.0, y=0.0), Corner(x=1.0, y=1.0), Corner(x=1.0, y=0.0), Corner(x=0.0, y=1.0))
    faulty = msgspec.structs.replace(room, wall=(*room.wall, Wall(corner=crossing)))
    found = fault(load_floor(request(Load(map=faulty))))
    assert (found.code, found.malformed) == ("failed", False)
    assert found.text.startswith("Load.Map.Wall")


@pytest.mark.parametrize("data", [b"", b"{}", b'{"Name":5}', b"<Load"])
def test_bytes_that_are_no_load_are_malformed(data: bytes) -> None:
    found = fault(load_floor(LoadRequest(data, "")))
    assert (found.code, found.malformed) == ("failed", True)
