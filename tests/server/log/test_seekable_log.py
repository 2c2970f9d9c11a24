from __future__ import annotations

import random
import time
from pathlib import Path

import msgspec
import pytest

from intellwheels_maps import floor, robot
from intellwheels_schemas.file_records import Depart, Inputs, Join
from intellwheels_schemas.messages import Actions
from intellwheels_server.log.input_log import Line, Log, LogError, read_lines
from intellwheels_server.log.seekable_log import Keyframes, Place, SeekableLog
from intellwheels_server.world import Setup, advance, begin, digest
from tests.server.log_edits import records, rewrite
from tests.server.plays import record

RUN = "0123456789abcdef"


def written(path: Path, ticks: int) -> list[str]:
    """Write the log of a chair that drives in circles; return the hash at every tick."""
    setup = Setup(floor=floor("room"))
    log, state = Log(path, setup, RUN, "ward"), begin(setup, RUN)
    hashes = [digest(state)]
    for tick in range(ticks):
        changes = (Join(agent="one", robot=robot("rear-wheel")),) if tick == 0 else ()
        inputs = Inputs(changes=changes, actions={"one": Actions(left_motor=0.2, right_motor=0.25)})
        state, _ = advance(state, inputs)
        hashes.append(digest(state))
        log.write(Line(tick=tick, inputs=inputs, hash=hashes[-1]), 0.0)
    log.close()
    return hashes


def test_every_tick_of_every_run_can_be_reached_in_any_order(tmp_path: Path) -> None:
    seen = record(tmp_path / "log")
    recording = SeekableLog(tmp_path / "log")
    assert recording.runs == tuple(dict.fromkeys(one.run for one in seen))
    assert [recording.ticks(run) for run in recording.runs] == [(0, 50), (0, 15), (20, 35)]
    random.Random(1).shuffle(seen)
    for one in seen:
        place = recording.go_to(one.run, one.tick)
        assert (place.state.run, place.state.tick, digest(place.state)) == one or one.tick in (0, 10, 30)
    recording.close()


def test_next_places_from_the_beginning_show_every_tick_of_every_run_once(tmp_path: Path) -> None:
    seen = record(tmp_path / "log")
    recording = SeekableLog(tmp_path / "log")
    place = recording.go_to(recording.runs[0], 0)
    shown = [place]
    while place.position < recording.end:
        place = recording.next_place(place)
        shown.append(place)
    assert [(one.state.run, one.state.tick) for one in shown] == [(one.run, one.tick) for one in seen]
    assert shown[0].state.names == ("chair1",)
    assert digest(shown[-1].state) == seen[-1].hash
    events = [event for one in shown for event in one.events]
    last = shown[-1].state
    told = list(recording.events(last.run, last.tick))
    assert [event for event in events if event.run == last.run] == told
    recording.close()


def test_run_or_tick_that_is_not_in_the_log_is_an_error(tmp_path: Path) -> None:
    written(tmp_path / "log", 5)
    recording = SeekableLog(tmp_path / "log")
    assert (recording.header.world, recording.ticks("f" * 16)) == ("ward", None)
    with pytest.raises(LookupError, match=r"run 0123456789abcdef: expected a tick in \[0, 5\], got 6"):
        recording.go_to(RUN, 6)
    with pytest.raises(LookupError, match=r"expected a run of this log \(0123456789abcdef\), got f"):
        recording.go_to("f" * 16, 0)
    recording.close()


def test_seek_in_a_long_log_is_quick_and_exact(tmp_path: Path) -> None:
    hashes = written(tmp_path / "log", 1500)
    recording = SeekableLog(tmp_path / "log")
    draw = random.Random(2)
    slowest = 0.0
    for _ in range(20):
        tick = draw.randrange(1501)
        began = time.process_time()
        place = recording.go_to(RUN, tick)
        slowest = max(slowest, time.process_time() - began)
        assert digest(place.state) == hashes[tick] or tick == 0
    assert slowest < 0.5
    recording.close()


def test_keyframes_are_thinned_out_and_one_is_always_near() -> None:
    keyframes = Keyframes(budget=2.0, most=8)
    state = begin(Setup(floor=floor("room")), RUN)
    for position in range(1001):
        keyframes.offer(position, msgspec.structs.replace(state, tick=position), 1.0)
    assert len(keyframes) <= 8
    assert keyframes.budget == 128.0
    for position in range(1001):
        at, kept = keyframes.before(position)
        assert 0 <= position - at <= 2 * keyframes.budget
        assert kept.tick == at


def test_keyframe_follows_a_line_that_took_long() -> None:
    keyframes = Keyframes(budget=0.1)
    state = begin(Setup(floor=floor("room")), RUN)
    for position in range(10):
        keyframes.offer(position, state, 0.7 if position == 4 else 0.01)
    assert [keyframes.before(position)[0] for position in (3, 4, 9)] == [0, 4, 4]


def test_incomplete_last_line_is_dropped_and_a_different_hash_is_reported(tmp_path: Path) -> None:
    path = tmp_path / "log"
    written(path, 5)
    lines = records(path)
    line = msgspec.json.decode(lines[2], type=Line)
    lines[2] = msgspec.json.encode(msgspec.structs.replace(line, hash="f" * 16))
    rewrite(path, lines)
    path.write_bytes(path.read_bytes().rpartition(b'{"End"')[0][:-9])
    recording = SeekableLog(path)
    assert (recording.end, recording.cut) == (4, True)
    assert (recording.differs or "").startswith(f"tick 1 of run {RUN} (line 3): expected hash ffffffffffffffff, got ")
    recording.close()


def test_other_file_is_an_error(tmp_path: Path) -> None:
    path = tmp_path / "log"
    path.write_text("{}\n")
    with pytest.raises(LogError, match=r"log:1: expected the header of an input log"):
        SeekableLog(path)
    written(path, 5)
    lines = records(path)
    rewrite(path, lines[:3] + lines[4:])
    with pytest.raises(LogError, match=r"log:4: expected tick 2, got 3"):
        SeekableLog(path)


def test_agent_that_leaves_after_the_last_step_is_still_shown(tmp_path: Path) -> None:
    path = tmp_path / "log"
    hashes = written(path, 5)
    gone = Line(tick=5, inputs=Inputs(changes=(Depart(agent="one"),)), hash="f" * 16, stepped=False)
    rewrite(path, [*records(path), msgspec.json.encode(gone)])
    recording = SeekableLog(path)
    place = recording.next_place(recording.go_to(RUN, 4))
    assert (place.position, place.state.names, digest(place.state)) == (recording.end, ("one",), hashes[5])
    assert recording.go_to(RUN, 5).state.names == ("one",)
    recording.close()


def test_log_without_lines_is_at_its_end(tmp_path: Path) -> None:
    Log(tmp_path / "log", Setup(floor=floor("room")), RUN).close()
    recording = SeekableLog(tmp_path / "log")
    assert recording.go_to(RUN, 0) == Place(0, recording.go_to(RUN, 0).state)
    assert recording.end == 0
    recording.close()
    with (tmp_path / "log").open("rb") as file:
        file.readline()
        assert list(read_lines(file, "log")) == []
