"""A log that was cut and one that was edited, at every kind of place."""

from __future__ import annotations

import io
import random
import re

import msgspec
import pytest

from intellwheels_schemas.errors import WireError
from intellwheels_schemas.file_records import CHAINED, InputHeader, Inputs, InputTick, WorldRules
from intellwheels_schemas.input_reader import InputReader, cut_text, unchained_text
from intellwheels_schemas.log_chain import Chain
from intellwheels_schemas.messages import Actions
from intellwheels_schemas.vectors import HASH, ROOM, RUN

RULES = WorldRules(say_limit=100, say_range=8.0, command_timeout=0.5, truth=False, strict=True)
HEADER = InputHeader(log="iw.v1", run=RUN, map=ROOM, seed="7", period=0.05, setup=RULES)
TICKS = [
    InputTick(tick=k, inputs=Inputs(actions={"chair1": Actions(left_motor=0.5, say="go")}), hash=HASH)
    for k in range(30)
]


def log(ticks: list[InputTick] = TICKS) -> bytes:
    """Return the bytes of a log of version 2."""
    chain = Chain()
    header = msgspec.json.encode(msgspec.structs.replace(HEADER, version=CHAINED))
    end = b'{"End":"closed","Lines":%d}' % (len(ticks) + 1)
    return b"".join(chain.seal(line) + b"\n" for line in [header, *map(msgspec.json.encode, ticks), end])


def old_log() -> bytes:
    """Return the bytes of a log of version 1."""
    return b"".join(msgspec.json.encode(line) + b"\n" for line in [HEADER, *TICKS])


def read(data: bytes) -> tuple[list[InputTick], InputReader]:
    file = io.BytesIO(data)
    reader = InputReader(file.readline(), "log")
    return list(reader.read_all(file)), reader


def test_whole_log_is_read_and_not_cut() -> None:
    ticks, reader = read(log())
    assert (ticks, reader.cut, reader.is_chained, reader.lines) == (TICKS, False, True, 32)
    assert log().endswith(b'"Lines":31,"Chain":"%b"}\n' % reader.chain.encode())


def test_log_of_version_1_is_read_without_checksums() -> None:
    ticks, reader = read(old_log())
    assert (ticks, reader.cut, reader.is_chained, reader.chain) == (TICKS, False, False, "")
    ticks, reader = read(old_log()[:-9])
    assert (ticks, reader.cut) == (TICKS[:-1], True)


def test_cut_anywhere_leaves_every_whole_line_and_is_told() -> None:
    data = log()
    ends = [found.start() for found in re.finditer(b"\n", data)]
    for at in random.Random(1).sample(range(ends[0], len(data) - 1), 1000):
        ticks, reader = read(data[:at])
        # A line whose newline alone is gone is whole.
        assert ticks == TICKS[: sum(end <= at for end in ends) - 1]
        assert reader.cut


@pytest.mark.parametrize("at", [0, 1, 7, 100])
def test_cut_in_the_header_leaves_nothing_and_is_told(at: int) -> None:
    with pytest.raises(
        WireError, match=r"^log:1: expected the header of an input log, got one that is truncated: no tick"
    ):
        read(log()[:at])


def test_changed_byte_anywhere_is_found_at_its_line() -> None:
    data = log()
    draw = random.Random(2)
    # Every kind of byte: the first and the last ones of some lines with their newlines, and others anywhere.
    starts = [0, *(found.end() for found in re.finditer(b"\n", data))][:-1]
    places = {place for start in starts[:3] + starts[-2:] for place in (*range(start, start + 8), start - 1)} - {-1}
    places |= {len(data) - 1, *range(len(data) - 32, len(data)), *draw.sample(range(len(data)), 1000)}
    for at in sorted(places):
        byte = draw.choice([one for one in range(256) if one != data[at]])
        changed = data[:at] + bytes([byte]) + data[at + 1 :]
        with pytest.raises(WireError) as caught:
            read(changed)
        number = data[:at].count(b"\n") + 1
        assert caught.value.text.startswith(f"log:{number}: expected "), (at, byte)


def test_removed_added_and_exchanged_lines_are_found_where_they_are() -> None:
    lines = log().splitlines(keepends=True)
    for changed, number in (
        (lines[:4] + lines[5:], 5),
        ([*lines[:4], lines[3], *lines[4:]], 5),
        ([*lines[:4], lines[5], lines[4], *lines[6:]], 5),
        ([*lines, lines[-1]], 33),
        ([*lines[:5], b"\n", *lines[5:]], 6),
    ):
        with pytest.raises(WireError, match=rf"^log:{number}: "):
            read(b"".join(changed))


@pytest.mark.parametrize(
    ("end", "words"),
    [
        (b'{"End":"closed","Lines":9}', "expected 1 lines before the end, got 9"),
        (b'{"End":3}', "expected the end of the log, got "),
    ],
)
def test_end_that_is_none_is_refused(end: bytes, words: str) -> None:
    chain, header = Chain(), msgspec.json.encode(msgspec.structs.replace(HEADER, version=CHAINED))
    with pytest.raises(WireError, match=f"^log:2: {words}"):
        read(chain.seal(header) + b"\n" + chain.seal(end) + b"\n")


def test_header_without_its_checksum_is_no_header_of_version_1() -> None:
    first, rest = log().split(b"\n", 1)
    stripped = re.sub(rb',"Chain":"[0-9a-f]{16}"', b"", first)
    with pytest.raises(WireError, match=r"^log:1: expected checksum [0-9a-f]{16} at its end, got none"):
        read(stripped + b"\n" + rest)
    with pytest.raises(WireError, match=r"^log:1: expected checksum"):
        read(first.replace(b'"Version":2', b'"Version":1') + b"\n" + rest)


def test_words_say_up_to_which_tick_a_log_can_be_used() -> None:
    assert cut_text("run.jsonl", 9).startswith("run.jsonl: the log is truncated after tick 9")
    assert unchained_text("run.jsonl").startswith("run.jsonl: a log of version 1 has no checksums")
