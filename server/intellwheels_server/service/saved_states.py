"""What operators save and restore. A restored run is, to the hash, the one that was saved.

The world keeps the states itself, so a log that has a save and a restore gives the same hashes again. What the
service knows beside the world follows it: who is not seated as at the save is let go and joins again, the body of
who has left since stands until its agent is back, and a lease that is over ends.
"""

from __future__ import annotations

from typing import Any

import msgspec

from intellwheels_schemas.messages import Error, Restore
from intellwheels_server.service import joining
from intellwheels_server.service.arrival import Ask
from intellwheels_server.service.new_run import begin_new_run
from intellwheels_server.service.roster import Seat, new_hex, same_body
from intellwheels_server.service.service_state import ServiceState
from intellwheels_server.world.body_set import BodyModel
from intellwheels_server.world.inputs import RestoreState, SaveState, TakeBody
from intellwheels_server.world.kernels import rows


def save(service: ServiceState, ask: Ask, _message: Any, now: float) -> None:
    """Keep the state; the reply names its slot, its tick and its hash."""
    kept = service.state.kept
    slot = f"s{int(kept[-1].slot[1:]) + 1}" if kept else "s1"
    service.apply(SaveState(slot=slot), now)
    ask.reply(msgspec.structs.replace(service.result("ok"), slot=slot))


def restore(service: ServiceState, ask: Ask, message: Any, now: float) -> None:
    """Go back to a kept state as a new run, paused or not as the run is now."""
    wanted: Restore = message
    before = service.state
    outcome = service.apply(RestoreState(slot=wanted.slot, run=new_hex()), now)
    if outcome.code != "ok":
        ask.reply(service.result(outcome.code, outcome.text))
        return
    _seat(service)
    _agree_on_users(service, before.names, now)
    for agent in service.bridges:
        service.bridges[agent] = joining.bridge_of(service, agent, now)
    begin_new_run(service, before, now)
    ask.reply(msgspec.structs.replace(service.result("ok"), slot=wanted.slot))


def _seat(service: ServiceState) -> None:
    """Let go who is not seated as at the save."""
    for agent in service.roster.agents:
        figure = service.state.body_set.figures.get(agent)
        for seat in service.roster.seats(agent):
            if seat not in service.roster.seats(agent) or (figure is not None and _fits(seat, figure)):
                continue
            _tell(service, seat)
            joining.dismiss(service, seat)
            if seat.embodies:
                joining.forget_body(service, agent)


def _tell(service: ServiceState, seat: Seat) -> None:
    """Tell who is let go: it hears nothing further, and would wait for ever."""
    error = Error(
        run=service.state.run,
        tick=service.state.tick,
        code="not-joined",
        text=f"the run was restored to a tick at which agent '{seat.agent}' was not here as it is now; join again",
    )
    service.out.agent(seat.agent, "error", error, seat.encoding)


def _fits(seat: Seat, figure: BodyModel) -> bool:
    if seat.embodies:
        return same_body(figure.robot, seat.robot)
    return figure.mind_input == seat.robot.user_input


def _agree_on_users(service: ServiceState, before: tuple[str, ...], now: float) -> None:
    """Let leases and silences be those of the state: no body is taken without a lease, none drives on unheard."""
    flags = service.state.flags
    taken = {name for i, name in enumerate(service.state.names) if flags[rows.TAKEN, i]}
    for i, name in enumerate(service.state.names):
        if not flags[rows.SILENT, i]:
            service.leases.hear(name, now)
    for name in {*before, *service.state.names} - taken:
        service.leases.free(name)
    for name in sorted(taken):
        if service.leases.holder(name) is None:
            service.apply(TakeBody(agent=name, on=False), now)
