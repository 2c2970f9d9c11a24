"""Messages that the service sends: measures and powers to agents; state, clock, map and bodies to everybody."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Final

import msgspec
import numpy as np

from intellwheels_schemas.codec import Encoding, encode
from intellwheels_schemas.crew_messages import crew_messages
from intellwheels_schemas.messages import (
    Body,
    Clock,
    ClockState,
    CrewError,
    Entity,
    Error,
    MapInfo,
    PowerInForce,
    Role,
    WorldState,
)
from intellwheels_schemas.metal_codes import code_of, power_line
from intellwheels_server import world
from intellwheels_server.service.arrival import Query
from intellwheels_server.service.error_replies import Fault
from intellwheels_server.service.publisher import Publisher
from intellwheels_server.service.roster import Roster
from intellwheels_server.service.run_state import RunState
from intellwheels_server.service.sensor_budget import costliest, total_rays
from intellwheels_server.service.service_state import ServiceState
from intellwheels_server.service.state_parts import split_state, split_written
from intellwheels_server.service.truth_filter import nominal
from intellwheels_server.world import State
from intellwheels_server.world.state_writer import WrittenState

WHERE_LIMIT: Final = 200
"""Characters of the place in an error."""
TEXT_LIMIT: Final = 1000
"""Characters of the text of an error."""
IDLE_POWER_INTERVAL: Final = 0.1
"""Seconds between two powers to a real chair while the run is stopped."""

# ------------------------------------------------------------ to agents


def put_measures(service: ServiceState, agent: str) -> None:
    """Put the measures of an agent, if one of its members gets any."""
    encoding = service.agents.encodings.get(agent)
    if encoding is not None:
        measures = world.measures(service.run.state, agent)
        service.publisher.outlet.put_measures(agent, encode(measures, encoding), encoding)


def put_measures_again(service: ServiceState, agents: Iterable[str]) -> None:
    """Put the measures of some agents once more; those of a crew together."""
    of_crews: dict[str, list[str]] = {}
    for agent in agents:
        crew = service.agents.crews.of(agent)
        if crew is None:
            put_measures(service, agent)
        else:
            of_crews.setdefault(crew.name, []).append(agent)
    for name, members in of_crews.items():
        put_crew_measures(service, name, members)


def put_crew_measures(service: ServiceState, crew: str, agents: Sequence[str]) -> None:
    """Put the measures of agents of a crew."""
    state, outlet, known = service.run.state, service.publisher.outlet, service.agents.crews.named[crew]
    items = known.write(state, agents)
    for data in crew_messages("Measures", crew, items, known.encoding):
        outlet.crew_measures(crew, data, known.encoding)


def put_all_measures(service: ServiceState) -> None:
    """Put the measures of every agent."""
    state, publisher = service.run.state, service.publisher
    put = publisher.outlet.put_measures
    for encoding, agents in service.agents.by_encoding().items():
        for agent, data in zip(agents, publisher.writers[encoding].write(state, agents), strict=True):
            put(agent, data, encoding)
    for name, crew in service.agents.crews.named.items():
        put_crew_measures(service, name, crew.names)


def send_error(service: ServiceState, agent: str, fault: Fault, now: float) -> None:
    """Send an agent an error about one of its messages, unless it got too many errors recently."""
    _send_error(service, agent, fault, service.error_limit.admit(agent, agent in service.agents.roster, now))


def send_unasked_error(service: ServiceState, agent: str, fault: Fault, now: float) -> None:
    """Send an error about a message that the agent's own program may not have sent, so send it seldom."""
    _send_error(service, agent, fault, service.unasked_limit.admit(agent, agent in service.agents.roster, now))


def _send_error(service: ServiceState, agent: str, fault: Fault, suppressed: int | None) -> None:
    if suppressed is None:
        return
    roster = service.agents.roster
    member = roster.mind(agent) or roster.body(agent)
    error = _error_of(service, fault, suppressed)
    service.publisher.outlet.agent(agent, "error", error, member.encoding if member else Encoding.JSON)
    crew = service.agents.crews.of(agent)
    if crew is not None:
        put_crew_error(service, crew.name, error, agent)


def send_crew_error(service: ServiceState, crew: str, fault: Fault, now: float, agent: str | None = None) -> None:
    """Send a crew an error about one of its messages, unless it got too many errors recently.

    Args:
        service: The service.
        crew: The crew.
        fault: What is wrong.
        now: The current time, s.
        agent: The name in the message that the error is about, if it is about one.
    """
    # No agent's name has a slash.
    suppressed = service.error_limit.admit(f"crew/{crew}", crew in service.agents.crews.named, now)
    if suppressed is not None:
        put_crew_error(service, crew, _error_of(service, fault, suppressed), agent)


def put_crew_error(service: ServiceState, crew: str, error: Error, agent: str | None) -> None:
    """Send a crew an error, whatever it got recently; `agent` is the one that it is about, if it is about one."""
    known = service.agents.crews.named.get(crew)
    fields = {name: getattr(error, name) for name in Error.__struct_fields__}
    encoding = known.encoding if known is not None else Encoding.JSON
    service.publisher.outlet.crew_error(crew, CrewError(**fields, agent=agent), encoding)


def _error_of(service: ServiceState, fault: Fault, suppressed: int) -> Error:
    state = service.run.state
    return Error(
        run=state.run,
        tick=state.tick,
        code=fault.code,
        where=fault.where[:WHERE_LIMIT] if fault.where else None,
        seq=fault.seq,
        suppressed=suppressed,
        text=fault.text[:TEXT_LIMIT],
    )


def put_powers(service: ServiceState, tick: int) -> None:
    """Put the powers of all real chairs, in force in the step from a tick."""
    for agent in service.agents.bridges:
        power = world.power_in_force(service.run.state, agent)
        _put_power(service, agent, msgspec.structs.replace(power, tick=tick))


def put_zero_powers(service: ServiceState) -> None:
    """Put power 0 for all real chairs."""
    for agent in service.agents.bridges:
        _put_power(service, agent, _zero_power(service.run.state))


def put_idle_powers(service: ServiceState, now: float) -> None:
    """Put power 0 for all chairs of real hardware, ten times a second while the run is stopped."""
    bridges, publisher = service.agents.bridges, service.publisher
    if not bridges or not service.is_stopped() or now < publisher.idle_power_at:
        return
    publisher.idle_power_at = now + IDLE_POWER_INTERVAL
    for agent in bridges:
        if is_hardware(service.agents.roster, agent):
            _put_power(service, agent, _zero_power(service.run.state))


def _zero_power(state: State) -> PowerInForce:
    return PowerInForce(run=state.run, tick=state.tick, left_motor=0.0, right_motor=0.0, state="paused")


def _put_power(service: ServiceState, agent: str, power: PowerInForce) -> None:
    member = service.agents.roster.body(agent)
    if member is None:
        return
    service.publisher.power_seq += 1
    power = msgspec.structs.replace(power, seq=service.publisher.power_seq)
    power = msgspec.structs.replace(power, code=code_of(member.key, power_line(power)))
    service.publisher.outlet.agent(agent, "power", power, member.encoding)


def is_hardware(roster: Roster, agent: str) -> bool:
    """Return whether the body of an agent is real hardware, not a chair of another simulation."""
    member = roster.body(agent)
    return member is not None and member.real and not member.simulated_hardware


# ------------------------------------------------------------ to everybody


def publish(service: ServiceState, now: float) -> None:
    """Put the state and the clock."""
    service.publisher.schedule.mark_published(now)
    _put_state(service, now, always=True)
    service.publisher.outlet.clock(_clock(service, now))


def publish_due(service: ServiceState, now: float) -> None:
    """Put the clock if it is due, and the state with it unless it was published and nothing has moved since."""
    publisher = service.publisher
    if publisher.schedule.take_due(now):
        _put_state(service, now, always=False)
        publisher.outlet.clock(_clock(service, now))


def _put_state(service: ServiceState, now: float, *, always: bool) -> None:
    """Put the state, unless nobody reads it or, if not `always`, it was published and nothing has moved since."""
    publisher, state = service.publisher, service.run.state
    if publisher.hide_truth or not publisher.outlet.is_state_read():
        return
    written = _written(service)
    shown: object
    if written is None:
        parts = _state_parts(service)
        shown, data = [part.entity for part in parts], [encode(part) for part in parts]
    else:
        shown, data = written.data, split_written(state.run, state.tick, state.shown_time, written)
    shown = state.run, shown
    if always:
        publisher.schedule.mark_state(shown, now)
    elif not publisher.schedule.take_state(shown, now):
        return
    for part, each in enumerate(data):
        publisher.outlet.put_state(part, each)


def _written(service: ServiceState) -> WrittenState | None:
    """Return all bodies as bytes with what the service counts about them, or None if they cannot be written so."""
    state = service.run.state
    if service.playback is not None:
        return service.publisher.state_writer.write(state, {}, np.full((2, len(state.names)), np.nan))
    ages, paths = service.command_ages.means(), service.travelled.columns(state.names)
    # A body that was at no step has not travelled.
    return service.publisher.state_writer.write(state, ages, np.nan_to_num(paths, nan=0.0))


def publish_map(run: RunState, publisher: Publisher) -> None:
    """Put the name and hash of the current map."""
    state, floor = run.state, run.state.setup.floor
    info = MapInfo(run=state.run, tick=state.tick, name=floor.name, revision=state.revision, hash=world.map_hash(floor))
    publisher.outlet.map(info)


def publish_body(service: ServiceState, agent: str) -> None:
    """Put a body as accepted. It must be in the world."""
    service.publisher.outlet.body(agent, body_of(service, agent))


def body_of(service: ServiceState, agent: str) -> Body:
    """Return a body as accepted, with the pose where it joined as its `Position`. It must be in the world."""
    state, roster = service.run.state, service.agents.roster
    owner = roster.body(agent)
    roles: tuple[Role, ...] = tuple(member.role for member in roster.members(agent))
    model = state.body_set.models[agent]
    # Sensors mounted on `start` stay at that pose, so viewers need it, even for a body that joined at a Place.
    # The robot may have come with another crew than the one that has the agent now.
    crew = service.agents.crews.of(agent)
    robot = msgspec.structs.replace(model.robot, position=model.start, crew=crew.name if crew is not None else None)
    if model.mind_input:  # a mind in another process takes this input too
        inputs = dict.fromkeys((*robot.user_input, *model.mind_input))
        robot = msgspec.structs.replace(robot, user_input=tuple(inputs))
    if service.playback is not None and robot.instance is not None:  # the agent is not here now, but it was
        roles = (robot.role,)
    return Body(
        run=state.run,
        tick=state.tick,
        owner=owner.instance if owner and owner.instance else None,
        roles=roles,
        robot=nominal(robot) if service.publisher.hide_truth else robot,
    )


def _state_parts(service: ServiceState) -> list[WorldState]:
    """Return the state in parts that each fit into a message; none if the truth is hidden."""
    if service.publisher.hide_truth:
        return []
    state = service.run.state
    entities = world.entities(state)
    if service.playback is None:
        entities = tuple(_counted(entities, service))
    return split_state(state.run, state.tick, state.shown_time, entities)


def _counted(entities: Iterable[Entity], service: ServiceState) -> Iterator[Entity]:
    """Yield bodies with what the service counts about them."""
    ages, travelled = service.command_ages.means(), service.travelled.all()
    for entity in entities:
        length, turned = travelled.get(entity.name, (0.0, 0.0))
        age = ages.get(entity.name, 0.0)
        yield msgspec.structs.replace(entity, command_age=age, travelled=length, turned=turned)


def _clock(service: ServiceState, now: float) -> Clock:
    state, pacing = service.run.state, service.pacing
    load = round(pacing.busy_share.value(now), 3)
    # The two are measured over different seconds.
    moving = min(load, round(pacing.world_share.value(now), 3))
    return Clock(
        run=state.run,
        tick=state.tick,
        time=state.shown_time,
        state=_clock_state(service, now),
        pace=pacing.pace,
        speed=pacing.metronome.speed,
        factor=round(pacing.real_time_factor.value(now), 6),
        late=pacing.metronome.late,
        load=load,
        world=moving,
        wire=round(load - moving, 3) if service.playback is None else 0.0,
        rays=total_rays(state),
        costliest=costliest(state),
        flooding=_flooding(service, now),
        hash=service.run.digest(),
        stamp=service.publisher.unix_time(),
        waiting=_awaited_agents(service, now),
        last=None if service.playback is None else service.playback.last_tick,
    )


def _flooding(service: ServiceState, now: float) -> str | None:
    """Return the agent or the crew of whose messages most were refused; a stray message may have no valid name."""
    sender = service.message_limit.most_refused(now)
    return None if sender is None else sender.rpartition("/")[2] or None


def report_lateness(service: ServiceState, is_late: bool, now: float) -> None:
    """Log that ticks begin to be late, with what costs, or that they are on time again. Call it for each tick."""
    change = service.pacing.late_watch.add(is_late)
    if change is None:
        return
    clock = _clock(service, now)
    costs = f" load={clock.load:g} world={clock.world:g} wire={clock.wire:g}"
    costs += f" costliest={clock.costliest}" if clock.costliest else ""
    costs += f" flooding={clock.flooding}" if clock.flooding else ""
    what = f"ticks are {change}" if change == "late" else f"ticks are {change} again"
    service.publisher.outlet.log_line(f"{what} tick={clock.tick} late={clock.late}{costs if change == 'late' else ''}")


def _clock_state(service: ServiceState, now: float) -> ClockState:
    pacing, playback = service.pacing, service.playback
    if service.run.state.ended if playback is None else playback.at_end:
        return "ended"
    if pacing.waiting_to_start:
        return "waiting"
    if pacing.paused and pacing.steps is None:
        return "paused"
    if pacing.lockstep and (not pacing.answers or pacing.barrier.stalled(now)):
        return "waiting"
    return "running"


def _awaited_agents(service: ServiceState, now: float) -> tuple[str, ...]:
    pacing = service.pacing
    if pacing.waiting_to_start:
        return tuple(service.missing_agents())
    if pacing.lockstep and pacing.barrier_open and pacing.barrier.stalled(now):
        return pacing.barrier.awaited
    return ()


# ------------------------------------------------------------ answers to queries


def answer_query(service: ServiceState, query: Query, now: float) -> None:
    """Answer a query for the map, the clock, the events, the bodies or the state."""
    run, publisher = service.run, service.publisher
    match query.topic:
        case "map":
            query.reply(run.state.setup.floor)
        case "clock":
            query.reply(_clock(service, now))
        case "event":
            _answer_events(run, publisher, query)
        case "body":
            query.reply_each({name: body_of(service, name) for name in run.state.names if query.matches(name)})
        case "state":
            parts = {str(part.part): part for part in _state_parts(service)}
            query.reply_each({name: part for name, part in parts.items() if query.matches(name)})


def _answer_events(run: RunState, publisher: Publisher, query: Query) -> None:
    since = query.parameters.get("since", "0")
    if not (since.isascii() and since.isdigit() and len(since) <= 16):
        query.refuse(run.result("failed", f"event?since: expected a number, got {since[:40]!r}"))
        return
    query.reply(publisher.events.since(int(since), run.state.run))
