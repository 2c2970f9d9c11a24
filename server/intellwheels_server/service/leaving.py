"""Leaves. Those that wait next to each other are taken together, as each change of the bodies costs time."""

from __future__ import annotations

from collections.abc import Collection

from intellwheels_schemas.codec import Encoding, decode, encoding_of
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.file_records import Depart
from intellwheels_schemas.messages import Leave
from intellwheels_server.service import joining, outbound
from intellwheels_server.service.arrival import Query
from intellwheels_server.service.error_replies import Fault
from intellwheels_server.service.roster import Member
from intellwheels_server.service.service_state import ServiceState


def handle_leave(service: ServiceState, query: Query) -> None:
    """Take a request to leave; it is answered when the agent has left."""
    if not query.name:
        if not query.has_wildcards:
            query.refuse(service.result("failed", f"leave/<agent>: {joining.NAME_EXPECTED}"))
        else:
            query.close()
        return
    try:
        # A query without bytes gets the same words as one without a Session.
        data = query.data or b"{}"
        leave = decode(Leave, data, encoding_of(query.encoding, data) if query.data else Encoding.JSON)
    except WireError as error:
        query.refuse(service.result("failed", error.text))
        return
    members = service.agents.roster.members(query.name)
    member = next((one for one in members if one.session == leave.session), None)
    if member is None:
        why = "no such agent here" if not members else "expected the session of the last join, got another"
        query.reply(service.result("not-found", f"agent '{query.name}': {why}"))
        return
    queue_leave(service, member, query)


def queue_leave(service: ServiceState, member: Member, query: Query | None = None) -> None:
    """Let a member leave as soon as changes may act, and do not wait for its answers; then answer the query."""
    for agent, kind in member.answers():
        service.pacing.barrier.cancel(agent, kind)
    last = service.last_queued
    if not isinstance(last, LeaveGroup):
        last = LeaveGroup(service)
        service.queue_change(last)
    last.leaves.append((member, query))


class LeaveGroup:
    """Leaves that wait next to each other in the queue of changes, and are taken together."""

    def __init__(self, service: ServiceState) -> None:
        self.leaves: list[tuple[Member, Query | None]] = []
        self._service = service

    def __call__(self, now: float) -> None:
        """Take them, in order: one member of each agent with one change of the bodies. Then answer them."""
        service, together = self._service, dict[str, Member]()
        for member, _ in self.leaves:
            if member.agent in together:
                _leave(service, together.values(), now)
                together = {}
            if member in service.agents.roster.members(member.agent):
                together[member.agent] = member
        _leave(service, together.values(), now)
        for _, query in self.leaves:
            if query is not None:
                query.reply(service.result("ok"))


def _leave(service: ServiceState, members: Collection[Member], now: float) -> None:
    """Let members of different agents leave."""
    if not members:
        return
    for member in members:
        if member.role == "body" and service.agents.roster.mind(member.agent) is not None:
            fault = Fault("not-joined", f"agent '{member.agent}' has no body any more, so its mind has left too")
            outbound.send_error(service, member.agent, fault, now)
    service.apply_all([Depart(agent=member.agent, role=member.role) for member in members])
    joining.remove_member(service, *members)
