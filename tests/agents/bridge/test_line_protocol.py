from __future__ import annotations

import random
import re
from pathlib import Path

import pytest

import intellwheels_agents.bridge
from intellwheels_agents.bridge.line_protocol import (
    MAX_LINE,
    LineSplitter,
    Message,
    PositionFix,
    PowerLine,
    Telemetry,
    checksum,
    decode_line,
    encode_line,
)
from intellwheels_schemas.errors import WireError
from tests.every_case import every_case

MESSAGES: list[Message] = [
    Telemetry(1, 12, 240, 1200, -3, 24800, None, (1250, "n", "c", "f")),
    Telemetry(7, 0, 0, 0, 0, 0, (-1000, 1000), ()),
    PositionFix(1, 235, 4000, -1500, 50),
    PowerLine(500, -500),
    Telemetry(2**32 - 1, 2**32 - 1, 2**32 - 1, 2**31 - 1, -(2**31), 24800, None, ()),
]


@pytest.mark.parametrize("message", MESSAGES)
def test_an_encoded_line_decodes_to_the_same_message(message: Message) -> None:
    line = encode_line(message)
    assert line.endswith(b"\n")
    assert decode_line(line[:-1]) == message
    assert decode_line(line[:-1] + b"\r") == message


def test_the_checksum_is_the_one_in_the_protocol() -> None:
    assert checksum(b"123456789") == 0x29B1


def test_the_example_lines_of_the_protocol_are_valid() -> None:
    page = (Path(intellwheels_agents.bridge.__file__).parent / "PROTOCOL.md").read_text()
    lines = re.findall(r"^([TFP] .*\*[0-9A-F]{4})$", page, re.MULTILINE)
    assert [decode_line(line.encode()) for line in lines] == [MESSAGES[0], MESSAGES[2], MESSAGES[3]]


@every_case(
    "body", [b"P 1001 0", b"P 1 2 3", b"P 1", b"P x 0", b"P  1", b"P 1.0 0", b"Q 1", b"T 1 2 3", b"", b"P \xb2 0",
             b"T 1 1 1 1 1 1 - 5", b"T 1 1 1 1 1 1 - - q", b"F 1 1 99999999 0 0", b"T -1 1 1 1 1 1 - -",
             b"T 1 4294967296 1 1 1 1 - -", b"T 1 1 4294967296 1 1 1 - -", b"T 4294967296 1 1 1 1 1 - -",
             b"T 1 1 1 2147483648 1 1 - -", b"T 1 1 1 1 -2147483649 1 - -", b"F 1 4294967296 0 0 0"],
)  # fmt: skip
def test_a_line_with_a_right_checksum_and_wrong_fields_is_refused(body: bytes) -> None:
    with pytest.raises(WireError):
        decode_line(b"%s*%04X" % (body, checksum(body)))


def test_a_changed_byte_is_detected() -> None:
    line = encode_line(PowerLine(500, -500))[:-1]
    for place in range(len(line)):
        for other in (line[place] ^ 1, line[place] ^ 0x80, 0):
            with pytest.raises(WireError):
                decode_line(line[:place] + bytes([other]) + line[place + 1 :])


def test_garbage_never_decodes_to_a_message() -> None:
    rng, splitter, taken = random.Random(5), LineSplitter(), []
    for _ in range(2000):
        for line in splitter.feed(rng.randbytes(50)):
            try:
                taken.append(decode_line(line))
            except WireError:
                continue
    assert taken == []


def test_lines_are_complete_however_the_bytes_are_cut() -> None:
    stream = b"".join(encode_line(message) for message in MESSAGES)
    for size in (1, 3, 1000):
        splitter = LineSplitter()
        lines = [line for i in range(0, len(stream), size) for line in splitter.feed(stream[i : i + size])]
        assert [decode_line(line) for line in lines] == MESSAGES


def test_a_line_that_never_ends_is_dropped() -> None:
    splitter = LineSplitter()
    assert splitter.feed(b"x" * (MAX_LINE + 1)) == []
    assert splitter.too_long == 1
    assert splitter.feed(encode_line(PowerLine(0, 0))) == [encode_line(PowerLine(0, 0))[:-1]]
