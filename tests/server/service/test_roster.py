from __future__ import annotations

import pytest

from intellwheels_schemas.codec import Encoding
from intellwheels_schemas.errors import RequestRefusedError
from intellwheels_schemas.messages import Robot, Role
from intellwheels_server.service import roster as roster_module
from intellwheels_server.service.roster import MAX_INSTANCES, Member, Roster, check_session, new_hex, same_body

A, B = "a" * 16, "b" * 16


def robot(instance: str | None = A, role: Role = "both") -> Robot:
    return Robot(name="chair1", role=role, instance=instance, length=1.0, width=0.6, center=0.5, top=1.0, top_speed=1.0)


def member(instance: str = A, role: Role = "both", session: str = "1" * 16, *, real: bool = False) -> Member:
    return Member("chair1", role, instance, session, Encoding.JSON, robot(instance, role), real=real)


def with_member(role: Role = "both") -> tuple[Roster, Member]:
    roster = Roster()
    roster.token("chair1", role, A, present=True, now=0.0)
    current = member(role=role)
    roster.add(current)
    return roster, current


def refusal(roster: Roster, wanted: Robot, session: str | None = None, agent: str = "chair1") -> str:
    with pytest.raises(RequestRefusedError) as caught:
        roster.predecessor(agent, wanted, session)
    return caught.value.code


def test_join_needs_a_token_of_the_same_instance() -> None:
    roster = Roster()
    assert refusal(roster, robot()) == "no-token"
    roster.token("chair1", "both", B, present=True, now=0.0)
    assert refusal(roster, robot()) == "no-token"
    roster.token("chair1", "both", A, present=True, now=0.0)
    assert roster.predecessor("chair1", robot(), None) is None


def test_second_instance_is_refused_while_the_token_of_the_first_is_present() -> None:
    roster, _ = with_member()
    roster.token("chair1", "both", B, present=True, now=0.0)
    assert refusal(roster, robot(B)) == "already-here"


def test_old_session_replaces_the_member() -> None:
    roster, current = with_member()
    roster.token("chair1", "both", B, present=True, now=0.0)
    assert roster.predecessor("chair1", robot(B), current.session) is current
    assert refusal(roster, robot(B), "2" * 16) == "already-here"


def test_successor_replaces_a_member_whose_token_is_gone() -> None:
    roster, current = with_member()
    roster.token("chair1", "both", B, present=True, now=0.0)
    assert roster.token("chair1", "both", A, present=False, now=1.0) is current
    assert roster.predecessor("chair1", robot(B), None) is current


def test_same_instance_may_join_again() -> None:
    roster, current = with_member()
    assert roster.predecessor("chair1", robot(), None) is current


@pytest.mark.parametrize(
    ("present", "joining"), [("both", "mind"), ("both", "body"), ("mind", "both"), ("body", "both")]
)
def test_role_both_excludes_the_other_roles(present: Role, joining: Role) -> None:
    roster, _ = with_member(present)
    roster.token("chair1", joining, B, present=True, now=0.0)
    assert refusal(roster, robot(B, joining)) == "already-here"


def test_body_and_mind_may_be_different_processes() -> None:
    roster, body = with_member("body")
    roster.token("chair1", "mind", B, present=True, now=0.0)
    assert roster.predecessor("chair1", robot(B, "mind"), None) is None
    mind = member(B, "mind")
    roster.add(mind)
    assert (roster.body("chair1"), roster.mind("chair1")) == (body, mind)


def test_names_are_checked() -> None:
    roster, _ = with_member()
    assert refusal(roster, robot(), agent="operator") == "name"
    assert refusal(roster, robot(), agent="chair2") == "name"


def test_member_is_lost_after_the_grace_time_unless_its_token_returns() -> None:
    roster, current = with_member()
    roster.token("chair1", "both", A, present=False, now=1.0)
    assert roster.due(3.0) == 4.0
    assert roster.lost(3.9, 3.0) == []
    assert roster.lost(4.0, 3.0) == [current]
    assert roster.token("chair1", "both", A, present=True, now=4.0) is current
    assert roster.lost(9.0, 3.0) == []


def test_token_of_another_instance_changes_no_presence() -> None:
    roster, _ = with_member()
    assert roster.token("chair1", "both", B, present=True, now=0.0) is None
    assert roster.token("chair1", "both", B, present=False, now=0.0) is None


def test_many_tokens_of_one_role_or_of_many_names_keep_nobody_else_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(roster_module, "MAX_TOKENS", 3 * MAX_INSTANCES)
    roster, current = with_member()
    for number in range(2 * MAX_INSTANCES):
        roster.token("chair2", "both", f"{number:016x}", present=True, now=0.0)
    assert roster.has_token("chair2", "both", f"{MAX_INSTANCES - 1:016x}")
    assert not roster.has_token("chair2", "both", f"{MAX_INSTANCES:016x}")
    for number in range(4 * MAX_INSTANCES):
        roster.token(f"chair{number + 3}", "both", B, present=True, now=0.0)
    # The oldest are forgotten, but no member.
    assert not roster.has_token("chair2", "both", f"{0:016x}")
    assert roster.has_token("chair1", "both", current.instance)
    assert roster.has_token(f"chair{4 * MAX_INSTANCES + 2}", "both", B)
    roster.token("chair2", "both", f"{0:016x}", present=False, now=0.0)


def test_token_of_a_member_returns_though_others_took_its_place() -> None:
    roster, current = with_member()
    roster.token("chair1", "both", A, present=False, now=0.0)
    for number in range(MAX_INSTANCES):
        roster.token("chair1", "both", f"{number:016x}", present=True, now=0.0)
    assert roster.token("chair1", "both", A, present=True, now=1.0) is current
    assert refusal(roster, robot(B)) == "no-token"
    assert roster.has_token("chair1", "both", A)


def test_role_of_a_removed_member_is_free() -> None:
    roster, current = with_member()
    roster.remove(current)
    assert "chair1" not in roster
    assert roster.predecessor("chair1", robot(), None) is None


def test_real_body_answers_with_its_pose_and_mind_with_actions() -> None:
    assert member().answers() == (("chair1", "actions"),)
    assert member(role="body", real=True).answers() == (("chair1", "pose"),)
    assert member(role="body").answers() == ()
    assert member(real=True).answers() == (("chair1", "actions"), ("chair1", "pose"))


def test_sessions_distinguish_roles_and_instances() -> None:
    mind, body = member(B, "mind", "2" * 16), member(A, "body", "1" * 16)
    both = (mind, body)
    assert check_session(mind, both, "2" * 16, "Actions") is None

    def code(found: object) -> object:
        return getattr(found, "code", None)

    assert code(check_session(mind, both, "1" * 16, "Actions")) == "role"
    assert code(check_session(mind, both, "3" * 16, "Actions")) == "session"
    assert code(check_session(mind, both, None, "Actions")) == "session"
    assert code(check_session(None, both, None, "Pose")) == "role"
    assert code(check_session(None, (), None, "Pose")) == "not-joined"
    assert code(check_session(member(real=True), (), None, "Actions")) == "session"


def test_same_body_may_ask_for_another_place() -> None:
    placed = Robot(name="chair1", instance=B, place="bed1", length=1.0, width=0.6, center=0.5, top=1.0, top_speed=1.0)
    assert same_body(robot(), placed)
    assert not same_body(robot(), Robot(name="chair1", length=1.1, width=0.6, center=0.5, top=1.0, top_speed=1.0))


def test_new_hex_is_sixteen_digits_and_differs_each_time() -> None:
    assert len({new_hex() for _ in range(100)}) == 100
    assert all(len(new_hex()) == 16 for _ in range(10))
