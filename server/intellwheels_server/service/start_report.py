"""Says who joined, and who has joined where it cannot turn."""

from __future__ import annotations

from intellwheels_maps.turning import TurningCheck
from intellwheels_schemas.messages import Position
from intellwheels_server.service.roster import Member
from intellwheels_server.service.service_state import ServiceState


def report_joined(service: ServiceState, member: Member, position: Position, *, starts: bool) -> None:
    """Write the lines about an agent that has joined.

    Args:
        service: The service.
        member: The agent.
        position: Where its body is.
        starts: Whether the body has just been put there.
    """
    log_line = service.publisher.outlet.log_line
    log_line(f"joined agent={member.agent} role={member.role} tick={service.run.state.tick}")
    if starts and member.has_body and not member.real:
        floor = service.run.state.setup.floor
        if service.turning_check.floor is not floor:
            service.turning_check = TurningCheck(floor)
        why = service.turning_check.narrowness(member.robot, position.x, position.y)
        if why is not None:
            log_line(f"narrow agent={member.agent} why={why!r}")
