"""Changes at a tick: joins, leaves, teleports, reset, load and so on. No time passes.

Changes act in the order given, each on the result of the ones before it. A change that cannot be made leaves the
state as it was, and its outcome says why.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import singledispatch

import msgspec

from intellwheels_schemas import file_records as do
from intellwheels_schemas.errors import RequestRefusedError
from intellwheels_schemas.messages import Event, Position, RefusedCode, ResultCode, Robot
from intellwheels_server.world.body_set import BodyModel, body_model_of
from intellwheels_server.world.draft import Draft
from intellwheels_server.world.empty_world import empty_world
from intellwheels_server.world.ending import check_end
from intellwheels_server.world.kernels import rows
from intellwheels_server.world.kernels.arrays import Walls
from intellwheels_server.world.map_geometry import walls_of
from intellwheels_server.world.placement import TOUCH, OccupiedSpace, place, with_wrapped_heading
from intellwheels_server.world.state import SavedState, State, Utterance

OPERATOR = "operator"
"""The sender name of operators. No agent can have this name."""
SLOTS = 16
"""Saved states that are kept; when there are more, the oldest is dropped."""


class Outcome(msgspec.Struct, frozen=True, kw_only=True):
    """The outcome of a change.

    Attributes:
        code: `ok`, or why the change was not made, as in a `Result`.
        refused: The code of a join or spawn that was refused.
        text: Why the change was not made.
        position: Where a body was put.
        robot: The robot as accepted.
    """

    code: ResultCode = "ok"
    refused: RefusedCode | None = None
    text: str = ""
    position: Position | None = None
    robot: Robot | None = None


class Outputs(msgspec.Struct, frozen=True, kw_only=True):
    """The outputs of changes or of a step.

    Attributes:
        outcomes: One for each change, in order.
        events: The events, numbered through the run.
        ended: Whether the end condition was met in this step.
    """

    outcomes: tuple[Outcome, ...] = ()
    events: tuple[Event, ...] = ()
    ended: bool = False


def change(state: State, changes: Sequence[do.Change], walls: Walls | None = None) -> tuple[State, Outputs]:
    """Return the state after the changes, with sensors sampled, and the outcome of each change.

    Args:
        state: Is not changed.
        changes: They are made in this order.
        walls: The walls of the map of a `Restart` among them, if they are known already.
    """
    draft = Draft(state, walls)
    outcomes = []
    for one in changes:
        try:
            outcomes.append(_act(one, draft))
        except RequestRefusedError as refusal:
            outcomes.append(Outcome(code="failed", refused=refusal.code, text=refusal.text))
    return draft.finish(), Outputs(outcomes=tuple(outcomes), events=tuple(draft.events))


@singledispatch
def _act(one: do.Change, _draft: Draft) -> Outcome:
    raise TypeError(f"expected a change, got {one!r}")


def _not_found(agent: str) -> Outcome:
    return Outcome(code="not-found", text=f"no agent '{agent}' here")


# ------------------------------------------------------------ bodies that come and go


@_act.register
def _join(one: do.Join, draft: Draft) -> Outcome:
    if one.robot.role == "mind":
        return _join_mind(one, draft)
    if one.agent in draft.models:
        raise RequestRefusedError("already-here", f"agent '{one.agent}' is already here")
    outcome = _place_robot(one.agent, one.robot, draft, one.reserved)
    draft.event("joined", one.agent)
    return outcome


def _join_mind(one: do.Join, draft: Draft) -> Outcome:
    model = draft.models.get(one.agent)
    if model is None:
        raise RequestRefusedError("no-body", f"agent '{one.agent}' has no body here yet; join again when it has")
    draft.replace_model(one.agent, msgspec.structs.replace(model, mind_input=one.robot.user_input))
    numbers = draft.numbers[one.agent]
    draft.event("joined", one.agent, "mind")
    return Outcome(
        position=Position(x=float(numbers[rows.X]), y=float(numbers[rows.Y]), heading=float(numbers[rows.HEADING])),
        robot=model.robot,
    )


def _place_robot(name: str, robot: Robot, draft: Draft, reserved: Sequence[str] = ()) -> Outcome:
    """Check a robot and put it at its place."""
    model = body_model_of(name, robot, draft.state.setup)
    position = place(model, draft.state.setup.floor, draft.space, reserved)
    model = msgspec.structs.replace(model, start=position)
    draft.put(name, model, position)
    if model.externally_posed:  # a real chair is accepted at any pose, so what it overlaps it may keep overlapping
        draft.numbers[name][rows.ALLOWED_PENETRATION] = draft.space.depth_at(name)
    return Outcome(position=position, robot=model.robot)


@_act.register
def _depart(one: do.Depart, draft: Draft) -> Outcome:
    model = draft.models.get(one.agent)
    if model is None:
        return _not_found(one.agent)
    if one.role == "mind":
        draft.replace_model(one.agent, msgspec.structs.replace(model, mind_input=()))
    else:
        draft.remove(one.agent)
    draft.event("lost" if one.lost else "left", one.agent, "mind" if one.role == "mind" else None)
    return Outcome()


@_act.register
def _spawn(one: do.SpawnBody, draft: Draft) -> Outcome:
    name = one.robot.name
    if name is None:
        raise RequestRefusedError("name", "Spawn.Robot.Name: expected a name, got none")
    if name in draft.models:
        raise RequestRefusedError("already-here", f"agent '{name}' is already here")
    robot = one.robot
    if one.position is not None:
        robot = msgspec.structs.replace(robot, position=one.position, place=None)
    outcome = _place_robot(name, robot, draft, one.reserved)
    draft.event("spawned", name)
    return outcome


@_act.register
def _delete(one: do.DeleteBody, draft: Draft) -> Outcome:
    if one.agent not in draft.models:
        return _not_found(one.agent)
    draft.remove(one.agent)
    draft.event("deleted", one.agent)
    return Outcome()


@_act.register
def _teleport(one: do.TeleportBody, draft: Draft) -> Outcome:
    model = draft.models.get(one.agent)
    if model is None:
        return _not_found(one.agent)
    if model.externally_posed:
        return Outcome(code="failed", text=f"agent '{one.agent}' is a real chair: only its bridge can change its pose")
    space, target = draft.space, with_wrapped_heading(one.position)
    beyond = None if one.force else space.outside(target)
    if beyond is not None:
        return Outcome(code="failed", refused="value", text=f"agent '{one.agent}': {beyond}")
    before = draft.numbers[one.agent]
    space.add(one.agent, model, target.x, target.y, target.heading)
    obstacle = None if one.force else space.overlap_of(one.agent)
    if obstacle is not None:
        space.add(one.agent, model, before[rows.X], before[rows.Y], before[rows.HEADING])
        return Outcome(code="failed", refused="overlaps", text=f"agent '{one.agent}' would overlap {obstacle} there")
    numbers = before.copy()
    numbers[rows.X], numbers[rows.Y], numbers[rows.HEADING] = target.x, target.y, target.heading
    numbers[rows.ALLOWED_PENETRATION] = space.depth_at(one.agent)
    draft.numbers[one.agent] = numbers
    draft.event("teleported", one.agent)
    return Outcome(position=target)


# ------------------------------------------------------------ smaller changes


@_act.register
def _take(one: do.TakeBody, draft: Draft) -> Outcome:
    if one.agent not in draft.models:
        return _not_found(one.agent)
    flags = draft.flags[one.agent]
    if flags[rows.TAKEN] != int(one.on):
        flags[rows.TAKEN] = int(one.on)
        draft.event("taken" if one.on else "released", one.agent)
    return Outcome()


@_act.register
def _speech(one: do.Speech, draft: Draft) -> Outcome:
    if one.to is not None and one.to not in draft.models:
        return _not_found(one.to)
    utterance = Utterance(sender=OPERATOR, text=one.text, tick=draft.state.tick, to=one.to)
    draft.update(spoken=(*draft.state.spoken, utterance))
    return Outcome()


@_act.register
def _note(one: do.Note, draft: Draft) -> Outcome:
    draft.event(one.code, one.agent, one.text, one.speed)
    return Outcome()


@_act.register
def _go_on(_one: do.GoOn, draft: Draft) -> Outcome:
    draft.update(end_waived=draft.state.ended or draft.state.end_waived, ended=False)
    return Outcome()


# ------------------------------------------------------------ other runs


@_act.register
def _save(one: do.SaveState, draft: Draft) -> Outcome:
    bare = msgspec.structs.replace(draft.finish(), saved=())
    draft.update(saved=(*draft.state.saved, SavedState(one.slot, bare))[-SLOTS:])
    return Outcome()


@_act.register
def _restore(one: do.RestoreState, draft: Draft) -> Outcome:
    now = draft.state
    state = next((saved.state for saved in now.saved if saved.slot == one.slot), None)
    if state is None:
        slots = ", ".join(saved.slot for saved in now.saved) or "none"
        return Outcome(code="not-found", text=f"no slot '{one.slot}'; expected one of: {slots}")
    revision = now.revision + (state.setup.floor != now.setup.floor)
    draft.replace_state(msgspec.structs.replace(state, run=one.run, revision=revision, event_count=0, saved=now.saved))
    draft.event("reset", text=f"restored {one.slot}: tick {state.tick} of run {state.run}")
    return Outcome()


@_act.register
def _restart(one: do.Restart, draft: Draft) -> Outcome:
    """Begin a new run: bodies return to their start or, on another map, go to a free place for their kind.

    A body may have started where another one had left. Then both are there after a reset, and either may leave.
    """
    old = draft.state
    setup = msgspec.structs.replace(
        old.setup,
        floor=one.map or old.setup.floor,
        seed=one.seed,
        end=one.end if one.end is not None else old.setup.end,
    )
    if setup.end is not None:
        check_end(setup.end, setup.floor)
    try:
        walls = old.walls if one.map is None else draft.new_walls or walls_of(setup.floor)
    except ValueError as error:
        return Outcome(code="failed", text=f"map '{setup.floor.name}': {error}")
    models: list[BodyModel] = []
    space = OccupiedSpace(walls, setup.floor)
    for name in sorted(draft.models):
        before = draft.models[name]
        model = body_model_of(name, before.robot, setup)
        position = before.start
        if one.map is not None:
            try:
                position = place(model, setup.floor, space)
            except RequestRefusedError as refusal:
                return Outcome(code="failed", refused=refusal.code, text=refusal.text)
        models.append(msgspec.structs.replace(model, start=position, mind_input=before.mind_input))
        space.add(name, model, position.x, position.y, position.heading)
    halted = {name: flags[rows.HALTED] for name, flags in draft.flags.items()}
    draft.replace_state(
        msgspec.structs.replace(
            empty_world(setup, one.run, walls),
            revision=old.revision + (one.map is not None),
            saved=old.saved,
        )
    )
    for model in models:
        draft.put(model.name, model, model.start)
        draft.flags[model.name][rows.HALTED] = halted[model.name]
    for model in models:
        depth = draft.space.depth_at(model.name)
        draft.numbers[model.name][rows.ALLOWED_PENETRATION] = depth if depth > TOUCH else 0.0
    draft.event("loaded" if one.map is not None else "reset", text=setup.floor.name if one.map is not None else None)
    return Outcome()
