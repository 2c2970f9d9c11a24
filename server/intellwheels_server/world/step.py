"""One step of the world: inputs go into the arrays, the kernels move the bodies, and events and speech follow."""

from __future__ import annotations

import math

import msgspec
import numpy as np

from intellwheels_schemas.file_records import Inputs
from intellwheels_schemas.messages import Event, EventCode, Sensors, UserInput
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
from intellwheels_server.world.kernels.arrays import Floats, Ints
from intellwheels_server.world.kernels.motor_power import NOW_SILENT, NOW_STALE, NOW_TIMED_OUT
from intellwheels_server.world.kernels.tick_kernel import tick_all
from intellwheels_server.world.sensors import sense
from intellwheels_server.world.sensors.kind import View
from intellwheels_server.world.state import BodyStatus, Setup, State, Utterance

USER_SILENCE = 0.3
"""Seconds without input after which a user is silent."""

_NOBODY = np.empty(0, dtype=np.int64)


def staleness(period: float) -> float:
    """Return the seconds without a pose after which a real body is stale: three ticks, at least 0.3 s."""
    return max(3.0 * period, 0.3)


def steps_in(seconds: float, period: float) -> int:
    """Return the number of whole steps that cover a time, both in seconds."""
    return math.ceil(seconds / period - 1e-9)


class Entered(msgspec.Struct, frozen=True, gc=False):
    """What the inputs of a step leave behind beside the arrays.

    Attributes:
        statuses: What agents report of themselves.
        said: What agents said with their actions.
        user: The last input of each body's user.
        forwarded: The last readings of each real body's own sensors.
        reported: int64[k], columns of real bodies whose pose was reported, ascending.
        happenings: Events of the inputs.
    """

    statuses: dict[str, BodyStatus]
    said: list[Utterance]
    user: dict[str, UserInput]
    forwarded: dict[str, Sensors]
    reported: Ints
    happenings: list[Happening]


def step(state: State, inputs: Inputs, threads: int = 1) -> tuple[State, tuple[Event, ...], bool]:
    """Return the next state, the events, and whether the end condition was met. Threads may share the sensors."""
    body_set, walls, period = state.body_set, state.walls, state.setup.period
    numbers, flags = state.numbers.copy(), state.flags.copy()
    entered = enter(state, inputs, numbers, flags)
    touched = tick_all(
        *(*body_set.bodies, *walls),
        body_set.motors,
        body_set.flaws,
        body_set.noise,
        body_set.limits,
        numbers,
        flags,
        entered.reported,
        state.tick,
        period,
        *limits_of(state.setup),
    )
    bodies = body_set.bodies
    samples = sense(
        body_set.plan,
        View(numbers, bodies.parts, bodies.part_start, walls, period, threads),
        state.tick + 1,
        state.samples,
    )
    return conclude(state, inputs, entered, touched, (numbers, flags, samples))


def limits_of(setup: Setup) -> tuple[int, int]:
    """Return the steps after which a user is silent and a real body's pose is stale, each -1 for never."""
    if not setup.strict:
        return -1, -1
    return steps_in(USER_SILENCE, setup.period), steps_in(staleness(setup.period), setup.period)


def enter(state: State, inputs: Inputs, numbers: Floats, flags: Ints) -> Entered:
    """Write the inputs of a step to its arrays; return what they leave behind beside them.

    Args:
        state: The state before the step.
        inputs: The inputs. Their changes have been made.
        numbers: A copy of those of the state.
        flags: A copy of those of the state.
    """
    statuses, said = enter_actions(state, inputs.actions, numbers, flags)
    user = enter_user(state, inputs.user_input, numbers, flags) if inputs.user_input else state.user
    reported, forwarded = _NOBODY, state.forwarded
    if inputs.poses:
        forwarded = enter_forwarded(state, inputs.poses)
        reported = np.array(sorted(enter_poses(state, inputs.poses, numbers, flags)), dtype=np.int64)
    happenings: list[Happening] = []
    if inputs.verdicts:
        happenings, user = enter_verdicts(state, inputs.verdicts, flags, user)
    if state.setup.strict and len(reported):
        happenings.extend(_fresh(state, reported, flags))
    return Entered(statuses, said, user, forwarded, reported, happenings)


def conclude(
    state: State,
    inputs: Inputs,
    entered: Entered,
    touched: tuple[int, Ints, Floats],
    after: tuple[Floats, Ints, Floats],
) -> tuple[State, tuple[Event, ...], bool]:
    """Return the next state, the events, and whether the end condition was met.

    Args:
        state: The state before the step.
        inputs: The inputs of the step.
        entered: What they left behind.
        touched: The bits of `motor_power.powers`, the pairs that touched and their numbers, as `tick_all` returns them.
        after: Numbers, flags and samples after the step. Contacts are counted in the flags.
    """
    statuses, said, user, happenings = entered.statuses, entered.said, entered.user, entered.happenings
    found, hits, hit_numbers = touched
    numbers, flags, samples = after
    tick = state.tick + 1
    if found:
        happenings.extend(_found(state, found, flags))
        if found & NOW_SILENT:
            index = state.body_set.index
            user = {
                name: without_wishes(wish)
                if flags[rows.SILENT, index[name]] and not state.flags[rows.SILENT, index[name]]
                else wish
                for name, wish in user.items()
            }
    events: tuple[Event, ...] = ()
    if happenings:
        events = tuple(
            Event(run=state.run, tick=tick, number=state.event_count + k, code=code, agent=agent)
            for k, (code, agent) in enumerate(happenings)
        )
    episodes = state.episodes
    if hits.shape[0] or episodes.shape[0]:
        episodes, contact_events = update_episodes(state, hits, hit_numbers, flags, state.event_count + len(events))
        events += tuple(contact_events)
    coming, heard = state.coming, state.spoken
    if said or inputs.says or coming:
        delay = steps_in(state.setup.say_delay, state.setup.period)
        coming += utterances_of(state, inputs, said, numbers, tick + delay)
        heard += tuple(utterance for utterance in coming if utterance.due <= tick)
        coming = tuple(utterance for utterance in coming if utterance.due > tick)
    new = msgspec.structs.replace(
        state,
        tick=tick,
        numbers=numbers,
        flags=flags,
        samples=samples,
        episodes=episodes,
        statuses=statuses,
        user=user,
        forwarded=entered.forwarded,
        heard=heard,
        coming=coming,
        spoken=(),
        event_count=state.event_count + len(events),
    )
    setup = state.setup
    if setup.end is not None and not state.end_waived:
        reason = end_reason(new, setup.end)
        if reason is not None:
            return _ended(new, events, reason)
    return new, events, False


def _ended(state: State, events: tuple[Event, ...], reason: str) -> tuple[State, tuple[Event, ...], bool]:
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
