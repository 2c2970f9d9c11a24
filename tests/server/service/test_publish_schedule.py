from __future__ import annotations

from intellwheels_server.service.publish_schedule import IDLE_INTERVAL, MIN_INTERVAL, PublishSchedule


def test_changes_are_published_at_most_sixty_times_a_second() -> None:
    schedule = PublishSchedule()
    published = 0
    for millisecond in range(1000):
        schedule.mark_changed()
        published += schedule.take_due(millisecond / 1000)
    assert 55 <= published <= 60


def test_last_change_is_always_published() -> None:
    schedule = PublishSchedule()
    assert schedule.take_due(0.0)
    schedule.mark_changed()
    assert not schedule.take_due(0.001)
    assert schedule.due() == MIN_INTERVAL
    assert schedule.take_due(MIN_INTERVAL)
    assert schedule.due() == MIN_INTERVAL + IDLE_INTERVAL  # nothing is left to publish


def test_without_changes_it_publishes_twice_a_second() -> None:
    schedule = PublishSchedule()
    assert schedule.take_due(0.0)
    assert schedule.due() == IDLE_INTERVAL
    assert not schedule.take_due(0.49)
    assert schedule.take_due(0.5)


def test_state_that_shows_the_same_goes_out_twice_a_second_and_another_one_at_once() -> None:
    schedule = PublishSchedule()
    published = [tick for tick in range(100) if schedule.take_state("still", tick * 0.05)]
    assert 19 <= len(published) * 2 <= 22
    assert schedule.take_state("moved", 5.0)
    assert not schedule.take_state("moved", 5.05)
    schedule.mark_state("moved", 5.45)
    assert not schedule.take_state("moved", 5.5)
