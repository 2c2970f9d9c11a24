from intellwheels_schemas.file_records import Note
from intellwheels_server.service.publish_schedule import MIN_INTERVAL
from intellwheels_server.service.service_state import ServiceState
from tests.server.stage import Stage


def service_of(stage: Stage) -> ServiceState:
    return stage.live_run._service


def test_queued_changes_that_queue_changes_are_all_made() -> None:
    service = service_of(Stage())
    made: list[str] = []

    def first(_now: float) -> None:
        made.append("first")
        service.queue_change(lambda _now: made.append("second"))

    service.queue_change(first)
    service.make_queued_changes(0.0)
    assert made == ["first", "second"]
    assert not service.has_queued_changes


def test_change_of_the_world_is_kept_for_the_log_and_published() -> None:
    stage = Stage()
    service = service_of(stage)
    service.publisher.schedule.mark_published(0.0)
    service.apply(Note(code="paused"))
    assert service.run.unrecorded[-1] == Note(code="paused")
    assert stage.events() == ["paused"]
    assert service.publisher.schedule.due() == MIN_INTERVAL


def test_run_that_waits_for_agents_is_stopped_and_may_change() -> None:
    service = service_of(Stage(expect=("chair1",)))
    assert service.missing_agents() == ["chair1"]
    assert service.is_stopped()
    assert service.may_change()
