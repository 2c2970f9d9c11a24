"""One step of the world: inputs go into the arrays, the kernels move the bodies, and events and speech follow."""

from __future__ import annotations

import math

import msgspec
import numpy as np

from intellwheels_schemas.file_records import Inputs
from intellwheels_schemas.messages import Event, EventCode
from intellwheels_server.world.apply_inputs import (
    Happening,
    enter_actions,
    enter_forwarded,
    enter_poses,
    enter_user,
    enter_verdicts,
    utterances_of,
    without_wishes,
)
from intellwheels_server.world.contacts import update_episodes
from intellwheels_server.world.digest import digest
from intellwheels_server.world.ending import end_reason
from intellwheels_server.world.kernels import rows
from intellwheels_server.world.kernels.arrays import Ints
from intellwheels_server.world.kernels.motor_power import NOW_SILENT, NOW_STALE, NOW_TIMED_OUT
from intellwheels_server.world.kernels.tick_kernel import tick_all
from intellwheels_server.world.sensors import sense
from intellwheels_server.world.sensors.kind import View
from intellwheels_server.world.state import State

USER_SILENCE = 0.3
"""Seconds without input after which a user is silent."""

_NOBODY = np.empty(0, dtype=np.int64)


def staleness(period: float) -> float:
    """Return the seconds without a pose after which a real body is stale: three ticks, at least 0.3 s."""
    return max(3.0 * period, 0.3)


def steps_in(seconds: float, period: float) -> int:
    """Return the number of whole steps that cover a time, both in seconds."""
    return math.ceil(seconds / period - 1e-9)


def step(state: State, inputs: Inputs) -> tuple[State, tuple[Event, ...], bool]:
    """Return the next state, the events, and whether the end condition was met."""
    setup, body_set = state.setup, state.body_set
    numbers, flags = state.numbers.copy(), state.flags.copy()
    statuses, said = enter_actions(state, inputs.actions, numbers, flags)
    user = enter_user(state, inputs.user_input, numbers, flags) if inputs.user_input else state.user
    reported, forwarded = _NOBODY, state.forwarded
    if inputs.poses:
        forwarded = enter_forwarded(state, inputs.poses)
        reported = np.array(sorted(enter_poses(state, inputs.poses, numbers, flags)), dtype=np.int64)
    happenings: list[Happening] = []
    if inputs.verdicts:
        happenings, user = enter_verdicts(state, inputs.verdicts, flags, user)
    if setup.strict and len(reported):
        happenings.extend(_fresh(state, reported, flags))

    period, bodies, walls = setup.period, body_set.bodies, state.walls
    found, hits, hit_numbers = tick_all(
        bodies.parts,
        bodies.part_start,
        bodies.shape,
        bodies.marks,
        walls.pieces,
        walls.links,
        walls.edges,
        walls.cells,
        walls.frame,
        body_set.motors,
        body_set.flaws,
        body_set.noise,
        body_set.limits,
        numbers,
        flags,
        reported,
        state.tick,
        period,
        steps_in(USER_SILENCE, period) if setup.strict else -1,
        steps_in(staleness(period), period) if setup.strict else -1,
    )
    if found:
        happenings.extend(_found(state, found, flags))
        if found & NOW_SILENT:
            user = {
                name: without_wishes(wish)
                if flags[rows.SILENT, body_set.index[name]] and not state.flags[rows.SILENT, body_set.index[name]]
                else wish
                for name, wish in user.items()
            }
    events = [
        Event(run=state.run, tick=state.tick + 1, number=state.event_count + k, code=code, agent=agent)
        for k, (code, agent) in enumerate(happenings)
    ]
    episodes, contact_events = update_episodes(state, hits, hit_numbers, flags, state.event_count + len(events))
    events.extend(contact_events)
    coming, heard = state.coming, state.spoken
    if said or inputs.says or coming:
        delay = steps_in(setup.say_delay, period)
        coming += utterances_of(state, inputs, said, numbers, state.tick + 1 + delay)
        heard += tuple(utterance for utterance in coming if utterance.due <= state.tick + 1)
        coming = tuple(utterance for utterance in coming if utterance.due > state.tick + 1)
    view = View(numbers, body_set.bodies.parts, body_set.bodies.part_start, state.walls, period)
    new = msgspec.structs.replace(
        state,
        tick=state.tick + 1,
        numbers=numbers,
        flags=flags,
        samples=sense(body_set.plan, view, state.tick + 1, state.samples),
        episodes=episodes,
        statuses=statuses,
        user=user,
        forwarded=forwarded,
        heard=heard,
        coming=coming,
        spoken=(),
        event_count=state.event_count + len(events),
    )
    if setup.end is not None and not state.end_waived:
        reason = end_reason(new, setup.end)
        if reason is not None:
            return _ended(new, events, reason)
    return new, tuple(events), False


def _ended(state: State, events: list[Event], reason: str) -> tuple[State, tuple[Event, ...], bool]:
    event = Event(
        run=state.run,
        tick=state.tick,
        number=state.event_count,
        code="ended",
        text=f"{reason}, hash {digest(state)}",
    )
    state = msgspec.structs.replace(state, ended=True, event_count=state.event_count + 1)
    return state, (*events, event), True


def _fresh(state: State, reported: Ints, flags: Ints) -> list[Happening]:
    """Clear the stale flags of real bodies that reported; return the events. Only for strict runs."""
    found: list[Happening] = []
    for i in reported.tolist():
        if flags[rows.STALE, i]:
            flags[rows.STALE, i] = 0
            found.append(("fresh", state.names[i]))
    return found


def _found(state: State, found: int, flags: Ints) -> list[Happening]:
    """Return the events of commands that timed out and of poses that became stale in this step."""
    happenings: list[Happening] = []
    codes: list[tuple[int, int, EventCode]] = [
        (NOW_TIMED_OUT, rows.TIMED_OUT, "timeout"),
        (NOW_STALE, rows.STALE, "stale"),
    ]
    for bit, row, code in codes:
        if found & bit:
            new = (flags[row] != 0) & (state.flags[row] == 0)
            if code == "timeout":
                new &= (state.numbers[rows.LEFT_COMMAND] != 0.0) | (state.numbers[rows.RIGHT_COMMAND] != 0.0)
            happenings.extend((code, state.names[i]) for i in np.nonzero(new)[0].tolist())
    return happenings
