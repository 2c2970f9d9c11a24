from __future__ import annotations

import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from intellwheels_agents.bridge.rnet_frames import (
    FILTERS,
    Battery,
    Frame,
    Heartbeat,
    MotorCurrent,
    SpeedLimit,
    Stick,
    decode_frame,
    joystick_frame,
)
from intellwheels_schemas.errors import WireError
from tests.every_case import every_case


@every_case(
    ("identifier", "data", "content"),
    [
        # The first byte is to the right, the second forward: here 25 % to the left and full backward.
        (0x02000100, "e79c", Stick(1, -1.0, 0.25)),
        (0x02000300, "0000", Stick(3, 0.0, 0.0)),
        (0x0A040100, "19", SpeedLimit(0.25)),
        (0x03C30F0F, "8787878787878787", Heartbeat()),
        (0x1C0C0100, "57", Battery(87)),
        (0x14300100, "e802", MotorCurrent(744)),
        (0x00000123, "00", None),
        (0x0C000005, "", None),
    ],
)
def test_frames_are_read(identifier: int, data: str, content: object) -> None:
    assert decode_frame(Frame(identifier, bytes.fromhex(data))) == content


@pytest.mark.parametrize(
    ("identifier", "data", "expected"),
    [
        (0x02000100, "00", r"R-Net joystick: expected 2 bytes, got 1"),
        (0x02000100, "0080", r"R-Net joystick: expected deflections in \[-100, 100\], got 0 and -128"),
        (0x0A040100, "65", r"R-Net speed: expected a percentage in \[0, 100\], got 101"),
        (0x1C0C0100, "ff", r"R-Net battery: expected a percentage in \[0, 100\], got 255"),
        (0x14300100, "", r"R-Net motor current: expected 2 bytes, got 0"),
        (0x03C30F0F, "87", r"R-Net heartbeat: expected 8 bytes, got 1"),
    ],
)
def test_wrong_frames_are_named(identifier: int, data: str, expected: str) -> None:
    with pytest.raises(WireError, match=expected):
        decode_frame(Frame(identifier, bytes.fromhex(data)))


def test_a_remote_or_standard_frame_with_a_known_identifier_is_named() -> None:
    with pytest.raises(WireError, match="R-Net joystick: expected a data frame of classic CAN"):
        decode_frame(Frame(0x02000100, b"\0\0", is_plain=False))


@given(identifier=st.integers(0, 0x1FFFFFFF), data=st.binary(max_size=64))
def test_no_bytes_raise_anything_else(identifier: int, data: bytes) -> None:
    for candidate in (identifier, 0x02000000 | (identifier & 0xF00), 0x0A040100, 0x14300100, 0x1C0C0100, 0x03C30F0F):
        with contextlib.suppress(WireError):
            decode_frame(Frame(candidate, data))


@given(forward=st.floats(-1.5, 1.5), turn=st.floats(-1.5, 1.5))
def test_a_joystick_frame_is_read_as_it_was_written(forward: float, turn: float) -> None:
    read = decode_frame(joystick_frame(2, forward, turn))
    assert isinstance(read, Stick)
    assert read.device == 2
    assert read.forward == pytest.approx(max(-1.0, min(1.0, forward)), abs=0.0051)
    assert read.turn == pytest.approx(max(-1.0, min(1.0, turn)), abs=0.0051)


def test_the_filters_pass_what_is_read() -> None:
    for identifier in (0x02000F00, 0x0A040100, 0x03C30F0F, 0x1C0C0100, 0x14300200):
        assert any(identifier & one["can_mask"] == one["can_id"] & one["can_mask"] for one in FILTERS)
    assert not any(0x0C000005 & one["can_mask"] == one["can_id"] & one["can_mask"] for one in FILTERS)
