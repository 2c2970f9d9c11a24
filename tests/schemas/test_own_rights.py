"""What the router of a lab, or the identity file, says about a session's own rights."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path

import pytest
import zenoh

from intellwheels_schemas import link
from intellwheels_schemas.identity_file import IdentityFile, identity_text, write_secret
from intellwheels_schemas.messages import Identity, May
from intellwheels_schemas.own_rights import (
    NotAllowedError,
    answer_rights,
    denied,
    denied_join,
    denied_service,
    own_rights,
)
from intellwheels_schemas.router_link import open_router
from tests.e2e.stage import free_port

pytestmark = pytest.mark.process
STUDENT = Identity(name="student1", may=(May(role="viewer"),))


@pytest.fixture(scope="module")
def router(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[zenoh.Session, str]]:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    users = tmp_path_factory.mktemp("lab") / "lab.users"
    users.write_text("student1:12345678\n")
    with open_router([endpoint], {"transport/auth/usrpwd": {"dictionary_file": str(users)}}) as session:
        yield session, endpoint


def opened(endpoint: str, folder: Path, may: tuple[May, ...] = ()) -> zenoh.Session:
    file = folder / "student1.iwid"
    write_secret(file, identity_text(IdentityFile(name="student1", password="12345678", may=may)))
    session = link.open_session(link.Link(connect=(endpoint,), identity=file), threading.Event(), timeout=20.0)
    assert session is not None
    return session


def test_router_s_word_counts_before_that_of_the_file(router: tuple[zenoh.Session, str], tmp_path: Path) -> None:
    hub, endpoint = router
    with opened(endpoint, tmp_path, (May(role="operator", agents=("*",)),)) as session:
        # The official router does not answer.
        known = own_rights(session)
        assert known is not None
        assert known.may[0].role == "operator"
        assert own_rights(session, sure=True) is None
        assert denied_service(session, "main") == ""
        with pytest.raises(ConnectionError, match=r"^no simulator at iw/v1/main/ctl/pause, or not allowed$"):
            link.query(session, "iw/v1/main/ctl/pause", timeout=1.0)
        (answering,) = answer_rights(hub, [STUDENT])
        try:
            assert own_rights(session, sure=True) == STUDENT
            with pytest.raises(NotAllowedError, match=r"^student1 may not ask for ctl/pause in world main$"):
                link.query(session, "iw/v1/main/ctl/pause", timeout=1.0)
            with pytest.raises(ConnectionError, match=r"^no simulator at iw/v1/main/map$"):
                link.query(session, "iw/v1/main/map", timeout=1.0)
            assert denied(session, "iw/v1/main/user/a", "put") == "student1 may not write user/a in world main"
            assert denied(session, "iw/v1/main/clock", "read") == ""
            assert denied_service(session, "main") == "student1 may not be the simulator of world main"
            assert denied_join(session, "main", "both", "a").startswith("student1 may not be the body and mind of 'a'")
        finally:
            answering.undeclare()


def test_nothing_is_denied_if_nobody_knows(router: tuple[zenoh.Session, str], tmp_path: Path) -> None:
    _, endpoint = router
    with opened(endpoint, tmp_path) as session:
        assert own_rights(session) is None
        assert denied(session, "iw/v1/main/user/a", "put") == denied_join(session, "main", "both", "a") == ""
        with pytest.raises(ConnectionError, match="no simulator at iw/v1/main/map, or not allowed"):
            link.query(session, "iw/v1/main/map", timeout=1.0)
