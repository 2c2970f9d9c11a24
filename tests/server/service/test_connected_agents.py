from __future__ import annotations

from intellwheels_schemas.codec import Encoding
from intellwheels_schemas.messages import Robot, Role
from intellwheels_server.service.connected_agents import ConnectedAgents
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
