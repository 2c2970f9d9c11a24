"""Changes at a tick: who joins, leaves, is put somewhere; reset and load. No time passes.

Changes act in the order given, each on what the ones before it left. A change that cannot be
made leaves everything as it was, and its outcome says why.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import singledispatch

import msgspec
import numpy as np

from intellwheels_schemas.errors import RequestRefusedError
from intellwheels_schemas.messages import Event, EventCode, Position, RefusedCode, ResultCode, Robot
from intellwheels_server.world import inputs as do
from intellwheels_server.world.body_set import BodyModel, BodySet, assemble, body_model_of
from intellwheels_server.world.ending import check_end
from intellwheels_server.world.kernels import rows
from intellwheels_server.world.kernels.arrays import Floats, Ints
from intellwheels_server.world.map_geometry import walls_of
from intellwheels_server.world.placement import TOUCH, Crowd, in_range, place
from intellwheels_server.world.sensors import sense
from intellwheels_server.world.sensors.kind import View
from intellwheels_server.world.state import KeptStart, Setup, State, Utterance, no_episodes

OPERATOR = "operator"
"""Whom an operator's words come from; no agent can have this name."""
SLOTS = 16
"""States that are kept; one more and the oldest is lost."""


class Outcome(msgspec.Struct, frozen=True, kw_only=True):
    """What became of a change.

    Attributes:
        code: `ok`, or why not, as in a `Result`.
        refused: For a join or spawn that was refused, its code.
        text: Why not, in words.
        position: Where a body was put.
        robot: The robot as accepted.
    """

    code: ResultCode = "ok"
    refused: RefusedCode | None = None
    text: str = ""
    position: Position | None = None
    robot: Robot | None = None


class Outputs(msgspec.Struct, frozen=True, kw_only=True):
    """What came out of changes or a step.

    Attributes:
        outcomes: One for each change, in order.
        events: What happened, numbered on within the run.
        ended: Whether the end condition was met in this step.
    """

    outcomes: tuple[Outcome, ...] = ()
    events: tuple[Event, ...] = ()
    ended: bool = False


class Draft:
    """A state being changed. Bodies are columns in any order until `finish` sorts them by name."""

    def __init__(self, state: State) -> None:
        self.events: list[Event] = []
        self.kept = state.kept
        self.take_up(state)

    def take_up(self, state: State) -> None:
        """Go on from a state; what happened and what was saved before stays."""
        self.state = state
        self.run = state.run
        self.tick = state.tick
        self.setup = state.setup
        self.walls = state.walls
        self.figures: dict[str, BodyModel] = dict(state.body_set.figures)
        self.numbers = {name: state.numbers[:, i].copy() for i, name in enumerate(state.names)}
        self.flags = {name: state.flags[:, i].copy() for i, name in enumerate(state.names)}
        self.manners = dict(state.manners)
        self.user = dict(state.user)
        self.forwarded = dict(state.forwarded)
        self.heard = state.heard
        self.coming = state.coming
        self.spoken = state.spoken
        self.episodes = state.episodes
        self.event_count = state.event_count
        self.revision = state.revision
        self.ended = state.ended
        self.end_waived = state.end_waived
        self.bodies_changed = False
        self.arrived: set[str] = set()
        self.restarted = False
        self._crowd: Crowd | None = None

    @property
    def crowd(self) -> Crowd:
        """Where everybody stands, for finding a free place."""
        if self._crowd is None:
            self._crowd = Crowd(self.walls, self.setup.floor)
            for name, figure in self.figures.items():
                numbers = self.numbers[name]
                self._crowd.add(name, figure, numbers[rows.X], numbers[rows.Y], numbers[rows.HEADING])
        return self._crowd

    def event(
        self, code: EventCode, agent: str | None = None, text: str | None = None, speed: float | None = None
    ) -> None:
        """Note that something happened."""
        self.events.append(
            Event(
                run=self.run,
                tick=self.tick,
                number=self.event_count,
                code=code,
                agent=agent,
                speed=speed,
                text=text or None,
            )
        )
        self.event_count += 1

    def put(self, name: str, figure: BodyModel, position: Position) -> None:
        """Add a body at rest, or replace what is known of it."""
        numbers = np.zeros(rows.NUMBER_ROWS)
        numbers[rows.X], numbers[rows.Y], numbers[rows.HEADING] = position.x, position.y, position.heading
        flags = np.zeros(rows.FLAG_ROWS, dtype=np.int64)
        flags[rows.SILENT] = 1
        flags[rows.POSE_AGE] = 1 if figure.externally_posed else 0  # where it joined counts as its pose of this tick
        self.figures[name] = figure
        self.numbers[name] = numbers
        self.flags[name] = flags
        self.bodies_changed = True
        self.arrived.add(name)
        self.crowd.add(name, figure, position.x, position.y, position.heading)

    def remove(self, name: str) -> None:
        """Take a body and all that is known of it out."""
        key = self.figures[name].key
        del self.figures[name], self.numbers[name], self.flags[name]
        self.manners.pop(name, None)
        self.user.pop(name, None)
        self.forwarded.pop(name, None)
        self.episodes = self.episodes[(self.episodes[:, 0] != key) & (self.episodes[:, 1] != key)]
        if self._crowd is not None:
            self._crowd.remove(name)
        self.bodies_changed = True

    def finish(self) -> State:
        """Return the changed state, its bodies sorted by name and its sensors compiled anew."""
        body_set = self.state.body_set
        numbers, flags, samples = self.state.numbers, self.state.flags, self.state.samples
        if self.bodies_changed or self.restarted:
            old = None if self.restarted else self.state
            body_set, samples = assemble(self.figures, self.setup, self.tick, old, self.arrived)
        numbers, flags = _columns(body_set, self.numbers, self.flags)
        view = View(numbers, body_set.bodies.parts, body_set.bodies.part_start, self.walls, self.setup.period)
        return State(
            run=self.run,
            tick=self.tick,
            setup=self.setup,
            walls=self.walls,
            body_set=body_set,
            numbers=numbers,
            flags=flags,
            samples=sense(body_set.plan, view, self.tick, samples),
            episodes=self.episodes,
            manners=self.manners,
            user=self.user,
            forwarded=self.forwarded,
            heard=self.heard,
            coming=self.coming,
            spoken=self.spoken,
            event_count=self.event_count,
            revision=self.revision,
            ended=self.ended,
            end_waived=self.end_waived,
            kept=self.kept,
        )


def _columns(body_set: BodySet, numbers: dict[str, Floats], flags: dict[str, Ints]) -> tuple[Floats, Ints]:
    count = len(body_set.names)
    number_block = np.empty((rows.NUMBER_ROWS, count))
    flag_block = np.empty((rows.FLAG_ROWS, count), dtype=np.int64)
    for i, name in enumerate(body_set.names):
        number_block[:, i] = numbers[name]
        flag_block[:, i] = flags[name]
    return number_block, flag_block


def change(state: State, changes: Sequence[do.Change]) -> tuple[State, Outputs]:
    """Return the state after the changes, sensed anew, and what became of each."""
    draft = Draft(state)
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


@_act.register
def _join(one: do.Join, draft: Draft) -> Outcome:
    if one.robot.role == "mind":
        return _join_mind(one, draft)
    if one.agent in draft.figures:
        raise RequestRefusedError("already-here", f"agent '{one.agent}' is already here")
    outcome = _settle(one.agent, one.robot, draft)
    draft.event("joined", one.agent)
    return outcome


def _join_mind(one: do.Join, draft: Draft) -> Outcome:
    figure = draft.figures.get(one.agent)
    if figure is None:
        raise RequestRefusedError("no-body", f"agent '{one.agent}' has no body here yet; join again when it has")
    draft.figures[one.agent] = msgspec.structs.replace(figure, mind_input=one.robot.user_input)
    numbers = draft.numbers[one.agent]
    draft.bodies_changed = True
    draft.event("joined", one.agent, "mind")
    return Outcome(
        position=Position(x=float(numbers[rows.X]), y=float(numbers[rows.Y]), heading=float(numbers[rows.HEADING])),
        robot=figure.robot,
    )


def _settle(name: str, robot: Robot, draft: Draft) -> Outcome:
    """Check a robot and put it at its place."""
    figure = body_model_of(name, robot, draft.setup)
    position = place(figure, draft.setup.floor, draft.crowd)
    figure = msgspec.structs.replace(figure, start=position)
    draft.put(name, figure, position)
    if figure.externally_posed:  # a real chair is where it is: what it overlaps may stay as deep
        draft.numbers[name][rows.ALLOWED_PENETRATION] = draft.crowd.depth_at(name)
    return Outcome(position=position, robot=figure.robot)


@_act.register
def _depart(one: do.Depart, draft: Draft) -> Outcome:
    figure = draft.figures.get(one.agent)
    if figure is None:
        return _not_found(one.agent)
    if one.role == "mind":
        draft.figures[one.agent] = msgspec.structs.replace(figure, mind_input=())
        draft.bodies_changed = True
    else:
        draft.remove(one.agent)
    draft.event("lost" if one.lost else "left", one.agent, "mind" if one.role == "mind" else None)
    return Outcome()


@_act.register
def _spawn(one: do.SpawnBody, draft: Draft) -> Outcome:
    name = one.robot.name
    if name is None:
        raise RequestRefusedError("name", "Spawn.Robot.Name: expected a name, got none")
    if name in draft.figures:
        raise RequestRefusedError("already-here", f"agent '{name}' is already here")
    robot = one.robot
    if one.position is not None:
        robot = msgspec.structs.replace(robot, position=one.position, place=None)
    outcome = _settle(name, robot, draft)
    draft.event("spawned", name)
    return outcome


@_act.register
def _delete(one: do.DeleteBody, draft: Draft) -> Outcome:
    if one.agent not in draft.figures:
        return _not_found(one.agent)
    draft.remove(one.agent)
    draft.event("deleted", one.agent)
    return Outcome()


@_act.register
def _teleport(one: do.TeleportBody, draft: Draft) -> Outcome:
    figure = draft.figures.get(one.agent)
    if figure is None:
        return _not_found(one.agent)
    if figure.externally_posed:
        return Outcome(code="failed", text=f"agent '{one.agent}' is a real chair: only its bridge says where it is")
    crowd, at = draft.crowd, in_range(one.position)
    before = draft.numbers[one.agent]
    crowd.add(one.agent, figure, at.x, at.y, at.heading)
    obstacle = None if one.force else crowd.in_the_way(one.agent)
    if obstacle is not None:
        crowd.add(one.agent, figure, before[rows.X], before[rows.Y], before[rows.HEADING])
        return Outcome(code="failed", refused="overlaps", text=f"agent '{one.agent}' would overlap {obstacle} there")
    numbers = np.zeros(rows.NUMBER_ROWS)
    numbers[:] = before
    numbers[rows.X], numbers[rows.Y], numbers[rows.HEADING] = at.x, at.y, at.heading
    numbers[rows.ALLOWED_PENETRATION] = crowd.depth_at(one.agent)
    draft.numbers[one.agent] = numbers
    draft.event("teleported", one.agent)
    return Outcome(position=at)


@_act.register
def _take(one: do.TakeBody, draft: Draft) -> Outcome:
    if one.agent not in draft.figures:
        return _not_found(one.agent)
    flags = draft.flags[one.agent]
    if flags[rows.TAKEN] != int(one.on):
        flags[rows.TAKEN] = int(one.on)
        draft.event("taken" if one.on else "released", one.agent)
    return Outcome()


@_act.register
def _speech(one: do.Speech, draft: Draft) -> Outcome:
    if one.to is not None and one.to not in draft.figures:
        return _not_found(one.to)
    draft.spoken = (*draft.spoken, Utterance(sender=OPERATOR, text=one.text, tick=draft.tick, to=one.to))
    return Outcome()


@_act.register
def _note(one: do.Note, draft: Draft) -> Outcome:
    draft.event(one.code, one.agent, one.text, one.speed)
    return Outcome()


@_act.register
def _go_on(_one: do.GoOn, draft: Draft) -> Outcome:
    draft.end_waived = draft.ended or draft.end_waived
    draft.ended = False
    return Outcome()


@_act.register
def _save(one: do.SaveState, draft: Draft) -> Outcome:
    bare = msgspec.structs.replace(draft.finish(), kept=())
    draft.kept = (*draft.kept, KeptStart(one.slot, bare))[-SLOTS:]
    return Outcome()


@_act.register
def _restore(one: do.RestoreState, draft: Draft) -> Outcome:
    state = next((kept.state for kept in draft.kept if kept.slot == one.slot), None)
    if state is None:
        here = ", ".join(kept.slot for kept in draft.kept) or "none"
        return Outcome(code="not-found", text=f"no slot '{one.slot}' here; kept: {here}")
    revision = draft.revision + (state.setup.floor != draft.setup.floor)
    draft.take_up(state)
    draft.run, draft.revision, draft.event_count = one.run, revision, 0
    draft.event("reset", text=f"restored {one.slot}: tick {state.tick} of run {state.run}")
    return Outcome()


@_act.register
def _restart(one: do.Restart, draft: Draft) -> Outcome:
    """Begin again; bodies go where they started, or on another floor where there is room for their kind.

    Who joined later may have started where another had left: then both stand there, and either may leave.
    """
    old = draft.setup
    setup = Setup(
        floor=one.map or old.floor,
        seed=one.seed,
        period=old.period,
        say_limit=old.say_limit,
        say_range=old.say_range,
        say_walls=old.say_walls,
        say_loss=old.say_loss,
        say_delay=old.say_delay,
        command_timeout=old.command_timeout,
        truth=old.truth,
        end=one.end if one.end is not None else old.end,
        strict=old.strict,
    )
    if setup.end is not None:
        check_end(setup.end, setup.floor)
    try:
        walls = walls_of(setup.floor) if one.map is not None else draft.walls
    except ValueError as error:
        return Outcome(code="failed", text=f"floor '{setup.floor.name}': {error}")
    figures = {name: body_model_of(name, figure.robot, setup) for name, figure in draft.figures.items()}
    minds = {name: figure.mind_input for name, figure in draft.figures.items()}
    starts = {name: figure.start for name, figure in draft.figures.items()}
    crowd = Crowd(walls, setup.floor)
    placed: list[tuple[str, BodyModel, Position]] = []
    for name in sorted(figures):
        position = starts[name]
        if one.map is not None:
            try:
                position = place(figures[name], setup.floor, crowd)
            except RequestRefusedError as refusal:
                return Outcome(code="failed", refused=refusal.code, text=refusal.text)
        figure = msgspec.structs.replace(figures[name], start=position, mind_input=minds[name])
        crowd.add(name, figure, position.x, position.y, position.heading)
        placed.append((name, figure, position))
    halted = {name: flags[rows.HALTED] for name, flags in draft.flags.items()}
    draft.run, draft.tick, draft.setup, draft.walls = one.run, 0, setup, walls
    draft.figures, draft.numbers, draft.flags = {}, {}, {}
    draft.manners, draft.user, draft.forwarded = {}, {}, {}
    draft.heard = draft.coming = draft.spoken = ()
    draft.episodes, draft.event_count = no_episodes(), 0
    draft.revision += one.map is not None
    draft.ended = draft.end_waived = False
    draft.restarted, draft._crowd = True, crowd
    for name, figure, position in placed:
        draft.put(name, figure, position)
        draft.flags[name][rows.HALTED] = halted[name]
    for name, _, _ in placed:
        depth = crowd.depth_at(name)
        draft.numbers[name][rows.ALLOWED_PENETRATION] = depth if depth > TOUCH else 0.0
    draft.event("loaded" if one.map is not None else "reset", text=setup.floor.name if one.map is not None else None)
    return Outcome()


def _not_found(agent: str) -> Outcome:
    return Outcome(code="not-found", text=f"no agent '{agent}' here")
