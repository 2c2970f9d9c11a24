"""What a page may do, and why not the rest."""

from __future__ import annotations

from intellwheels_schemas.messages import Identity, May
from intellwheels_viewer.page_rights import EVERYTHING, PageRights

TEACHER = Identity(name="teacher", may=(May(role="operator", agents=("*",), verbs=("pause", "resume", "take")),))
STUDENT = Identity(name="student1", may=(May(role="viewer", agents=("st1-*",)),))


def test_nothing_limits_a_page_by_itself() -> None:
    assert (
        EVERYTHING.why_not("main", "reset") == EVERYTHING.why_not_drive("main", "a") == EVERYTHING.summary("main") == ""
    )


def test_each_verb_has_its_reason() -> None:
    rights = PageRights(holders=(TEACHER,))
    assert rights.why_not("main", "pause") == ""
    assert rights.why_not("main", "reset") == "teacher may not ask for ctl/reset in world main"
    assert (
        rights.why_not_any("main", ("pause", "step", "reset"))
        == "teacher may not ask for ctl/step, ctl/reset in world main"
    )
    assert rights.why_not_any("main", ("pause", "resume")) == ""
    assert rights.why_not_place("main", None) == "teacher may not ask for ctl/spawn in world main"
    assert rights.summary("main") == "As teacher this page may pause, resume, steer every agent"


def test_student_drives_the_own_chair_only() -> None:
    rights = PageRights(holders=(STUDENT,))
    assert rights.why_not_drive("main", "st1-a") == ""
    assert rights.why_not_drive("main", "st2-a") == "student1 may not write user/st2-a in world main"
    assert rights.why_not_see("ward") == "student1 may not read state/* in world ward, only in main"
    assert rights.summary("main") == "As student1 this page may steer st1-*"
    assert rights.where_to_look() == "student1 may look at main"
    assert PageRights(holders=(Identity(name="idle"),)).where_to_look() == "idle may look at no world"


def test_the_narrowest_right_counts() -> None:
    both = PageRights(holders=(TEACHER,)).limited_by(STUDENT)
    assert both.why_not("main", "pause") == "student1 may not ask for ctl/pause in world main"
    assert both.why_not_drive("main", "st2-a") != ""


def test_who_may_only_look_may_nothing_else() -> None:
    rights = PageRights("guests may only look")
    assert rights.why_not("main", "pause") == rights.why_not_drive("main", "a") == "guests may only look"
    assert rights.summary("main") == "View only: guests may only look"
    idle = PageRights(holders=(Identity(name="guest", may=(May(role="viewer"),)),))
    assert idle.summary("main") == "View only: guest may only look"


def test_names_that_a_page_makes_up_are_no_reason_to_fail() -> None:
    rights = PageRights(holders=(STUDENT,))
    for world, agent in (("", "a"), ("<img>", "a"), ("main", "<img>"), ("main", "")):
        assert rights.why_not(world, "take", agent) == rights.why_not_drive(world, agent) == ""
