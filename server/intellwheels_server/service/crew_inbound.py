"""The actions of crews: each of them is checked and kept as if its agent had sent it alone."""

from __future__ import annotations

from collections.abc import Sequence
from operator import attrgetter
from typing import Final

from intellwheels_schemas.codec import Encoding, encoding_of
from intellwheels_schemas.crew_messages import WrongItem, read_actions, read_known_actions
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.explain import shown
from intellwheels_schemas.messages import AgentActions
from intellwheels_server.service import inbound
from intellwheels_server.service.arrival import Put
from intellwheels_server.service.command_ages import has_command
from intellwheels_server.service.crews import Crew
from intellwheels_server.service.error_replies import DELETED, Fault, flooding
from intellwheels_server.service.outbound import send_crew_error, send_error
from intellwheels_server.service.service_state import ServiceState

_MOTORS: Final = attrgetter("left_motor"), attrgetter("right_motor")


def take_crew_put(service: ServiceState, put: Put, now: float) -> None:
    """Take the actions of a crew; it gets an error if something is wrong with them.

    A wrong message of one agent does not affect the others, and nobody else hears of an agent that is not the crew's.
    """
    name = put.agent
    fault: Fault | None = None
    # No agent's name has a slash.
    if not service.message_limit.admit(f"crew/{name}", service.run.state.tick, now):
        fault = flooding("CrewActions")
        fault = fault._replace(text=f"{fault.text}; one message can have the actions of all agents of a crew")
    elif put.size > len(put.data):
        fault = Fault("too-long", f"CrewActions: expected fewer bytes, got {put.size}")
    elif (crew := service.agents.crews.named.get(name)) is None:
        fault = Fault("not-joined", "CrewActions: expected a crew that has joined, got one that has not", "CrewActions")
    else:
        try:
            encoding = encoding_of(put.encoding, put.data)
            if encoding is not Encoding.JSON or not _take_known(service, crew, put.data):
                _take_items(service, crew, read_actions(name, put.data, encoding), now)
        except WireError as error:
            fault = Fault(error.code, error.text, error.where or None)
    if fault is not None:
        send_crew_error(service, name, fault, now)


def _take_known(service: ServiceState, crew: Crew, data: bytes) -> bool:
    """Take actions of which nothing is wrong and none is special, all at once; return whether they are such."""
    state = service.run.state
    if service.pacing.lockstep:  # each may be an answer or repeat one
        return False
    actions = read_known_actions(crew.name, data, state.run, state.tick, crew.sessions)
    if actions is None:
        return False
    if any(None in map(motor, actions.values()) for motor in _MOTORS) or not service.latch.act_first(actions):
        return False
    service.command_ages.take_punctual(actions)
    return True


def _take_items(service: ServiceState, crew: Crew, items: Sequence[AgentActions | WrongItem], now: float) -> None:
    members, state, pacing = crew.members, service.run.state, service.pacing
    act, note_command = service.latch.act, service.command_ages.take
    run, tick, lockstep, say_limit = state.run, state.tick, pacing.lockstep, state.setup.say_limit
    for index, item in enumerate(items):
        member = members.get(item.agent)
        if isinstance(item, WrongItem):
            fault = Fault(item.error.code, item.error.text, item.error.where or None)
            if member is None:
                send_crew_error(service, crew.name, fault, now, item.agent or None)
            else:
                send_error(service, item.agent, fault, now)
            continue
        if member is None:
            _report_stranger(service, crew, item, index, now)
            continue
        agent = item.agent
        if (
            not lockstep
            and item.session == member.session
            and item.tick == tick
            and item.run == run
            and not item.leave
            and (item.say is None or len(item.say) <= say_limit)
        ):
            # Nearly all of them; the rest has its errors found by the same checks as the actions of other agents.
            if has_command(item):
                note_command(agent, item, tick)
            found = act(agent, item)
        elif pacing.barrier_open and pacing.barrier.repeats(agent, "actions", item):
            continue
        else:
            found = inbound.take_actions(service, agent, item, item, now)
        if found is not None:
            send_error(service, agent, found, now)


def _report_stranger(service: ServiceState, crew: Crew, item: AgentActions, index: int, now: float) -> None:
    """Tell a crew, and nobody else, that it acted for an agent that did not join with it."""
    if service.agents.deleted.get(item.agent) == item.session:
        send_crew_error(service, crew.name, DELETED, now, item.agent)
        return
    where = f"CrewActions.Actions[{index}].Agent"
    text = f"{where}: expected an agent that joined with crew '{crew.name}', got {shown(item.agent)}"
    send_crew_error(service, crew.name, Fault("not-joined", text, where, item.seq), now, item.agent)
