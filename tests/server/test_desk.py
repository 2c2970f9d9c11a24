from intellwheels_server.desk import Desk
from intellwheels_server.inputs import Note
from tests.server.stage import Stage


def desk_of(stage: Stage) -> Desk:
    return stage.conductor._desk


def test_reply_names_run_tick_and_hash_and_cuts_long_words() -> None:
    desk = desk_of(Stage())
    result = desk.result("failed", "x" * 2000)
    assert (result.run, result.tick, result.hash) == (desk.state.run, desk.state.tick, desk.digest())
    assert result.text == "x" * 1000


def test_changes_that_ask_for_changes_are_all_made() -> None:
    desk = desk_of(Stage())
    made: list[str] = []

    def first(_now: float) -> None:
        made.append("first")
        desk.later(lambda _now: made.append("second"))

    desk.later(first)
    desk.change(0.0)
    assert made == ["first", "second"]
    assert not desk.pending


def test_change_of_the_world_is_kept_for_the_log_and_told() -> None:
    desk = desk_of(Stage())
    desk.apply(Note(code="paused"), 0.0)
    assert desk.changes[-1] == Note(code="paused")
    assert desk.state.event_count == 1


def test_run_that_is_held_stands() -> None:
    desk = desk_of(Stage())
    desk.held = True
    assert desk.stands()
    assert desk.may_change()
