import numpy as np
import pytest

from intellwheels_server.world.kernels import motor_power, rows
from intellwheels_server.world.kernels.motor_model import MOTOR_ROWS, MOTOR_TOP_SPEED


class One:
    """One body that has just been told (0.5, 0.4)."""

    def __init__(self) -> None:
        self.numbers = np.zeros((rows.NUMBER_ROWS, 1))
        self.flags = np.zeros((rows.FLAG_ROWS, 1), dtype=np.int64)
        self.motors = np.ones((MOTOR_ROWS, 1))
        self.limits = np.array([[10], [0]], dtype=np.int64)
        self.numbers[rows.LEFT_COMMAND], self.numbers[rows.RIGHT_COMMAND] = 0.5, 0.4

    def step(self, silence: int = -1, staleness: int = -1) -> int:
        return int(motor_power.powers(self.numbers, self.flags, self.motors, self.limits, silence, staleness))

    @property
    def power(self) -> tuple[float, float]:
        return float(self.numbers[rows.LEFT_POWER, 0]), float(self.numbers[rows.RIGHT_POWER, 0])


def test_command_is_in_force_for_as_many_steps_as_its_time_out() -> None:
    one = One()
    found = [(one.step(), one.power) for _ in range(12)]
    assert [power for _, power in found] == [(0.5, 0.4)] * 10 + [(0.0, 0.0)] * 2
    assert [code for code, _ in found] == [0] * 10 + [motor_power.NOW_TIMED_OUT, 0]
    one.flags[rows.COMMAND_AGE] = 0
    assert one.step() == 0
    assert one.power == (0.5, 0.4)
    assert one.flags[rows.TIMED_OUT, 0] == 0


def test_body_without_motors_is_never_timed_out() -> None:
    one = One()
    one.motors[MOTOR_TOP_SPEED] = 0.0
    assert not any(one.step() for _ in range(20))


def test_taken_body_obeys_the_user_even_after_its_mind_fell_silent() -> None:
    one = One()
    one.flags[rows.TAKEN] = 1
    one.flags[rows.COMMAND_AGE] = 100
    one.numbers[rows.USER_FORWARD] = 0.3
    one.step()
    assert one.power == (0.3, 0.3)


def test_user_is_silent_after_so_many_steps_and_wants_nothing() -> None:
    one = One()
    one.flags[rows.TAKEN] = 1
    one.numbers[rows.USER_FORWARD] = 0.3
    found = [(one.step(silence=6), one.power[0]) for _ in range(8)]
    assert [power for _, power in found] == [0.3] * 6 + [0.0] * 2
    assert [code & motor_power.NOW_SILENT for code, _ in found] == [0] * 6 + [motor_power.NOW_SILENT, 0]
    assert one.flags[rows.SILENT, 0] == 1


def test_only_a_real_body_s_pose_goes_stale() -> None:
    one = One()
    assert not any(one.step(staleness=6) & motor_power.NOW_STALE for _ in range(10))
    one = One()
    one.limits[motor_power.REAL] = 1
    assert [one.step(staleness=6) & motor_power.NOW_STALE for _ in range(8)] == [0] * 6 + [motor_power.NOW_STALE, 0]
    assert one.power == (0.0, 0.0)


@pytest.mark.parametrize("row", [rows.HALTED, rows.STALE])
def test_halt_and_a_stale_pose_come_before_everything(row: int) -> None:
    one = One()
    one.flags[rows.TAKEN] = 1
    one.numbers[rows.USER_FORWARD] = 0.3
    one.flags[row] = 1
    one.step()
    assert one.power == (0.0, 0.0)


@pytest.mark.parametrize(
    ("forward", "turn", "expected"),
    [(1.0, 0.0, (1.0, 1.0)), (0.0, 1.0, (-1.0, 1.0)), (1.0, 1.0, (0.0, 1.0)), (-0.5, 0.25, (-0.75, -0.25))],
)
def test_user_power(forward: float, turn: float, expected: tuple[float, float]) -> None:
    assert motor_power.user_power(forward, turn) == expected


def test_ages_count_steps() -> None:
    one = One()
    one.step()
    one.step()
    assert one.flags[[rows.COMMAND_AGE, rows.USER_AGE, rows.POSE_AGE], 0].tolist() == [2, 2, 2]
