"""Files of recordings, read by `mcap`."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from mcap.exceptions import EndOfFile
from mcap.reader import NonSeekingReader, make_reader

from intellwheels_agents.record_gateway.message_sinks import MessageSinks, OutputFile, part_of
from intellwheels_agents.record_gateway.translator import Entry

SCHEMAS = {"Clock": {"title": "Clock", "type": "object"}}


def messages(path: Path) -> list[bytes]:
    with path.open("rb") as file:
        return [message.data for _, _, message in make_reader(file, validate_crcs=True).iter_messages()]


def entry(number: int, keep: str = "", size: int = 0) -> Entry:
    return Entry("/iw/clock", b'{"N":%d,"T":"%s"}' % (number, bytes(size).hex().encode()), number, "Clock", keep)


def test_files_rotate_by_size_and_each_repeats_what_is_kept(tmp_path: Path) -> None:
    sinks = MessageSinks(SCHEMAS, tmp_path / "run.mcap", 200_000)
    sinks.write(entry(0, keep="map"))
    noise = random.Random(1)
    for number in range(1, 12):
        # Each is more than a chunk, and cannot be compressed much.
        sinks.write(Entry("/iw/clock", noise.randbytes(600_000).hex().encode(), number, "Clock"))
    sinks.close({"ticks": "3"})
    assert len(sinks.files) > 2
    assert sinks.files[:2] == [tmp_path / "run.mcap", tmp_path / "run-2.mcap"]
    assert all(messages(path)[0] == entry(0).message for path in sinks.files)
    assert sum(len(messages(path)) - 1 for path in sinks.files) == 11


def test_a_file_that_came_meanwhile_is_not_replaced_by_a_part(tmp_path: Path) -> None:
    sinks = MessageSinks(SCHEMAS, tmp_path / "run.mcap", 1, overwrite=False)
    (tmp_path / "run-2.mcap").write_text("of another recording")
    with pytest.raises(FileExistsError):
        sinks.write(entry(0))
    assert (tmp_path / "run-2.mcap").read_text() == "of another recording"


def test_a_file_without_an_end_is_readable_up_to_the_last_flush(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    sinks = MessageSinks(SCHEMAS, path, 10**9)
    for number in range(10):
        sinks.write(entry(number))
    sinks._flush()
    for number in range(10, 20):
        sinks.write(entry(number))
    killed = tmp_path / "killed.mcap"
    killed.write_bytes(path.read_bytes())
    sinks.close({})
    found: list[int] = []
    with killed.open("rb") as file, pytest.raises(EndOfFile):
        found.extend(one.log_time for *_, one in NonSeekingReader(file).iter_messages(log_time_order=False))
    assert found == list(range(10))
    assert len(messages(path)) == 20


def test_a_full_disk_ends_the_recording_with_its_reason() -> None:
    sinks = MessageSinks(SCHEMAS, Path("/dev/full"), 10**9)
    sinks.write(entry(0))
    with pytest.raises(OSError, match="No space left"):
        sinks._flush()
    with pytest.raises(OSError, match="No space left"):
        sinks.close({})


def test_a_port_in_use_is_refused(tmp_path: Path) -> None:
    first, second = MessageSinks(SCHEMAS, None, 1), MessageSinks(SCHEMAS, None, 1)
    port = first.serve("w", "127.0.0.1", 0, None)
    with pytest.raises(OSError, match=f"--port: expected a free port, got {port}, which is in use.*; --port 0 picks"):
        second.serve("w", "127.0.0.1", port, None)
    with pytest.raises(OSError, match=r"cannot serve at 203\.0\.113\.1:0: "):  # an address of documentation
        second.serve("w", "203.0.113.1", 0, None)
    first.close({})
    second.close({})


def test_a_chunk_can_be_completed_in_memory(tmp_path: Path) -> None:
    file = OutputFile(tmp_path / "x")
    file.write(b"head")
    file.commit()
    file.write(b"????body")
    assert file.seek(4) == 4
    file.write(b"size")
    assert file.seek(0, 2) == 12
    file.close()
    assert (tmp_path / "x").read_bytes() == b"headsizebody"


def test_parts_are_numbered() -> None:
    assert [part_of(Path("a/run.mcap"), number).name for number in (1, 2)] == ["run.mcap", "run-2.mcap"]
