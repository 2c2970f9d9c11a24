"""Saving and restoring a run. A restored run continues exactly as the saved one did, to the hash.

The world keeps the saved states itself, so that a log with a save and a restore gives the same hashes when it is run
again. The service then follows the restored world: a member that does not fit its body is removed and must join again,
a body whose agent has left stays until the agent returns, and a body is taken only while its lease lasts.
"""

from __future__ import annotations

import msgspec

from intellwheels_schemas.file_records import RestoreState, SaveState, TakeBody
from intellwheels_schemas.messages import Error, Restore
from intellwheels_server.service import body_places, joining
from intellwheels_server.service.arrival import Query
from intellwheels_server.service.new_run import begin_new_run
from intellwheels_server.service.roster import Member, new_hex, same_body
from intellwheels_server.service.service_state import ServiceState
from intellwheels_server.world.body_set import BodyModel
from intellwheels_server.world.kernels import rows


def save(service: ServiceState, query: Query) -> None:
    """Save the state; the reply names its slot, its tick and its hash."""
    saved = service.run.state.saved
    slot = f"s{int(saved[-1].slot[1:]) + 1}" if saved else "s1"
    service.apply(SaveState(slot=slot))
    query.reply(msgspec.structs.replace(service.result("ok"), slot=slot))


def restore(service: ServiceState, query: Query, message: Restore, now: float) -> None:
    """Return to a saved state as a new run, which is paused if the run is paused now."""
    before = service.run.state
    outcome = service.apply(RestoreState(slot=message.slot, run=new_hex()))
    if outcome.code != "ok":
        query.reply(service.result(outcome.code, outcome.text))
        return
    _remove_members_that_do_not_fit(service)
    _release_expired_bodies(service, before.names, now)
    for agent in service.agents.bridges:
        service.agents.bridges[agent] = body_places.bridge_status(service.run.state, agent, now)
    begin_new_run(service, before, now)
    query.reply(msgspec.structs.replace(service.result("ok"), slot=message.slot))


def _remove_members_that_do_not_fit(service: ServiceState) -> None:
    roster = service.agents.roster
    for agent in roster.agents:
        model = service.run.state.body_set.models.get(agent)
        for member in roster.members(agent):
            if member not in roster.members(agent) or (model is not None and _fits(member, model)):
                continue
            _send_not_joined(service, member)
            joining.remove_member(service, member)
            if member.has_body:
                joining.forget_body(service, agent)


def _send_not_joined(service: ServiceState, member: Member) -> None:
    """Tell a member that it is removed. Otherwise it would wait for measures forever."""
    state = service.run.state
    error = Error(
        run=state.run,
        tick=state.tick,
        code="not-joined",
        text=f"the run was restored to a tick at which agent '{member.agent}' had another body or none; join again",
    )
    service.publisher.outlet.agent(member.agent, "error", error, member.encoding)


def _fits(member: Member, model: BodyModel) -> bool:
    if member.has_body:
        return same_body(model.robot, member.robot)
    return model.mind_input == member.robot.user_input


def _release_expired_bodies(service: ServiceState, before: tuple[str, ...], now: float) -> None:
    """Match leases and users with the restored state.

    No body stays taken without a lease, and a body that a user was driving stops unless the user sends input again.

    Args:
        service: Its state is the restored one.
        before: The bodies before the restore.
        now: The current time, s.
    """
    state, leases = service.run.state, service.agents.leases
    taken = {name for i, name in enumerate(state.names) if state.flags[rows.TAKEN, i]}
    for i, name in enumerate(state.names):
        if not state.flags[rows.SILENT, i]:
            leases.expect_input(name, now)
    for name in {*before, *state.names} - taken:
        leases.release(name)
    for name in sorted(taken):
        if leases.active(name) is None:
            service.apply(TakeBody(agent=name, on=False))
