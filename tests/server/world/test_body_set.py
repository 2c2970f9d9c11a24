import pytest

from intellwheels_schemas.errors import RequestRefusedError
from intellwheels_schemas.messages import Part, Robot
from intellwheels_server.world.body_set import assemble, body_model_of
from intellwheels_server.world.kernels.arrays import ANCHORED, EXTERNALLY_POSED, KEY
from intellwheels_server.world.kernels.motor_model import MOTOR_ACCELERATION, MOTOR_KEPT, MOTOR_TOP_SPEED, MOTOR_TRACK
from intellwheels_server.world.state import Setup
from tests.server.worlds import cart, floor_of


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
    assert body_set.motors.shape == (8, 0)
    assert body_set.noise.shape == (2, 0)
