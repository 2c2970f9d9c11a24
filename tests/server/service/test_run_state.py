from __future__ import annotations

from intellwheels_maps import floor
from intellwheels_schemas.file_records import Inputs, Note
from intellwheels_server import world
from intellwheels_server.service.run_state import RunState

RUN = "0123456789abcdef"


class Lines:
    """A log in memory."""

    def __init__(self) -> None:
        self.lines: list[tuple[int, Inputs, str, bool]] = []

    def __call__(self, tick: int, inputs: Inputs, digest: str, *, stepped: bool) -> None:
        self.lines.append((tick, inputs, digest, stepped))


def begin(record: Lines | None = None) -> RunState:
    return RunState(world.begin(world.Setup(floor=floor("room")), RUN), record)


def test_reply_has_run_tick_and_hash_and_cuts_a_long_text() -> None:
    run = begin()
    result = run.result("failed", "x" * 2000)
    assert (result.run, result.tick, result.hash) == (RUN, 0, world.digest(run.state))
    assert result.text == "x" * 1000


def test_hash_follows_the_state() -> None:
    run = begin()
    before = run.digest()
    run.advance(Inputs())
    assert run.digest() == world.digest(run.state) != before


def test_line_of_a_step_has_the_changes_before_it() -> None:
    log = Lines()
    run = begin(log)
    note = Note(code="paused")
    _, events = run.apply(note)
    assert [event.code for event in events] == ["paused"]
    run.advance(Inputs())
    run.record_step(0, Inputs())
    assert log.lines == [(0, Inputs(changes=(note,)), run.digest(), True)]
    assert run.unrecorded == ()


def test_changes_without_a_step_are_a_line_of_their_own() -> None:
    log = Lines()
    run = begin(log)
    note = Note(code="resumed")
    run.apply(note)
    run.record_changes(0)
    assert log.lines == [(0, Inputs(changes=(note,)), run.digest(), False)]
    assert run.unrecorded == ()


def test_without_a_log_changes_are_still_forgotten() -> None:
    run = begin()
    run.apply(Note(code="paused"))
    run.record_changes(0)
    assert run.unrecorded == ()
