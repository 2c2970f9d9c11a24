from __future__ import annotations

import pytest

from intellwheels_schemas.access_rules import ACCESS, Rule, rules_for
from intellwheels_schemas.channels import CHANNELS
from intellwheels_schemas.keys import AGENT_VERBS, VERBS
from intellwheels_schemas.lab_rules import LAB_ROLES
from intellwheels_schemas.messages import May


def allowed(may: May, flow: str, message: str) -> set[str]:
    return {key for rule in rules_for(may) if rule.flow == flow and message in rule.messages for key in rule.keys}


def test_no_key_of_the_contract_is_forgotten() -> None:
    assert list(ACCESS) == list(CHANNELS)
    assert len(ACCESS) == 25


def test_every_key_has_somebody_who_writes_and_somebody_who_reads() -> None:
    for name, roles in ACCESS.items():
        kinds = set(roles.values())
        assert set(roles) <= set(LAB_ROLES)
        assert "simulator" in roles
        assert kinds & {"writes", "both"}, name
        assert kinds & {"reads", "both"}, name


def test_simulator_may_do_everything_in_its_world_and_nothing_elsewhere() -> None:
    rules = rules_for(May(role="simulator", world="lab"))
    assert {key for rule in rules for key in rule.keys} == {"iw/v1/lab/**"}


def test_mind_speaks_and_hears_in_its_own_name_only() -> None:
    may = May(role="mind", agents=("st1-*", "lab1"))
    assert allowed(may, "ingress", "put") == {
        f"iw/v1/main/{key}"
        for agent in ("st1-$*", "lab1")
        for key in (f"in/{agent}/actions", f"in/{agent}/say", f"crew/{agent}/actions")
    }
    assert allowed(may, "ingress", "liveliness_token") == {
        f"iw/v1/main/in/{agent}/alive/mind/{rest}" for agent in ("st1-$*", "lab1") for rest in ("*", "*/*")
    }
    assert "iw/v1/main/out/lab1/measures" in allowed(may, "egress", "put")
    assert "iw/v1/main/out/lab1/power" not in allowed(may, "egress", "put")
    assert "iw/v1/main/state/*" not in allowed(may, "ingress", "query")


def test_viewer_sees_everybody_and_steers_its_own() -> None:
    may = May(role="viewer", agents=("st1-*",))
    assert "iw/v1/main/out/*/measures" in allowed(may, "egress", "put")
    assert allowed(may, "ingress", "put") == {"iw/v1/main/user/st1-$*"}
    assert "iw/v1/main/ctl/take/st1-$*" in allowed(may, "ingress", "query")
    assert not any("/ctl/" in key and "/take/" not in key for key in allowed(may, "ingress", "query"))
    assert allowed(May(role="viewer"), "ingress", "put") == set()


def test_operator_asks_for_its_verbs_about_its_agents() -> None:
    some = allowed(May(role="operator", agents=("*",), verbs=("pause", "take")), "ingress", "query")
    assert {key for key in some if "/ctl/" in key} == {"iw/v1/main/ctl/pause", "iw/v1/main/ctl/take/*"}
    every = allowed(May(role="operator", agents=("a",)), "ingress", "query")
    assert {key.split("/ctl/")[1] for key in every if "/ctl/" in key} == {
        f"{verb}/a" if verb in AGENT_VERBS else verb for verb in VERBS
    }


@pytest.mark.parametrize("role", [role for role in LAB_ROLES if role != "simulator"])
def test_nobody_but_a_recorder_reads_what_agents_say_to_the_simulator(role: str) -> None:
    may = May(role=role, agents=("a",))  # type: ignore[arg-type]
    assert any("/in/" in key for key in allowed(may, "egress", "put")) is (role == "recorder")


def test_rules_with_the_same_messages_are_one() -> None:
    rules = rules_for(May(role="agent", agents=("a",)))
    assert len({(rule.messages, rule.flow) for rule in rules}) == len(rules)
    for role in LAB_ROLES:
        assert all(isinstance(rule, Rule) and rule.keys for rule in rules_for(May(role=role))), role
