from __future__ import annotations

from intellwheels_schemas.codec import Encoding
from intellwheels_schemas.messages import Robot, Role
from intellwheels_server.service.connected_agents import BridgeStatus, ConnectedAgents
from intellwheels_server.service.roster import Member


def add(agents: ConnectedAgents, agent: str, role: Role, *, real: bool = False, barrier: bool = True) -> None:
    robot = Robot(name=agent, role=role, length=1.0, width=0.6, top=1.0)
    agents.roster.add(Member(agent, role, "a" * 16, "1" * 16, Encoding.JSON, robot, real=real, barrier=barrier))


def test_lockstep_expects_the_answers_of_all_members() -> None:
    agents = ConnectedAgents()
    assert agents.expected_answers() == frozenset()
    add(agents, "chair1", "both")
    add(agents, "chair2", "body", real=True)
    add(agents, "chair2", "mind")
    add(agents, "door1", "both", barrier=False)
    assert agents.expected_answers() == {("chair1", "actions"), ("chair2", "actions"), ("chair2", "pose")}


def test_silence_counts_from_now_for_real_bodies_that_are_not_stale() -> None:
    agents = ConnectedAgents()
    agents.bridges = {"fresh": BridgeStatus(3.0), "later": BridgeStatus(9.0), "stale": BridgeStatus(3.0, stale=True)}
    agents.count_silence_from(5.0)
    assert {name: bridge.reported_at for name, bridge in agents.bridges.items()} == {
        "fresh": 5.0, "later": 9.0, "stale": 3.0
    }  # fmt: skip
