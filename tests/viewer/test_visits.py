"""What a browser may do by how it has come."""

from __future__ import annotations

import datetime

import pytest

from intellwheels_schemas.messages import Identity, Lab, May
from intellwheels_viewer.visits import Door

TEACHER = Identity(name="teacher", may=(May(role="operator", agents=("*",)),))
USERS = Door(user_header="x-remote-user", lab=Lab(format="iw.v1", name="room3", identity=(TEACHER,)))


@pytest.mark.parametrize(
    ("door", "headers", "why"),
    [
        (Door(), {}, ""),
        (Door(wide=True), {"origin": "http://a"}, ""),
        (Door(wide=True), {}, "a program that sends no Origin may not steer; see --allow-programs"),
        (Door(wide=True, programs=True), {}, ""),
        (USERS, {}, "the proxy named no user in x-remote-user"),
        (USERS, {"x-remote-user": "mallory"}, "mallory is not in the lab's document"),
        (USERS, {"x-remote-user": "teacher,teacher"}, "teacher,teacher is not in the lab's document"),
    ],
)
def test_who_may_only_look_is_told_why(door: Door, headers: dict[str, str], why: str) -> None:
    assert door.rights(headers).looks_only == why


def test_user_has_the_rights_of_the_lab() -> None:
    rights = USERS.rights({"x-remote-user": "teacher"})
    assert (rights.looks_only, rights.holders) == ("", (TEACHER,))


def test_user_whose_last_day_is_over_may_only_look() -> None:
    guest = Identity(name="guest", until="2026-12-31", may=TEACHER.may)
    door = Door(user_header="x-remote-user", lab=Lab(format="iw.v1", name="room3", identity=(guest,)))
    headers = {"x-remote-user": "guest"}
    assert door.rights(headers, datetime.date(2026, 12, 31)).holders == (guest,)
    assert door.rights(headers, datetime.date(2027, 1, 1)).looks_only == "guest expired after 2026-12-31"


def test_page_without_a_login_that_others_reach_says_so() -> None:
    assert Door(wide=True).warning.startswith("open: other machines reach the page without a login")
    assert Door().warning == Door(wide=True, user_header="x-remote-user").warning == ""
