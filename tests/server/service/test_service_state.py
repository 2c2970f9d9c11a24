from intellwheels_server.service.service_state import ServiceState
from intellwheels_server.world.inputs import Note
from tests.server.stage import Stage


def service_of(stage: Stage) -> ServiceState:
    return stage.live_run._service


def test_reply_names_run_tick_and_hash_and_cuts_long_words() -> None:
    service = service_of(Stage())
    result = service.result("failed", "x" * 2000)
    assert (result.run, result.tick, result.hash) == (service.state.run, service.state.tick, service.digest())
    assert result.text == "x" * 1000


def test_changes_that_ask_for_changes_are_all_made() -> None:
    service = service_of(Stage())
    made: list[str] = []

    def first(_now: float) -> None:
        made.append("first")
        service.later(lambda _now: made.append("second"))

    service.later(first)
    service.change(0.0)
    assert made == ["first", "second"]
    assert not service.pending


def test_change_of_the_world_is_kept_for_the_log_and_told() -> None:
    service = service_of(Stage())
    service.apply(Note(code="paused"), 0.0)
    assert service.changes[-1] == Note(code="paused")
    assert service.state.event_count == 1


def test_run_that_is_held_stands() -> None:
    service = service_of(Stage())
    service.held = True
    assert service.stands()
    assert service.may_change()
