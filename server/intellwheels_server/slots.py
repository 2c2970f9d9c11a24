"""What operators save and restore. A restored run is, to the hash, the one that was saved.

The world keeps the states itself, so a log that has a save and a restore gives the same hashes again. What the
service knows beside the world follows it: who is not seated as at the save is let go and joins again, the body of
who has left since stands until its agent is back, and a lease that is over ends.
"""

from __future__ import annotations

from typing import Any

import msgspec

from intellwheels_schemas.messages import Error, Restore
from intellwheels_server import membership
from intellwheels_server.admission import Seat, new_hex, same_body
from intellwheels_server.anew import begin_anew
from intellwheels_server.arrival import Ask
from intellwheels_server.desk import Desk
from intellwheels_server.fleet import Figure
from intellwheels_server.inputs import RestoreState, SaveState, TakeBody
from intellwheels_server.kernels.rows import SILENT, TAKEN


def save(desk: Desk, ask: Ask, _message: Any, now: float) -> None:
    """Keep the state; the reply names its slot, its tick and its hash."""
    kept = desk.state.kept
    slot = f"s{int(kept[-1].slot[1:]) + 1}" if kept else "s1"
    desk.apply(SaveState(slot=slot), now)
    ask.reply(msgspec.structs.replace(desk.result("ok"), slot=slot))


def restore(desk: Desk, ask: Ask, message: Any, now: float) -> None:
    """Go back to a kept state as a new run, paused or not as the run is now."""
    wanted: Restore = message
    before = desk.state
    outcome = desk.apply(RestoreState(slot=wanted.slot, run=new_hex()), now)
    if outcome.code != "ok":
        ask.reply(desk.result(outcome.code, outcome.text))
        return
    _seat(desk)
    _agree_on_users(desk, before.names, now)
    for agent in desk.bridges:
        desk.bridges[agent] = membership.bridge_of(desk, agent, now)
    begin_anew(desk, before, now)
    ask.reply(msgspec.structs.replace(desk.result("ok"), slot=wanted.slot))


def _seat(desk: Desk) -> None:
    """Let go who is not seated as at the save."""
    for agent in desk.roster.agents:
        figure = desk.state.fleet.figures.get(agent)
        for seat in desk.roster.seats(agent):
            if seat not in desk.roster.seats(agent) or (figure is not None and _fits(seat, figure)):
                continue
            _tell(desk, seat)
            membership.dismiss(desk, seat)
            if seat.embodies:
                membership.forget_body(desk, agent)


def _tell(desk: Desk, seat: Seat) -> None:
    """Tell who is let go: it hears nothing further, and would wait for ever."""
    error = Error(
        run=desk.state.run,
        tick=desk.state.tick,
        code="not-joined",
        text=f"the run was restored to a tick at which agent '{seat.agent}' was not here as it is now; join again",
    )
    desk.out.agent(seat.agent, "error", error, seat.encoding)


def _fits(seat: Seat, figure: Figure) -> bool:
    if seat.embodies:
        return same_body(figure.robot, seat.robot)
    return figure.mind_input == seat.robot.user_input


def _agree_on_users(desk: Desk, before: tuple[str, ...], now: float) -> None:
    """Let leases and silences be those of the state: no body is taken without a lease, none drives on unheard."""
    flags = desk.state.flags
    taken = {name for i, name in enumerate(desk.state.names) if flags[TAKEN, i]}
    for i, name in enumerate(desk.state.names):
        if not flags[SILENT, i]:
            desk.leases.hear(name, now)
    for name in {*before, *desk.state.names} - taken:
        desk.leases.free(name)
    for name in sorted(taken):
        if desk.leases.holder(name) is None:
            desk.apply(TakeBody(agent=name, on=False), now)
