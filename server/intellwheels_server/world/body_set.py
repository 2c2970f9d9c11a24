"""The bodies of a world as arrays, compiled when the set of bodies changes.

A body model is one body as accepted; a body set is all of them, sorted by name.
"""

from __future__ import annotations

import math
from collections.abc import Sequence, Set
from typing import TYPE_CHECKING, NamedTuple, TypeVar

import msgspec
import numpy as np

from intellwheels_schemas.errors import RequestRefusedError
from intellwheels_schemas.messages import Position, Robot
from intellwheels_schemas.rules import parts_of
from intellwheels_server.world.kernels.arrays import (
    Bodies,
    Box,
    Floats,
    Ints,
    Shape,
    bodies_from,
    key_of,
    radius_of,
    reordered,
)
from intellwheels_server.world.kernels.contact_steps import MOST_STEPS
from intellwheels_server.world.kernels.motor_model import MOTOR_ROWS, most_motion, motor_figures
from intellwheels_server.world.kernels.noise import noise_key
from intellwheels_server.world.kernels.wheel_slip import FLAW_ROWS, slip_figures
from intellwheels_server.world.sensors import SensorPlan, check_sensors, plan_sensors, rays_of

if TYPE_CHECKING:
    from intellwheels_server.world.state import Setup, State

_A = TypeVar("_A", Floats, Ints)

MOTOR_STREAM = "@motors"
"""The noise stream of the motors of a body. No sensor can have this id, as none starts with `@`."""


class BodyModel(msgspec.Struct, frozen=True, kw_only=True):
    """A body as accepted.

    Attributes:
        name: The name of its agent.
        robot: The robot as accepted, with its name.
        shape: Its parts, for the kernels.
        key: 53 bits of a hash of its name, by which kernels break ties.
        externally_posed: Whether it is a real chair, whose pose only its bridge sets.
        timeout: Steps after which a command no longer counts.
        start: Where it joined.
        rays: Rays per tick that its sensors cost.
        mind_input: The user input that a mind in a process of its own declared.
    """

    name: str
    robot: Robot
    shape: Shape
    key: int
    externally_posed: bool
    timeout: int
    start: Position
    rays: float = 0.0
    mind_input: tuple[str, ...] = ()

    @property
    def wants_user(self) -> bool:
        """Whether its measures carry the input of its user."""
        return bool(self.robot.user_input or self.mind_input)


class BodySet(msgspec.Struct, frozen=True, kw_only=True):
    """All bodies, in the order of the state's columns.

    Attributes:
        names: Sorted.
        index: Column of each name.
        by_key: The name of each key.
        models: The body of each name.
        bodies: Shapes, for contact and sensing.
        motors: float64[MOTOR_ROWS, n], motor parameters, rows of `kernels.motor_model`.
        flaws: float64[FLAW_ROWS, n]: how motors err and wheels slip, rows of `kernels.motor_noise` and `wheel_slip`.
        noise: uint64[2, n] viewed as int64, keys of the motor noise.
        limits: int64[2, n]: steps until a command times out; 1 for externally posed bodies, else 0.
        doors: int64[n], 1 for doors, which stop speech where walls do.
        plan: The sensors, compiled.
        rays: Rays per tick of all bodies.
        costliest: The body whose sensors cast the most rays, or None if none cast any.
    """

    names: tuple[str, ...]
    index: dict[str, int]
    by_key: dict[int, str]
    models: dict[str, BodyModel]
    bodies: Bodies
    motors: Floats
    flaws: Floats
    noise: Ints
    limits: Ints
    doors: Ints
    plan: SensorPlan
    rays: float
    costliest: str | None


def body_model_of(name: str, robot: Robot, setup: Setup) -> BodyModel:
    """Return a robot as a body of this world, not placed yet.

    Raises:
        RequestRefusedError: The robot asks for something that this world does not have.
    """
    if robot.role == "mind":
        raise RequestRefusedError("field", "Robot.Role: expected both or body, got 'mind'")
    robot = msgspec.structs.replace(robot, name=name, format=None)
    externally_posed = robot.type == "real"
    check_sensors(robot, setup.floor, truth=setup.truth, period=setup.period)
    parts = parts_of(robot)
    if not parts:
        raise RequestRefusedError(
            "field", "Robot: expected Length, Width, Center and Top, or at least 1 Part, got none"
        )
    boxes = [Box(part.x, part.y, part.length, part.width, part.bottom, part.top) for part in parts]
    if not externally_posed:
        _check_motion(robot, boxes, setup.period)
    timeout = setup.command_timeout if robot.command_timeout is None else robot.command_timeout
    return BodyModel(
        name=name,
        robot=robot,
        shape=Shape(
            name=name,
            boxes=boxes,
            externally_posed=externally_posed,
            anchored=robot.anchored,
        ),
        key=key_of(name),
        externally_posed=externally_posed,
        timeout=math.ceil(timeout / setup.period - 1e-9),
        start=Position(x=0.0, y=0.0, heading=0.0),
        rays=rays_of(robot),
    )


def _check_motion(robot: Robot, boxes: Sequence[Box], period: float) -> None:
    """Refuse a robot that could pass through something.

    No sub-step may move it farther than half its thinnest part. Then it leaves a wall on the side from which it came,
    however thin the wall is. And a tick has a largest number of sub-steps.
    """
    thinnest = min(min(box.length, box.width) for box in boxes)
    most, motion = 0.5 * thinnest * MOST_STEPS, most_motion(robot, period, radius_of(boxes))
    if motion > most:
        raise RequestRefusedError(
            "value",
            f"Robot: expected a body that moves at most {most:.3g} m in a tick, because its thinnest part measures "
            f"{thinnest:.3g} m, got {motion:.3g} m in a tick of {period:g} s; "
            "lower TopSpeed or TurnLimit, or give the simulation a shorter period",
        )


def assemble(
    models: dict[str, BodyModel], setup: Setup, tick: int, old: State | None, arrived: Set[str] = frozenset()
) -> tuple[BodySet, Floats]:
    """Return the body set of these models, and the array of the samples of their sensors.

    Args:
        models: The body of each name.
        setup: For the seed and the period.
        tick: The tick at which new sensors take their first sample.
        old: The state before. Bodies that stay keep their samples from it. None if there is none.
        arrived: Bodies that are new, even if a body of the same name was here before.
    """
    names = tuple(sorted(models))
    ordered = [models[name] for name in names]
    plan, samples = plan_sensors(
        [(model.robot, model.start) for model in ordered],
        setup.seed,
        setup.floor,
        tick,
        None if old is None else (old.body_set.plan, old.samples),
        arrived,
    )
    costliest = max(ordered, key=lambda model: model.rays, default=None)
    columns = _spliced(ordered, setup, old)
    body_set = BodySet(
        names=names,
        index={name: i for i, name in enumerate(names)},
        by_key={model.key: model.name for model in ordered},
        models={model.name: model for model in ordered},
        bodies=columns.bodies,
        motors=columns.motors,
        flaws=columns.flaws,
        noise=columns.noise,
        limits=columns.limits,
        doors=columns.doors,
        plan=plan,
        rays=sum(model.rays for model in ordered),
        costliest=costliest.name if costliest is not None and costliest.rays > 0.0 else None,
    )
    return body_set, samples


class _Columns(NamedTuple):
    """The arrays of a body set that have a column for each body: see `BodySet`."""

    bodies: Bodies
    motors: Floats
    flaws: Floats
    noise: Ints
    limits: Ints
    doors: Ints


def _columns(models: Sequence[BodyModel], setup: Setup) -> _Columns:
    keys = [noise_key(setup.seed, model.name, MOTOR_STREAM) for model in models]
    return _Columns(
        bodies=bodies_from([model.shape for model in models]),
        motors=_block([motor_figures(model.robot, setup.period) for model in models], MOTOR_ROWS),
        flaws=_block(
            [(model.robot.motor_noise, *slip_figures(model.robot, setup.period)) for model in models], FLAW_ROWS
        ),
        noise=np.array([[int(a) for a, _ in keys], [int(b) for _, b in keys]], dtype=np.uint64)
        .reshape(2, len(keys))
        .view(np.int64),
        limits=np.array(
            [[model.timeout for model in models], [int(model.externally_posed) for model in models]], dtype=np.int64
        ).reshape(2, len(models)),
        doors=np.array([model.robot.kind == "door" for model in models], dtype=np.int64),
    )


def _spliced(models: Sequence[BodyModel], setup: Setup, old: State | None) -> _Columns:
    """Return what `_columns` returns. Columns of bodies that stay are copied, not computed again."""
    if old is None or old.setup.seed != setup.seed or old.setup.period != setup.period:
        return _columns(models, setup)
    before = old.body_set
    fresh: list[BodyModel] = []
    order = []
    for model in models:
        known = before.models.get(model.name)
        if known is not None and (
            known is model
            or (known.robot is model.robot and known.shape is model.shape and known.timeout == model.timeout)
        ):
            order.append(before.index[model.name])
        else:
            order.append(len(before.names) + len(fresh))
            fresh.append(model)
    new, columns = _columns(fresh, setup), np.array(order, dtype=np.int64)
    return _Columns(
        bodies=reordered(before.bodies, new.bodies, columns),
        motors=_taken(before.motors, new.motors, columns),
        flaws=_taken(before.flaws, new.flaws, columns),
        noise=_taken(before.noise, new.noise, columns),
        limits=_taken(before.limits, new.limits, columns),
        doors=_taken(before.doors, new.doors, columns),
    )


def _taken(first: _A, second: _A, columns: Ints) -> _A:
    """Return columns of two blocks side by side."""
    return np.concatenate([first, second], axis=-1).take(columns, axis=-1)


def _block(columns: list[tuple[float, ...]], rows: int) -> Floats:
    """Return a row for each quantity, a column for each body."""
    return np.ascontiguousarray(np.array(columns, dtype=np.float64).reshape(-1, rows).T)
