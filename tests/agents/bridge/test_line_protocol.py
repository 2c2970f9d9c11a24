from __future__ import annotations

import random
import re
from pathlib import Path

import pytest

import intellwheels_agents.bridge
from intellwheels_agents.bridge.line_protocol import (
    LONGEST,
    Located,
    Message,
    PowerLine,
    Splitter,
    Telemetry,
    checksum,
    read,
    written,
)
from intellwheels_schemas.errors import WireError

MESSAGES: list[Message] = [
    Telemetry(1, 12, 240, 1200, -3, 24800, None, (1250, "n", "c", "f")),
    Telemetry(7, 0, 0, 0, 0, 0, (-1000, 1000), ()),
    Located(1, 235, 4000, -1500, 50),
    PowerLine(500, -500),
]


@pytest.mark.parametrize("message", MESSAGES)
def test_what_is_written_is_read(message: Message) -> None:
    line = written(message)
    assert line.endswith(b"\n")
    assert read(line[:-1]) == message
    assert read(line[:-1] + b"\r") == message


def test_the_sum_is_that_of_the_page() -> None:
    assert checksum(b"123456789") == 0x29B1


def test_the_page_s_lines_are_lines() -> None:
    page = (Path(intellwheels_agents.bridge.__file__).parent / "PROTOCOL.md").read_text()
    lines = re.findall(r"^([TFP] .*\*[0-9A-F]{4})$", page, re.MULTILINE)
    assert [read(line.encode()) for line in lines] == [MESSAGES[0], MESSAGES[2], MESSAGES[3]]


@pytest.mark.parametrize(
    "body", [b"P 1001 0", b"P 1 2 3", b"P 1", b"P x 0", b"P  1", b"P 1.0 0", b"Q 1", b"T 1 2 3", b"", b"P \xb2 0",
             b"T 1 1 1 1 1 1 - 5", b"T 1 1 1 1 1 1 - - q", b"F 1 1 99999999 0 0", b"T -1 1 1 1 1 1 - -"],
)  # fmt: skip
def test_a_line_with_a_right_sum_and_wrong_words_is_refused(body: bytes) -> None:
    with pytest.raises(WireError):
        read(b"%s*%04X" % (body, checksum(body)))


def test_a_changed_byte_is_noticed() -> None:
    line = written(PowerLine(500, -500))[:-1]
    for place in range(len(line)):
        for other in (line[place] ^ 1, line[place] ^ 0x80, 0):
            with pytest.raises(WireError):
                read(line[:place] + bytes([other]) + line[place + 1 :])


def test_garbage_is_no_line_and_moves_nothing() -> None:
    rng, splitter, taken = random.Random(5), Splitter(), []
    for _ in range(2000):
        for line in splitter.feed(rng.randbytes(50)):
            try:
                taken.append(read(line))
            except WireError:
                continue
    assert taken == []


def test_lines_come_whole_however_they_are_cut() -> None:
    stream = b"".join(written(message) for message in MESSAGES)
    for size in (1, 3, 1000):
        splitter = Splitter()
        lines = [line for i in range(0, len(stream), size) for line in splitter.feed(stream[i : i + size])]
        assert [read(line) for line in lines] == MESSAGES


def test_what_never_ends_is_dropped() -> None:
    splitter = Splitter()
    assert splitter.feed(b"x" * (LONGEST + 1)) == []
    assert splitter.overlong == 1
    assert splitter.feed(written(PowerLine(0, 0))) == [written(PowerLine(0, 0))[:-1]]
