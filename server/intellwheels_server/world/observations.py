"""What of a state is told: measures to an agent, true states to viewers, powers to real chairs."""

from __future__ import annotations

import math
from typing import Any, Final

import msgspec

from intellwheels_schemas.messages import Entity, Measures, MotorState, PowerInForce, Sensors
from intellwheels_schemas.rules import SENSOR_KINDS
from intellwheels_server.world.hearing import heard_by
from intellwheels_server.world.kernels import rows
from intellwheels_server.world.sensors import readings
from intellwheels_server.world.state import BodyStatus, State

SAY_SHOWN: Final = 3.0
"""Simulated seconds for which the last say stands in the world's state."""

_SILENT_STATUS: Final = BodyStatus()


def measures(state: State, agent: str) -> Measures:
    """Return what an agent perceives now.

    Raises:
        KeyError: No such body is here.
    """
    body_set = state.body_set
    i = body_set.index[agent]
    figure = body_set.figures[agent]
    return Measures(
        run=state.run,
        tick=state.tick,
        time=state.time,
        collision=bool(state.flags[rows.COLLISION, i]),
        contact=bool(state.numbers[rows.TOUCHING, i]),
        sensors=_sensors(state, agent, i),
        message=heard_by(state, agent) if state.heard else (),
        user_input=state.user.get(agent) if figure.wants_user else None,
    )


def _sensors(state: State, agent: str, i: int) -> Sensors | None:
    """Return the readings of the simulated sensors and, after them, those that a real body forwarded."""
    virtual = readings(state.body_set.plan, state.samples, state.tick, i)
    real = state.forwarded.get(agent)
    if real is None:
        return virtual
    none = Sensors()
    return Sensors(
        **{
            field: getattr(virtual or none, field)
            + tuple(_unstamped(reading, state.tick) for reading in getattr(real, field))
            for field in SENSOR_KINDS
        }
    )


def _unstamped(reading: Any, tick: int) -> Any:
    """Return a reading as it is told at a tick: without its own tick where that is this one."""
    return msgspec.structs.replace(reading, tick=None) if reading.tick == tick else reading


def entities(state: State) -> tuple[Entity, ...]:
    """Return every body's true state, in the order of names; positions and headings to 1e-6."""
    numbers = state.numbers.round(6)
    x, y, heading = numbers[rows.X].tolist(), numbers[rows.Y].tolist(), numbers[rows.HEADING].tolist()
    speed, turn_rate = numbers[rows.SPEED].tolist(), numbers[rows.TURN_RATE].tolist()
    touching = state.numbers[rows.TOUCHING].tolist()
    flags = state.flags.tolist()
    latest = state.tick - SAY_SHOWN / state.setup.period
    found = []
    for i, name in enumerate(state.names):
        status = state.manners.get(name, _SILENT_STATUS)
        found.append(
            Entity(
                name=name,
                x=x[i],
                y=y[i],
                heading=_shown_heading(heading[i]),
                speed=speed[i],
                turn_rate=turn_rate[i],
                collision=bool(flags[rows.COLLISION][i]),
                contact=bool(touching[i]),
                contacts=flags[rows.CONTACTS][i],
                state=_motor_state(state, i),
                mode=status.mode,
                goal=status.goal,
                say=status.say if status.say is not None and status.say_tick >= latest else None,
            )
        )
    return tuple(found)


def _shown_heading(rounded: float) -> float:
    """Return a rounded heading in (-pi, pi], which rounding may have left by less than 1e-6."""
    return rounded if -math.pi < rounded <= math.pi else math.pi


def power_in_force(state: State, agent: str) -> PowerInForce:
    """Return the power a real chair must give now, and why.

    Raises:
        KeyError: No such body is here.
    """
    i = state.body_set.index[agent]
    return PowerInForce(
        run=state.run,
        tick=state.tick,
        left_motor=float(state.numbers[rows.LEFT_POWER, i]),
        right_motor=float(state.numbers[rows.RIGHT_POWER, i]),
        state=_motor_state(state, i),
    )


def _motor_state(state: State, i: int) -> MotorState:
    flags = state.flags
    if flags[rows.STALE, i]:
        return "stale"
    if flags[rows.HALTED, i]:
        return "paused"
    if flags[rows.TAKEN, i]:
        return "taken"
    if flags[rows.RESTED, i]:
        return "rested"
    if flags[rows.TIMED_OUT, i]:
        return "timeout"
    return "drive"
