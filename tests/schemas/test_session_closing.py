from __future__ import annotations

import threading

import pytest

from intellwheels_schemas.link import Link, open_session, query, tokens
from intellwheels_schemas.session_closing import asking, close_session, closing
from tests.schemas.test_link import free_endpoint

ROUNDS = 20


class Held:
    """A session that another thread is inside of for a number of calls."""

    def __init__(self, calls: int, text: str = "Already borrowed") -> None:
        self.calls, self.text, self.closed = calls, text, False

    def close(self) -> None:
        if self.calls:
            self.calls -= 1
            raise RuntimeError(self.text)
        self.closed = True

    def is_closed(self) -> bool:
        return self.closed


def test_session_is_closed_when_the_other_thread_has_left_it() -> None:
    session = Held(3)
    with closing(session) as used:
        assert used is session
    assert session.closed


def test_other_errors_of_closing_are_not_hidden() -> None:
    with pytest.raises(RuntimeError, match="no such thing"):
        close_session(Held(1, "no such thing"))


def test_call_of_a_session_that_is_closed_is_a_lost_connection() -> None:
    session = Held(0)
    with pytest.raises(ConnectionError, match="the session is closed"), asking(session):
        raise RuntimeError("Already mutably borrowed")
    with pytest.raises(ValueError, match="a bug"), asking(session):
        raise ValueError("a bug")
    session.close()
    with pytest.raises(ConnectionError, match="the session is closed"), asking(session):
        raise ValueError("session closed")


@pytest.mark.process
def test_session_closes_while_other_threads_ask() -> None:
    wrong: list[BaseException] = []

    def ask(session: object, begun: threading.Event) -> None:
        try:
            while True:
                begun.set()
                with_session(session)
        except ConnectionError as error:
            if "closed" not in str(error):
                wrong.append(error)
        except BaseException as error:
            wrong.append(error)

    def with_session(session: object) -> None:
        try:
            query(session, "a/b", timeout=0.05)  # type: ignore[arg-type]
        except ConnectionError as error:
            if "no simulator" not in str(error):
                raise
        tokens(session, "a/*", timeout=0.05)  # type: ignore[arg-type]

    for _ in range(ROUNDS):
        session = open_session(Link(listen=(free_endpoint(),)), threading.Event(), timeout=5.0)
        assert session is not None
        begun = [threading.Event() for _ in range(3)]
        threads = [threading.Thread(target=ask, args=(session, each)) for each in begun]
        for thread in threads:
            thread.start()
        assert all(each.wait(5.0) for each in begun)
        close_session(session)
        for thread in threads:
            thread.join(5.0)
        assert not any(thread.is_alive() for thread in threads)
    assert wrong == []
