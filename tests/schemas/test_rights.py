"""Denials in words, by the rules of the router."""

from __future__ import annotations

import pytest

from intellwheels_schemas.access_rules import ACCESS
from intellwheels_schemas.channels import CHANNELS
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import Identity, May, Role
from intellwheels_schemas.rights import Does, denial, join_denial, rights_key, serve_denial
from tests.every_case import every_case

STUDENT = Identity(
    name="student1",
    may=(
        May(role="agent", agents=("st1-*",)),
        May(role="mind", agents=("lab1",)),
        May(role="viewer", agents=("st1-*",)),
    ),
)
TEACHER = Identity(name="teacher", may=(May(role="operator", agents=("*",), verbs=("pause", "resume", "take")),))
KEYS = Keys("main")


@every_case(
    ("who", "key", "does", "text"),
    [
        (STUDENT, "iw/v1/main/ctl/pause", "query", "student1 may not ask for ctl/pause in world main"),
        (TEACHER, "iw/v1/main/ctl/pause", "query", ""),
        (TEACHER, "iw/v1/main/ctl/reset", "query", "teacher may not ask for ctl/reset in world main"),
        (TEACHER, "iw/v1/main/ctl/take/st1-a", "query", ""),
        (TEACHER, "iw/v1/ward/ctl/pause", "query", "teacher may not ask for ctl/pause in world ward, only in main"),
        (STUDENT, "iw/v1/main/ctl/take/st1-a", "query", ""),
        (STUDENT, "iw/v1/main/ctl/take/st2-a", "query", "student1 may not ask for ctl/take/st2-a in world main"),
        (STUDENT, "iw/v1/main/user/st1-a", "put", ""),
        (STUDENT, "iw/v1/main/crew/st2-p/join", "query",
         "student1 may not ask for crew/st2-p/join in world main, only as st1-*, lab1"),
        (STUDENT, "iw/v1/main/user/st10", "put", "student1 may not write user/st10 in world main"),
        (STUDENT, "iw/v1/main/state/*", "read", ""),
        (STUDENT, "iw/v1/main/event?since=3", "query", ""),
        (STUDENT, "iw/v1/main/in/st1-a/pose", "read", "student1 may not read in/st1-a/pose in world main"),
        (STUDENT, "iw/v1/main/alive", "watch", ""),
        (STUDENT, "iw/v1/lab/alive", "watch", "student1 may not see alive in world lab, only in main"),
        (Identity(name="idle"), "iw/v1/main/map", "query", "idle may not ask for map in world main"),
    ],
)  # fmt: skip
def test_denial_names_who_what_and_where(who: Identity, key: str, does: Does, text: str) -> None:
    assert denial(who, key, does) == text


@pytest.mark.parametrize("name", [name for name, channel in CHANNELS.items() if channel.kind == "query"])
def test_operator_of_everything_may_query_what_the_table_says(name: str) -> None:
    who = Identity(name="op", may=(May(role="operator", agents=("*",)),))
    verb = "take" if name == "ctl_agent" else "pause"
    key = KEYS.prefix + CHANNELS[name].key.replace("<agent>", "a").replace("<verb>", verb)
    assert (denial(who, key) == "") is ("operator" in ACCESS[name])


@pytest.mark.parametrize(
    ("role", "agent", "text"),
    [
        ("both", "st1-a", ""),
        ("mind", "st1-a", ""),
        ("mind", "lab1", ""),
        ("both", "lab1", "student1 may not be the body and mind of 'lab1' in world main, only st1-*"),
        ("mind", "st2-a", "student1 may not be the mind of 'st2-a' in world main, only st1-*, lab1"),
        ("body", "st1-a", "student1 may not be the body of 'st1-a' in world main, nobody there"),
    ],
)
def test_join_is_denied_in_words(role: Role, agent: str, text: str) -> None:
    assert join_denial(STUDENT, "main", role, agent) == text


def test_join_in_another_world_names_the_right_one() -> None:
    text = "student1 may not be the mind of 'st1-a' in world ward, only in main"
    assert join_denial(STUDENT, "ward", "mind", "st1-a") == text


def test_simulator_of_another_world_is_denied() -> None:
    simulator = Identity(name="sim", may=(May(role="simulator"),))
    assert serve_denial(simulator, "main") == ""
    assert serve_denial(simulator, "ward") == "sim may not be the simulator of world ward, only in main"
    assert serve_denial(STUDENT, "main") == "student1 may not be the simulator of world main"


def test_key_of_the_rights_is_in_no_world() -> None:
    assert rights_key("student1") == "iw/v1/@rights/student1"
