"""Writes the inputs of a step to the arrays: commands, user input, reported poses, verdicts, speech."""

from __future__ import annotations

import math
from collections.abc import Mapping
from operator import attrgetter
from typing import Any

import msgspec
import numpy as np

from intellwheels_schemas.file_records import Inputs, Verdict
from intellwheels_schemas.messages import Actions, EventCode, Pose, Sensors, UserInput
from intellwheels_schemas.rules import SENSOR_KINDS, sensors_of
from intellwheels_server.world.kernels import rows
from intellwheels_server.world.kernels.arrays import Floats, Ints
from intellwheels_server.world.kernels.elementary import cos, sin
from intellwheels_server.world.state import BodyStatus, State, Utterance

Happening = tuple[EventCode, str]
"""The code of an event, and its agent."""

_FLAG_OF_VERDICT = {
    "rested": (rows.RESTED, 1),
    "back": (rows.RESTED, 0),
    "halt": (rows.HALTED, 1),
    "unhalt": (rows.HALTED, 0),
    "stale": (rows.STALE, 1),
    "fresh": (rows.STALE, 0),
    "silent": (rows.SILENT, 1),
}
_EVENT_OF_VERDICT: dict[str, EventCode] = {
    "late": "late",
    "rested": "rested",
    "back": "back",
    "stale": "stale",
    "fresh": "fresh",
}

_MANY = 32
"""Actions of so many bodies at once are entered together. It does not matter for the result."""
_MOTORS = attrgetter("left_motor"), attrgetter("right_motor")
_WORDS = attrgetter("mode", "goal", "say")
_NO_WORDS = (None, None, None)


def enter_actions(
    state: State, actions: Mapping[str, Actions], numbers: Floats, flags: Ints
) -> tuple[dict[str, BodyStatus], list[Utterance]]:
    """Write commands to the arrays; return what agents report of themselves, and what they said.

    A motor that is left out keeps its command. Actions without motors do not restart the time-out.
    """
    index = state.body_set.index
    statuses = state.statuses
    said: list[Utterance] = []
    left, right, age = numbers[rows.LEFT_COMMAND], numbers[rows.RIGHT_COMMAND], flags[rows.COMMAND_AGE]
    if len(actions) >= _MANY:
        actions = _enter_motors(actions, index, (left, right, age))
    for name, action in actions.items():
        i = index.get(name)
        if i is None:
            continue
        if action.left_motor is not None:
            left[i] = action.left_motor
            age[i] = 0
        if action.right_motor is not None:
            right[i] = action.right_motor
            age[i] = 0
        if action.say is not None:
            said.append(Utterance(sender=name, text=action.say, tick=state.tick, seq=action.seq))
        if action.mode is not None or action.goal is not None or action.say is not None:
            statuses = _with_status(state, statuses, name, action)
    return statuses, said


def _enter_motors(
    actions: Mapping[str, Actions], index: Mapping[str, int], arrays: tuple[Floats, Floats, Ints]
) -> Mapping[str, Actions]:
    """Write commands of many bodies to the arrays; return the actions with more than two motors, or all of them.

    Nothing is written if an agent is not here or leaves out a motor.

    Args:
        actions: The actions.
        index: The columns of the bodies.
        arrays: The left commands, the right ones, and their ages.
    """
    count = len(actions)
    try:
        columns = np.fromiter(map(index.__getitem__, actions), np.int64, count)
    except KeyError:
        return actions
    powers = [np.fromiter(map(motor, actions.values()), np.float64, count) for motor in _MOTORS]
    if np.isnan(powers).any():  # what None becomes
        return actions
    left, right, age = arrays
    left[columns], right[columns] = powers
    age[columns] = 0
    return {name: action for name, action in actions.items() if _WORDS(action) != _NO_WORDS}


def _with_status(state: State, statuses: dict[str, BodyStatus], name: str, action: Actions) -> dict[str, BodyStatus]:
    """Return the statuses with that of an agent; the same object if it is unchanged."""
    old = statuses.get(name)
    base = old or BodyStatus()
    new = BodyStatus(
        mode=base.mode if action.mode is None else action.mode,
        goal=base.goal if action.goal is None else action.goal,
        say=base.say if action.say is None else action.say,
        say_tick=base.say_tick if action.say is None else state.tick + 1,
    )
    if new == old:
        return statuses
    statuses = dict(statuses) if statuses is state.statuses else statuses
    statuses[name] = new
    return statuses


def enter_user(state: State, user_input: Mapping[str, UserInput], numbers: Floats, flags: Ints) -> dict[str, UserInput]:
    """Write user input to the arrays; return the last input of each user, without leases."""
    user = dict(state.user)
    for name, wish in user_input.items():
        i = state.body_set.index.get(name)
        if i is None:
            continue
        numbers[rows.USER_FORWARD, i], numbers[rows.USER_TURN, i] = wish.forward, wish.turn
        flags[rows.USER_AGE, i] = flags[rows.SILENT, i] = 0
        user[name] = wish if wish.lease is None else msgspec.structs.replace(wish, lease=None)
    return user


def without_wishes(user: UserInput) -> UserInput:
    """Return the input of a user that has become silent: only its number and its goal are kept."""
    return UserInput(seq=user.seq, goal=user.goal)


def enter_poses(state: State, poses: Mapping[str, Pose], numbers: Floats, flags: Ints) -> list[int]:
    """Write reported poses of real bodies to the arrays; return their columns.

    Speed and turn rate are the mean ones since the last pose.
    """
    moved = []
    period = state.setup.period
    for name, pose in poses.items():
        i = state.body_set.index.get(name)
        if i is None or not state.body_set.models[name].externally_posed:
            continue
        heading = math.remainder(pose.heading, math.tau)
        heading = math.pi if heading == -math.pi else heading
        dx, dy = pose.x - float(numbers[rows.X, i]), pose.y - float(numbers[rows.Y, i])
        turn = math.remainder(heading - float(numbers[rows.HEADING, i]), math.tau)
        gone = max(int(flags[rows.POSE_AGE, i]), 1) * period
        distance = math.sqrt(dx * dx + dy * dy)
        forward = dx * cos(heading) + dy * sin(heading)
        speed = min(distance / gone, rows.MOST_SPEED)
        numbers[rows.SPEED, i] = speed if forward >= 0.0 else -speed
        numbers[rows.TURN_RATE, i] = min(max(turn / gone, -rows.MOST_TURN_RATE), rows.MOST_TURN_RATE)
        numbers[rows.X, i], numbers[rows.Y, i], numbers[rows.HEADING, i] = pose.x, pose.y, heading
        flags[rows.POSE_AGE, i] = 0
        moved.append(i)
    return moved


def enter_forwarded(state: State, poses: Mapping[str, Pose]) -> dict[str, Sensors]:
    """Return the last readings of the sensors that each real body declared with `Source` real."""
    forwarded = state.forwarded
    for name, pose in poses.items():
        model = state.body_set.models.get(name)
        if pose.sensors is None or model is None or not model.externally_posed:
            continue
        own = {sensor.id for _, _, sensor in sensors_of(model.robot) if sensor.source == "real"}
        forwarded_fields = {
            field: tuple(
                _stamped(reading, state.tick + 1) for reading in getattr(pose.sensors, field) if reading.id in own
            )
            for field in SENSOR_KINDS
        }
        forwarded = {**forwarded, name: Sensors(**forwarded_fields)}
    return forwarded


def _stamped(reading: Any, tick: int) -> Any:
    """Return a reading with its tick; a new reading may leave it out."""
    return msgspec.structs.replace(reading, tick=tick) if reading.tick is None else reading


def enter_verdicts(
    state: State, verdicts: tuple[Verdict, ...], flags: Ints, user: dict[str, UserInput]
) -> tuple[list[Happening], dict[str, UserInput]]:
    """Write verdicts to the flags; return their events, and the last input of each user."""
    happenings: list[Happening] = []
    for verdict in verdicts:
        i = state.body_set.index.get(verdict.agent)
        if i is None:
            continue
        if verdict.code in _FLAG_OF_VERDICT:
            row, value = _FLAG_OF_VERDICT[verdict.code]
            flags[row, i] = value
        if verdict.code == "silent" and verdict.agent in user:
            user = {**user, verdict.agent: without_wishes(user[verdict.agent])}
        event = _EVENT_OF_VERDICT.get(verdict.code)
        if event is not None:
            happenings.append((event, verdict.agent))
    return happenings, user


def utterances_of(
    state: State, inputs: Inputs, said: list[Utterance], numbers: Floats, due: int
) -> tuple[Utterance, ...]:
    """Return what agents said in the step, one message each, sorted by name, at the places where they are after it.

    Args:
        state: The state before the step.
        inputs: The inputs of the step, for what was said without actions.
        said: What was said with actions; the function adds to it.
        numbers: The numbers after the step.
        due: The tick whose measures carry it.
    """
    speakers = {utterance.sender for utterance in said}
    for say in inputs.says:
        if say.agent in state.body_set.index and say.agent not in speakers:
            said.append(Utterance(sender=say.agent, text=say.text, tick=state.tick, seq=say.seq))
            speakers.add(say.agent)
    placed = []
    for one in sorted(said, key=lambda one: one.sender):
        i = state.body_set.index[one.sender]
        placed.append(msgspec.structs.replace(one, at=(float(numbers[rows.X, i]), float(numbers[rows.Y, i])), due=due))
    return tuple(placed)
