"""The classes against bytes put together by hand, from the protobuf encoding and the maker's field numbers."""

from __future__ import annotations

import struct

import pytest

from intellwheels_agents.bridge.luci_schema import TABLE, message, parsed
from intellwheels_schemas.errors import WireError


def test_an_encoder_message_is_read_with_fields_that_are_not_in_the_table() -> None:
    data = (
        b"\x0d" + struct.pack("<f", 90.5)  # 1: left_angle
        + b"\x15" + struct.pack("<f", 359.0)  # 2: right_angle
        + b"\x1d" + struct.pack("<f", 12.0)  # 3: fl_caster_degrees
        + b"\x38\xac\x02"  # 7: edge_timestamp = 300
        + b"\x42\x02\x08\x05"  # 8: timestamp
    )  # fmt: skip
    read = parsed("EncoderData", data)
    assert (read.left_angle, read.right_angle, read.edge_timestamp) == (90.5, 359.0, 300)


def test_radar_points_are_read() -> None:
    point = b"\x09" + struct.pack("<d", -0.5) + b"\x11" + struct.pack("<d", 2.0) + b"\x21" + struct.pack("<d", 0.1)
    read = parsed("RadarPoints", b"\x0a" + bytes([len(point)]) + point + b"\x10\x03")
    assert ([(one.x, one.y) for one in read.points], read.source) == ([(-0.5, 2.0)], 3)


def test_an_override_is_written_as_the_maker_s_client_does() -> None:
    # 1: forward_back = 150, 2: left_right = 100, 3: source = 1
    assert message("RemoteJsValues", forward_back=150, left_right=100, source=1).SerializeToString() == (
        b"\x08\x96\x01\x10\x64\x18\x01"
    )


@pytest.mark.parametrize("data", [b"\x0d\x00", b"\x0a\xff", b"\xff" * 40, b"\x0a\x05\x09"])
def test_truncated_and_foreign_bytes_are_named(data: bytes) -> None:
    with pytest.raises(WireError, match=r"RadarPoints: expected a protobuf message of this kind, got \d+ bytes"):
        parsed("RadarPoints", data)


def test_no_field_number_is_used_twice() -> None:
    for name, fields in TABLE.items():
        numbers = [number for number, _ in fields.values()]
        assert len(numbers) == len(set(numbers)), name
