"""What the service tells: measures and powers to agents, state, clock, map and bodies to whoever looks."""

from __future__ import annotations

import msgspec

from intellwheels_schemas.messages import (
    Body,
    Clock,
    ClockState,
    MapInfo,
    PowerInForce,
    Role,
    WorldState,
)
from intellwheels_server import world
from intellwheels_server.service.arrival import Ask
from intellwheels_server.service.service_state import ServiceState
from intellwheels_server.service.state_parts import cut
from intellwheels_server.service.truth_filter import nominal


def put_measures(service: ServiceState, agent: str) -> None:
    """Put an agent its measures, if anybody of it listens."""
    encoding = service.encodings.get(agent)
    if encoding is not None:
        service.out.agent(agent, "measures", world.measures(service.state, agent), encoding)


def put_all_measures(service: ServiceState) -> None:
    """Put everybody their measures."""
    state, put = service.state, service.out.agent
    for agent, encoding in service.encodings.items():
        put(agent, "measures", world.measures(state, agent), encoding)


def put_powers(service: ServiceState, closed: int) -> None:
    """Put real chairs the powers of the tick whose barrier has closed."""
    for agent in service.bridges:
        power = world.power_in_force(service.state, agent)
        put_power(service, agent, msgspec.structs.replace(power, tick=closed))


def put_power(service: ServiceState, agent: str, power: PowerInForce) -> None:
    """Put a real chair a power."""
    seat = service.roster.body(agent)
    if seat is not None:
        service.out.agent(agent, "power", power, seat.encoding)


def rest_real(service: ServiceState, now: float) -> None:
    """While nothing moves, real chairs are told so ten times a second."""
    if not service.bridges or not service.stands() or now < service.idle_power_at:
        return
    service.idle_power_at = now + 0.1
    run, tick = service.state.run, service.state.tick
    for agent in service.bridges:
        if is_hardware(service, agent):
            power = PowerInForce(run=run, tick=tick, left_motor=0.0, right_motor=0.0, state="paused")
            put_power(service, agent, power)


def publish(service: ServiceState, now: float) -> None:
    """Put the state and the clock."""
    service.cadence.done(now)
    for part in parts_of(service):
        service.out.state(part)
    service.out.clock(clock_of(service, now))


def parts_of(service: ServiceState) -> list[WorldState]:
    """Return the state in parts that each fit a put; none where the truth is hidden."""
    if service.options.hide_truth:
        return []
    state = service.state
    return cut(state.run, state.tick, state.time, world.entities(state))


def publish_map(service: ServiceState) -> None:
    """Put which map there is."""
    state = service.state
    floor = state.setup.floor
    info = MapInfo(run=state.run, tick=state.tick, name=floor.name, revision=state.revision, hash=world.map_hash(floor))
    service.out.map(info)


def body_of(service: ServiceState, agent: str) -> Body:
    """Return a body as accepted, with the pose where it joined as its `Position`. It must be here."""
    seat = service.roster.body(agent)
    roles: tuple[Role, ...] = tuple(each.role for each in service.roster.seats(agent))
    figure = service.state.body_set.figures[agent]
    # Sensors mounted on `start` stay there, so whoever draws them must know it, also of a body that joined at a Place.
    robot = msgspec.structs.replace(figure.robot, position=figure.start)
    if figure.mind_input:  # a mind that joined apart takes what it takes, whatever the body's document says
        words = dict.fromkeys((*robot.user_input, *figure.mind_input))
        robot = msgspec.structs.replace(robot, user_input=tuple(words))
    if service.played is not None and robot.instance is not None:  # nobody sits here, but somebody did
        roles = (robot.role,)
    return Body(
        run=service.state.run,
        tick=service.state.tick,
        owner=seat.instance if seat and seat.instance else None,
        roles=roles,
        robot=nominal(robot) if service.options.hide_truth else robot,
    )


def clock_of(service: ServiceState, now: float) -> Clock:
    """Return how far the run is."""
    state = service.state
    return Clock(
        run=state.run,
        tick=state.tick,
        time=state.time,
        state=_clock_state(service, now),
        pace=service.options.pace,
        speed=service.metronome.speed,
        factor=service.tachometer.factor(now),
        late=service.metronome.late,
        hash=service.digest(),
        stamp=service.wall(),
        waiting=_awaited(service, now),
        last=None if service.played is None else service.played.last,
    )


def _clock_state(service: ServiceState, now: float) -> ClockState:
    if service.state.ended if service.played is None else service.played.over:
        return "ended"
    if service.held:
        return "waiting"
    if service.paused and service.steps is None:
        return "paused"
    if service.lockstep and (not service.members or service.barrier.stalled(now)):
        return "waiting"
    return "running"


def _awaited(service: ServiceState, now: float) -> tuple[str, ...]:
    if service.held:
        return tuple(service.missing())
    if service.lockstep and service.open and service.barrier.stalled(now):
        return service.barrier.awaited
    return ()


def is_hardware(service: ServiceState, agent: str) -> bool:
    """Return whether an agent has a body of real hardware, not one in another simulation."""
    seat = service.roster.body(agent)
    return seat is not None and seat.real and not seat.simulated_hardware


def ask_what_is(service: ServiceState, ask: Ask, now: float) -> None:
    """Answer who asks how things are: the map, the clock, events, bodies, the state."""
    match ask.topic:
        case "map":
            ask.reply(service.state.setup.floor)
        case "clock":
            ask.reply(clock_of(service, now))
        case "event":
            ask_events(service, ask)
        case "body":
            ask.replies({name: body_of(service, name) for name in service.state.names if ask.matches(name)})
        case "state":
            parts = parts_of(service)
            ask.replies({str(part.part): part for part in parts if ask.matches(str(part.part))})


def ask_events(service: ServiceState, ask: Ask) -> None:
    """Answer with the events kept from `since` on."""
    since = ask.parameters.get("since", "0")
    if not (since.isascii() and since.isdigit() and len(since) <= 16):
        ask.refuse(service.result("failed", f"event?since: expected a number, got {since[:40]!r}"))
        return
    ask.reply(service.ring.since(int(since), service.state.run))
