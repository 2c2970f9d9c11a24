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
from intellwheels_server.arrival import Ask
from intellwheels_server.desk import Desk
from intellwheels_server.hiding import nominal
from intellwheels_server.parts import cut


def put_measures(desk: Desk, agent: str) -> None:
    """Put an agent its measures, if anybody of it listens."""
    encoding = desk.encodings.get(agent)
    if encoding is not None:
        desk.out.agent(agent, "measures", world.measures(desk.state, agent), encoding)


def put_all_measures(desk: Desk) -> None:
    """Put everybody their measures."""
    state, put = desk.state, desk.out.agent
    for agent, encoding in desk.encodings.items():
        put(agent, "measures", world.measures(state, agent), encoding)


def put_powers(desk: Desk, closed: int) -> None:
    """Put real chairs the powers of the tick whose barrier has closed."""
    for agent in desk.bridges:
        power = world.power_in_force(desk.state, agent)
        put_power(desk, agent, msgspec.structs.replace(power, tick=closed))


def put_power(desk: Desk, agent: str, power: PowerInForce) -> None:
    """Put a real chair a power."""
    seat = desk.roster.body(agent)
    if seat is not None:
        desk.out.agent(agent, "power", power, seat.encoding)


def rest_real(desk: Desk, now: float) -> None:
    """While nothing moves, real chairs are told so ten times a second."""
    if not desk.bridges or not desk.stands() or now < desk.idle_power_at:
        return
    desk.idle_power_at = now + 0.1
    run, tick = desk.state.run, desk.state.tick
    for agent in desk.bridges:
        if is_hardware(desk, agent):
            power = PowerInForce(run=run, tick=tick, left_motor=0.0, right_motor=0.0, state="paused")
            put_power(desk, agent, power)


def publish(desk: Desk, now: float) -> None:
    """Put the state and the clock."""
    desk.cadence.done(now)
    for part in parts_of(desk):
        desk.out.state(part)
    desk.out.clock(clock_of(desk, now))


def parts_of(desk: Desk) -> list[WorldState]:
    """Return the state in parts that each fit a put; none where the truth is hidden."""
    if desk.options.hide_truth:
        return []
    state = desk.state
    return cut(state.run, state.tick, state.time, world.entities(state))


def publish_map(desk: Desk) -> None:
    """Put which map there is."""
    state = desk.state
    floor = state.setup.floor
    info = MapInfo(run=state.run, tick=state.tick, name=floor.name, revision=state.revision, hash=world.map_hash(floor))
    desk.out.map(info)


def body_of(desk: Desk, agent: str) -> Body:
    """Return a body as accepted. It must be here."""
    seat = desk.roster.body(agent)
    roles: tuple[Role, ...] = tuple(each.role for each in desk.roster.seats(agent))
    figure = desk.state.fleet.figures[agent]
    robot = figure.robot
    if figure.mind_input:  # a mind that joined apart takes what it takes, whatever the body's document says
        words = dict.fromkeys((*robot.user_input, *figure.mind_input))
        robot = msgspec.structs.replace(robot, user_input=tuple(words))
    if desk.played is not None and robot.instance is not None:  # nobody sits here, but somebody did
        roles = (robot.role,)
    return Body(
        run=desk.state.run,
        tick=desk.state.tick,
        owner=seat.instance if seat and seat.instance else None,
        roles=roles,
        robot=nominal(robot) if desk.options.hide_truth else robot,
    )


def clock_of(desk: Desk, now: float) -> Clock:
    """Return how far the run is."""
    state = desk.state
    return Clock(
        run=state.run,
        tick=state.tick,
        time=state.time,
        state=_clock_state(desk, now),
        pace=desk.options.pace,
        speed=desk.metronome.speed,
        factor=desk.tachometer.factor(now),
        late=desk.metronome.late,
        hash=desk.digest(),
        stamp=desk.wall(),
        waiting=_awaited(desk, now),
        last=None if desk.played is None else desk.played.last,
    )


def _clock_state(desk: Desk, now: float) -> ClockState:
    if desk.state.ended if desk.played is None else desk.played.over:
        return "ended"
    if desk.held:
        return "waiting"
    if desk.paused and desk.steps is None:
        return "paused"
    if desk.lockstep and (not desk.members or desk.barrier.stalled(now)):
        return "waiting"
    return "running"


def _awaited(desk: Desk, now: float) -> tuple[str, ...]:
    if desk.held:
        return tuple(desk.missing())
    if desk.lockstep and desk.open and desk.barrier.stalled(now):
        return desk.barrier.awaited
    return ()


def is_hardware(desk: Desk, agent: str) -> bool:
    """Return whether an agent has a body of real hardware, not one in another simulation."""
    seat = desk.roster.body(agent)
    return seat is not None and seat.real and not seat.simulated_hardware


def ask_what_is(desk: Desk, ask: Ask, now: float) -> None:
    """Answer who asks how things are: the map, the clock, events, bodies, the state."""
    match ask.topic:
        case "map":
            ask.reply(desk.state.setup.floor)
        case "clock":
            ask.reply(clock_of(desk, now))
        case "event":
            ask_events(desk, ask)
        case "body":
            ask.replies({name: body_of(desk, name) for name in desk.state.names if ask.matches(name)})
        case "state":
            parts = parts_of(desk)
            ask.replies({str(part.part): part for part in parts if ask.matches(str(part.part))})


def ask_events(desk: Desk, ask: Ask) -> None:
    """Answer with the events kept from `since` on."""
    since = ask.parameters.get("since", "0")
    if not (since.isascii() and since.isdigit() and len(since) <= 16):
        ask.refuse(desk.result("failed", f"event?since: expected a number, got {since[:40]!r}"))
        return
    ask.reply(desk.ring.since(int(since), desk.state.run))
