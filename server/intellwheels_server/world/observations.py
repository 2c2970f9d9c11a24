"""Observations of a state: measures for agents, true states for viewers, powers for real chairs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import msgspec
import numpy as np

from intellwheels_schemas.messages import Entity, Measures, MotorState, PowerInForce, Sensors
from intellwheels_schemas.rules import SENSOR_KINDS
from intellwheels_server.world.hearing import heard_by
from intellwheels_server.world.kernels import rows
from intellwheels_server.world.kernels.motor_model import MOTOR_LEFT_SCALE, MOTOR_RIGHT_SCALE, MOTOR_TOP_SPEED
from intellwheels_server.world.sensors import readings
from intellwheels_server.world.sensors.angles import written_heading
from intellwheels_server.world.state import BodyStatus, State

SAY_SHOWN: Final = 3.0
"""Simulated seconds for which the state of the world shows the last message of an agent."""

_NO_STATUS: Final = BodyStatus()

# Names of this module are found faster, and `measures` is called for every body at every tick.
_STALE, _HALTED, _TAKEN, _RESTED, _TIMED_OUT = rows.STALE, rows.HALTED, rows.TAKEN, rows.RESTED, rows.TIMED_OUT


def measures(state: State, agent: str) -> Measures:
    """Return the measures of an agent at this tick.

    Raises:
        KeyError: There is no such body.
    """
    body_set = state.body_set
    i = body_set.index[agent]
    model = body_set.models[agent]
    flags = state.flags[:, i].tolist()
    return Measures(
        run=state.run,
        tick=state.tick,
        time=state.shown_time,
        collision=bool(flags[rows.COLLISION]),
        contact=bool(state.numbers[rows.TOUCHING, i]),
        state=_motor_state(flags),
        sensors=_sensors(state, agent, i),
        message=heard_by(state, agent) if state.heard else (),
        user_input=state.user.get(agent) if model.wants_user else None,
    )


def _sensors(state: State, agent: str, i: int) -> Sensors | None:
    """Return the readings of the simulated sensors, followed by those that a real body forwarded."""
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
    """Return a reading without its tick if it was sampled at this one."""
    return msgspec.structs.replace(reading, tick=None) if reading.tick == tick else reading


def entities(state: State) -> tuple[Entity, ...]:
    """Return the true state of every body, sorted by name; all numbers are rounded to 1e-6."""
    numbers = state.numbers.round(6) + 0.0  # -0.0 becomes 0.0
    x, y, heading = numbers[rows.X].tolist(), numbers[rows.Y].tolist(), numbers[rows.HEADING].tolist()
    speed, turn_rate = numbers[rows.SPEED].tolist(), numbers[rows.TURN_RATE].tolist()
    left_output, right_output = _outputs(state)
    touching = state.numbers[rows.TOUCHING].tolist()
    flags = state.flags.T.tolist()
    latest = state.tick - SAY_SHOWN / state.setup.period
    found = []
    for i, name in enumerate(state.names):
        status = state.statuses.get(name, _NO_STATUS)
        found.append(
            Entity(
                name=name,
                x=x[i],
                y=y[i],
                heading=written_heading(heading[i]),
                speed=speed[i],
                turn_rate=turn_rate[i],
                left_output=left_output[i],
                right_output=right_output[i],
                collision=bool(flags[i][rows.COLLISION]),
                contact=bool(touching[i]),
                contacts=flags[i][rows.CONTACTS],
                state=_motor_state(flags[i]),
                mode=status.mode,
                goal=status.goal,
                say=status.say if status.say is not None and status.say_tick >= latest else None,
            )
        )
    return tuple(found)


def _outputs(state: State) -> list[list[float]]:
    """Return the outputs of the left and the right motors: the speed of a wheel over its speed at full power."""
    motors = state.body_set.motors
    full = motors[MOTOR_TOP_SPEED] * motors[MOTOR_LEFT_SCALE : MOTOR_RIGHT_SCALE + 1]
    speeds = state.numbers[rows.LEFT_SPEED : rows.RIGHT_SPEED + 1]
    outputs = np.divide(speeds, full, out=np.zeros_like(speeds), where=full > 0.0)
    found: list[list[float]] = (np.clip(outputs, -1.0, 1.0).round(6) + 0.0).tolist()
    return found


def power_in_force(state: State, agent: str) -> PowerInForce:
    """Return the power that a real chair must apply now, and why.

    Raises:
        KeyError: There is no such body.
    """
    i = state.body_set.index[agent]
    return PowerInForce(
        run=state.run,
        tick=state.tick,
        left_motor=float(state.numbers[rows.LEFT_POWER, i]),
        right_motor=float(state.numbers[rows.RIGHT_POWER, i]),
        state=_motor_state(state.flags[:, i].tolist()),
    )


def _motor_state(flags: Sequence[int]) -> MotorState:
    """Return whether the motors obey the mind, from the flags of one body."""
    if flags[_STALE]:
        return "stale"
    if flags[_HALTED]:
        return "paused"
    if flags[_TAKEN]:
        return "taken"
    if flags[_RESTED]:
        return "rested"
    if flags[_TIMED_OUT]:
        return "timeout"
    return "drive"
