import itertools
import math
from collections.abc import Sequence
from typing import Literal

import msgspec
import numpy as np
import pytest

from intellwheels_maps import names, robot
from intellwheels_schemas.errors import RequestRefusedError
from intellwheels_schemas.file_records import Change, Depart, Inputs, Join
from intellwheels_schemas.messages import IMU, Actions, Corner, Lidar, Part, Position, Proximity, Robot, Wall
from intellwheels_server.world import advance, apply, begin
from intellwheels_server.world.body_set import assemble, body_model_of
from intellwheels_server.world.kernels import rows
from intellwheels_server.world.kernels.arrays import ANCHORED, EXTERNALLY_POSED, KEY
from intellwheels_server.world.kernels.motor_model import (
    MOTOR_ACCELERATION,
    MOTOR_KEPT,
    MOTOR_ROWS,
    MOTOR_TOP_SPEED,
    MOTOR_TRACK,
)
from intellwheels_server.world.state import Setup
from tests.every_case import every_case
from tests.server.worlds import RUN, cart, floor_of


def test_model_has_the_robot_as_accepted() -> None:
    model = body_model_of("a", cart(format="iw.v1", command_timeout=0.12), Setup(floor=floor_of()))
    assert (model.robot.name, model.robot.format) == ("a", None)
    # 0.12 s is over in three steps of 0.05 s.
    assert model.timeout == 3
    assert body_model_of("a", cart(), Setup(floor=floor_of())).timeout == 10


def test_body_without_parts_is_refused() -> None:
    with pytest.raises(RequestRefusedError, match="at least 1 Part, got none"):
        body_model_of("a", Robot(), Setup(floor=floor_of()))


def test_arrays_of_a_body_set_are_in_the_order_of_names() -> None:
    setup = Setup(floor=floor_of())
    parts = (Part(x=0.0, y=0.0, length=1.0, width=1.0, bottom=0.0, top=1.0),) * 2
    robots = {
        "b": cart(track=0.4, acceleration_curve=0.5, acceleration_limit=2.0),
        "a": cart(length=None, width=None, center=None, top=None, part=parts, anchored=True, type="real"),
    }
    body_set, samples = assemble(
        {name: body_model_of(name, robot, setup) for name, robot in robots.items()}, setup, 0, None
    )
    assert body_set.names == ("a", "b")
    assert body_set.bodies.part_start.tolist() == [0, 2, 3]
    assert body_set.bodies.marks[[EXTERNALLY_POSED, ANCHORED]].tolist() == [[1, 0], [1, 0]]
    assert [body_set.by_key[int(key)] for key in body_set.bodies.marks[KEY]] == ["a", "b"]
    assert body_set.motors[[MOTOR_TRACK, MOTOR_TOP_SPEED, MOTOR_KEPT, MOTOR_ACCELERATION], 1].tolist() == [
        0.4,
        1.0,
        0.5,
        2.0,
    ]
    assert body_set.limits.tolist() == [[10, 10], [1, 0]]
    assert samples.shape == (0,)


def test_body_set_may_be_empty() -> None:
    body_set, _ = assemble({}, Setup(floor=floor_of()), 0, None)
    assert body_set.motors.shape == (MOTOR_ROWS, 0)
    assert body_set.noise.shape == (2, 0)


def fast_setup(period: float, walls: Sequence[Wall] = ()) -> Setup:
    return Setup(floor=floor_of(walls), period=period)


def test_body_that_could_pass_through_something_is_refused_in_words() -> None:
    with pytest.raises(RequestRefusedError) as refused:
        body_model_of("a", cart(length=0.05, width=0.05, top_speed=50.0, turn_limit=1.0), fast_setup(1.0))
    assert refused.value.code == "value"
    assert refused.value.text == (
        "Robot: expected a body that moves at most 25.6 m in a tick, because its thinnest part measures 0.05 m, "
        "got 50 m in a tick of 1 s; lower TopSpeed or TurnLimit, or give the simulation a shorter period"
    )
    assert body_model_of("a", cart(length=0.05, width=0.05, top_speed=50.0, turn_limit=1.0), fast_setup(0.5))


def test_real_body_is_taken_at_any_speed_because_its_bridge_moves_it() -> None:
    assert body_model_of("a", cart(length=0.05, width=0.05, top_speed=50.0, type="real"), fast_setup(1.0))


@every_case("name", names("robots"))
def test_included_robots_are_accepted_with_every_period(name: str) -> None:
    assert body_model_of("a", robot(name), fast_setup(1.0))


SIZES = (0.001, 0.01, 0.05, 0.6)
SPEEDS = (0.5, 5.0, 50.0)
PERIODS = (0.001, 0.05, 0.3, 1.0)
THICKNESSES = (1e-9, 1e-3, 0.02, 0.2)
HEADINGS = (0.0, 0.4, 1.2)


@pytest.mark.parametrize("period", PERIODS)
@pytest.mark.parametrize("speed", SPEEDS)
def test_no_accepted_body_passes_a_wall(speed: float, period: float) -> None:
    # A wall before each body, all in one line, and each longer than a body moves in three ticks.
    reach = 4.0 * speed * period + 5.0
    lanes = {f"a{k}": (2.0 * reach * k, *way) for k, way in enumerate(itertools.product(THICKNESSES, HEADINGS))}
    walls = [
        Wall(thickness=thickness, corner=(Corner(x=0.0, y=y - reach), Corner(x=0.0, y=y + reach)))
        for y, thickness, _ in lanes.values()
    ]
    for length, width in itertools.product(SIZES, SIZES):
        model = cart(length=length, width=width, top_speed=speed)
        joins = []
        for name, (y, thickness, heading) in lanes.items():
            x = -0.6 * speed * period - 0.5 * (math.hypot(length, width) + thickness) - 0.001
            at = Position(x=x, y=y, heading=heading)
            joins.append(Join(agent=name, robot=msgspec.structs.replace(model, position=at)))
        state, outputs = apply(begin(fast_setup(period, walls), RUN), joins)
        refused = [outcome.text for outcome in outputs.outcomes if outcome.code != "ok"]
        assert all("Robot: expected a body that moves at most" in text for text in refused)
        assert len(refused) in {0, len(lanes)}
        actions = {name: Actions(left_motor=1.0, right_motor=0.98) for name in state.names}
        for _ in range(0 if refused else 3):
            state, _ = advance(state, Inputs(actions=actions))
        for name, x in zip(state.names, state.numbers[rows.X], strict=True):
            assert x < 0.0, (length, width, *lanes[name])


def eyes(count: int, model: Literal["ideal", "infrared", "sonar"] = "ideal") -> tuple[Proximity, ...]:
    eye = Proximity(id="e", x=0.5, y=0.0, z=0.4, direction_deg=0.0, cone_deg=30.0, max_range=4.0, model=model)
    slow = {"every": 4, "latency": 2, "crosstalk": 1.0} if model == "sonar" else {}
    return tuple(
        msgspec.structs.replace(eye, id=f"{model}{k}", mount="start" if k % 2 else "body", **slow) for k in range(count)
    )


def test_bodies_that_come_and_go_leave_the_arrays_that_all_bodies_together_have() -> None:
    robots = {
        "m": cart(proximity=eyes(3, "infrared") + eyes(2, "sonar") + eyes(1), imu=(IMU(id="i"),)),
        "c": cart(
            proximity=eyes(2),
            lidar=(Lidar(id="l", x=0.0, y=0.0, z=0.3, direction_deg=0.0, fov_deg=90.0, rays=4, max_range=5.0),),
        ),
        "x": cart(part=(Part(x=0.0, y=0.0, length=0.5, width=0.4, bottom=0.0, top=1.0),) * 2, length=None, width=None),
        "a": cart(kind="door", anchored=True, proximity=eyes(1, "sonar")),
        "g": cart(proximity=eyes(4), motor_noise=0.1, imu=(IMU(id="i"),)),
    }

    def joined(*names: str) -> list[Change]:
        return [
            Join(
                agent=name,
                robot=msgspec.structs.replace(
                    robots[name], position=Position(x=3.0 * (ord(name) - ord("a")), y=0.0, heading=0.5)
                ),
            )
            for name in names
        ]

    def gone(name: str) -> list[Change]:
        return [Depart(agent=name)]

    setup = Setup(floor=floor_of(), seed="7")
    state = begin(setup, RUN)
    for changes in (
        joined("m", "x"), joined("c"), gone("x"), joined("x", "a"), gone("m") + joined("g", "m"), gone("c"),
    ):  # fmt: skip
        state, outputs = apply(state, changes)
        assert [outcome.code for outcome in outputs.outcomes] == ["ok"] * len(changes)
        anew, samples = assemble(dict(state.body_set.models), setup, 0, None)
        assert samples.shape == state.samples.shape
        assert (anew.names, anew.index, anew.by_key) == (
            state.names,
            state.body_set.index,
            state.body_set.by_key,
        )
        assert numbers_in(anew.bodies) == numbers_in(state.body_set.bodies)
        for name in ("motors", "flaws", "noise", "limits", "doors"):
            assert numbers_in(getattr(anew, name)) == numbers_in(getattr(state.body_set, name))
        assert numbers_in((anew.plan.memory, anew.plan.spans)) == numbers_in(
            (state.body_set.plan.memory, state.body_set.plan.spans)
        )
        assert len(anew.plan.blocks) == len(state.body_set.plan.blocks)
        for block, there in zip(anew.plan.blocks, state.body_set.plan.blocks, strict=True):
            assert numbers_in(vars(block)) == numbers_in(vars(there))


def numbers_in(value: object) -> list[object]:
    """Return the types, shapes and bytes of all arrays in blocks, tuples and dictionaries."""
    if isinstance(value, np.ndarray):
        assert value.flags.c_contiguous
        return [str(value.dtype), value.shape, value.tobytes()]
    if isinstance(value, dict):
        return [(key, numbers_in(one)) for key, one in value.items()]
    if isinstance(value, tuple):
        return [numbers_in(one) for one in value]
    return [value]
