from __future__ import annotations

from intellwheels_server.service.publish_schedule import FASTEST, IDLE, Cadence


def test_news_goes_out_at_most_sixty_times_a_second() -> None:
    cadence = Cadence()
    published = 0
    for millisecond in range(1000):
        cadence.note()
        published += cadence.ready(millisecond / 1000)
    assert 55 <= published <= 60


def test_the_last_news_is_never_forgotten() -> None:
    cadence = Cadence()
    assert cadence.ready(0.0)
    cadence.note()
    assert not cadence.ready(0.001)
    assert cadence.due() == FASTEST
    assert cadence.ready(FASTEST)
    assert not cadence.news


def test_without_news_it_is_twice_a_second() -> None:
    cadence = Cadence()
    assert cadence.ready(0.0)
    assert cadence.due() == IDLE
    assert not cadence.ready(0.49)
    assert cadence.ready(0.5)
