"""Liveliness tokens, and what is due because one did not come or has gone."""

from __future__ import annotations

from functools import partial

from intellwheels_schemas.file_records import Note, TakeBody
from intellwheels_server.service import joining, leaving
from intellwheels_server.service.arrival import Token
from intellwheels_server.service.connected_agents import WaitingJoin
from intellwheels_server.service.roster import Member, role_text
from intellwheels_server.service.service_state import ServiceState


def take_token(service: ServiceState, token: Token, now: float) -> None:
    """Note that a liveliness token appeared or disappeared."""
    member = service.agents.roster.token(token.agent, token.role, token.presence, token.present, now)
    if member is not None:
        code = "returned" if token.present else "lost"
        service.publisher.outlet.log_line(f"{code} agent={member.agent} role={member.role}")
        last = service.last_queued
        if not isinstance(last, PresenceNotes):
            last = PresenceNotes(service)
            service.queue_change(last)
        last.changed.append((member, token.present))
    # A flood of tokens of others must not look through all joins each time.
    if token.present and any(join.query.name == token.agent for join in service.agents.waiting_joins):
        _recheck_waiting_joins(service)


class PresenceNotes:
    """Changes of presence that wait next to each other in the queue of changes, and are noted together."""

    def __init__(self, service: ServiceState) -> None:
        self.changed: list[tuple[Member, bool]] = []
        self._service = service

    def __call__(self, _now: float) -> None:
        """Note them in the world, in order, as far as they are about members."""
        service, roster = self._service, self._service.agents.roster
        notes = [
            Note(code="returned" if present else "lost", agent=member.agent, text=role_text(member))
            for member, present in self.changed
            if member in roster.members(member.agent)
        ]
        if notes:
            service.apply_all(notes)


def _recheck_waiting_joins(service: ServiceState) -> None:
    agents = service.agents
    still: list[WaitingJoin] = []
    for join in agents.waiting_joins:
        if joining.has_token(agents.roster, join.query.name, join.robot):
            joining.queue_join(service, join.query, join.robot, join.encoding)
        else:
            still.append(join)
    agents.waiting_joins = still


def handle_deadlines(service: ServiceState, now: float) -> None:
    """Handle joins whose token did not come, members whose grace time is over, and leases that ran out."""
    agents, pacing = service.agents, service.pacing
    if agents.waiting_joins and agents.waiting_joins[0].until <= now:
        _recheck_waiting_joins(service)
    # A join without its token is refused. That changes nothing, so it need not wait for a barrier, and a flood of such
    # joins cannot pile up there.
    for join in [waiting for waiting in agents.waiting_joins if waiting.until <= now]:
        agents.waiting_joins.remove(join)
        joining.join(service, join.query, join.robot, join.encoding, now)
    for member in agents.roster.lost(now, service.options.grace):
        member.absent_since = None  # so that it is handled once
        if pacing.strict and pacing.lockstep and member.answers() and not service.is_stopped():
            service.end_for_missed_answer(member.agent)
        leaving.queue_leave(service, member)
    for agent in agents.leases.take_expired(now):
        service.queue_change(partial(_release, service, agent))


def _release(service: ServiceState, agent: str, _now: float) -> None:
    if agent in service.run.state.body_set.models and service.agents.leases.active(agent) is None:
        service.apply(TakeBody(agent=agent, on=False))
