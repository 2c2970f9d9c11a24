from __future__ import annotations

import pytest

from intellwheels_schemas.codec import Encoding
from intellwheels_schemas.errors import RequestRefusedError
from intellwheels_schemas.messages import Robot, Role
from intellwheels_server.service.roster import Roster, Seat, check_session, new_hex, same_body

A, B = "a" * 16, "b" * 16


def robot(instance: str | None = A, role: Role = "both") -> Robot:
    return Robot(name="chair1", role=role, instance=instance, length=1.0, width=0.6, center=0.5, top=1.0, top_speed=1.0)


def seat(instance: str = A, role: Role = "both", session: str = "1" * 16, *, real: bool = False) -> Seat:
    return Seat("chair1", role, instance, session, Encoding.JSON, robot(instance, role), real=real)


def with_seat(role: Role = "both") -> tuple[Roster, Seat]:
    roster = Roster()
    roster.token("chair1", role, A, present=True, now=0.0)
    held = seat(role=role)
    roster.sit(held)
    return roster, held


def refusal(roster: Roster, wanted: Robot, shown: str | None = None, agent: str = "chair1") -> str:
    with pytest.raises(RequestRefusedError) as caught:
        roster.holder(agent, wanted, shown)
    return caught.value.code


def test_a_free_seat_needs_a_token_of_the_same_instance() -> None:
    roster = Roster()
    assert refusal(roster, robot()) == "no-token"
    roster.token("chair1", "both", B, present=True, now=0.0)
    assert refusal(roster, robot()) == "no-token"
    roster.token("chair1", "both", A, present=True, now=0.0)
    assert roster.holder("chair1", robot(), None) is None


def test_a_second_instance_is_refused_while_the_token_of_the_first_lives() -> None:
    roster, _ = with_seat()
    roster.token("chair1", "both", B, present=True, now=0.0)
    assert refusal(roster, robot(B)) == "already-here"


def test_the_old_session_opens_the_seat() -> None:
    roster, held = with_seat()
    roster.token("chair1", "both", B, present=True, now=0.0)
    assert roster.holder("chair1", robot(B), held.session) is held
    assert refusal(roster, robot(B), "2" * 16) == "already-here"


def test_a_successor_takes_the_seat_once_the_token_is_gone() -> None:
    roster, held = with_seat()
    roster.token("chair1", "both", B, present=True, now=0.0)
    assert roster.token("chair1", "both", A, present=False, now=1.0) is held
    assert roster.holder("chair1", robot(B), None) is held


def test_the_same_instance_may_ask_again() -> None:
    roster, held = with_seat()
    assert roster.holder("chair1", robot(), None) is held


@pytest.mark.parametrize(
    ("sitting", "coming"), [("both", "mind"), ("both", "body"), ("mind", "both"), ("body", "both")]
)
def test_both_shares_its_agent_with_no_other_role(sitting: Role, coming: Role) -> None:
    roster, _ = with_seat(sitting)
    roster.token("chair1", coming, B, present=True, now=0.0)
    assert refusal(roster, robot(B, coming)) == "already-here"


def test_body_and_mind_are_seats_of_different_processes() -> None:
    roster, body = with_seat("body")
    roster.token("chair1", "mind", B, present=True, now=0.0)
    assert roster.holder("chair1", robot(B, "mind"), None) is None
    mind = seat(B, "mind")
    roster.sit(mind)
    assert (roster.body("chair1"), roster.mind("chair1")) == (body, mind)


def test_names_are_checked() -> None:
    roster, _ = with_seat()
    assert refusal(roster, robot(), agent="operator") == "name"
    assert refusal(roster, robot(), agent="chair2") == "name"


def test_a_lost_token_counts_after_the_grace_time_unless_it_returns() -> None:
    roster, held = with_seat()
    roster.token("chair1", "both", A, present=False, now=1.0)
    assert roster.due(3.0) == 4.0
    assert roster.lost(3.9, 3.0) == []
    assert roster.lost(4.0, 3.0) == [held]
    assert roster.token("chair1", "both", A, present=True, now=4.0) is held
    assert roster.lost(9.0, 3.0) == []


def test_another_instances_token_says_nothing_of_the_seat() -> None:
    roster, _ = with_seat()
    assert roster.token("chair1", "both", B, present=True, now=0.0) is None
    assert roster.token("chair1", "both", B, present=False, now=0.0) is None


def test_a_seat_that_is_left_is_free() -> None:
    roster, held = with_seat()
    roster.rise(held)
    assert "chair1" not in roster
    assert roster.holder("chair1", robot(), None) is None


def test_a_real_body_answers_with_its_pose_and_a_mind_with_actions() -> None:
    assert seat().answers() == (("chair1", "actions"),)
    assert seat(role="body", real=True).answers() == (("chair1", "pose"),)
    assert seat(role="body").answers() == ()
    assert seat(real=True).answers() == (("chair1", "actions"), ("chair1", "pose"))


def test_sessions_tell_twins_and_roles_apart() -> None:
    mind, body = seat(B, "mind", "2" * 16), seat(A, "body", "1" * 16)
    both = (mind, body)
    assert check_session(mind, both, None, "Actions") is None
    assert check_session(mind, both, "2" * 16, "Actions") is None

    def code(found: object) -> object:
        return getattr(found, "code", None)

    assert code(check_session(mind, both, "1" * 16, "Actions")) == "role"
    assert code(check_session(mind, both, "3" * 16, "Actions")) == "session"
    assert code(check_session(None, both, None, "Pose")) == "role"
    assert code(check_session(None, (), None, "Pose")) == "not-joined"
    assert code(check_session(seat(real=True), (), None, "Actions")) == "session"


def test_the_same_body_may_want_another_place() -> None:
    placed = Robot(name="chair1", instance=B, place="bed1", length=1.0, width=0.6, center=0.5, top=1.0, top_speed=1.0)
    assert same_body(robot(), placed)
    assert not same_body(robot(), Robot(name="chair1", length=1.1, width=0.6, center=0.5, top=1.0, top_speed=1.0))


def test_new_hex_is_sixteen_digits_and_new() -> None:
    assert len({new_hex() for _ in range(100)}) == 100
    assert all(len(new_hex()) == 16 for _ in range(10))
