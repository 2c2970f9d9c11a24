import numpy as np
import pytest

from intellwheels_server.world.kernels import command
from intellwheels_server.world.kernels.motion import TOP_SPEED
from intellwheels_server.world.kernels.noise import noise_key
from intellwheels_server.world.kernels.rows import (
    COMMAND_AGE,
    FLAG_ROWS,
    HALTED,
    LEFT_COMMAND,
    LEFT_POWER,
    NUMBER_ROWS,
    POSE_AGE,
    RIGHT_COMMAND,
    RIGHT_POWER,
    SILENT,
    STALE,
    TAKEN,
    TIMED_OUT,
    USER_AGE,
    USER_FORWARD,
)


class One:
    """One body that has just been told (0.5, 0.4)."""

    def __init__(self) -> None:
        self.numbers = np.zeros((NUMBER_ROWS, 1))
        self.flags = np.zeros((FLAG_ROWS, 1), dtype=np.int64)
        self.motors = np.ones((8, 1))
        self.limits = np.array([[10], [0]], dtype=np.int64)
        self.numbers[LEFT_COMMAND], self.numbers[RIGHT_COMMAND] = 0.5, 0.4

    def step(self, silence: int = -1, staleness: int = -1) -> int:
        return int(command.powers(self.numbers, self.flags, self.motors, self.limits, silence, staleness))

    @property
    def power(self) -> tuple[float, float]:
        return float(self.numbers[LEFT_POWER, 0]), float(self.numbers[RIGHT_POWER, 0])


def test_command_is_in_force_for_as_many_steps_as_its_time_out() -> None:
    one = One()
    found = [(one.step(), one.power) for _ in range(12)]
    assert [power for _, power in found] == [(0.5, 0.4)] * 10 + [(0.0, 0.0)] * 2
    assert [code for code, _ in found] == [0] * 10 + [command.NOW_TIMED_OUT, 0]
    one.flags[COMMAND_AGE] = 0
    assert one.step() == 0
    assert one.power == (0.5, 0.4)
    assert one.flags[TIMED_OUT, 0] == 0


def test_body_without_motors_is_never_timed_out() -> None:
    one = One()
    one.motors[TOP_SPEED] = 0.0
    assert not any(one.step() for _ in range(20))


def test_taken_body_obeys_the_user_even_after_its_mind_fell_silent() -> None:
    one = One()
    one.flags[TAKEN] = 1
    one.flags[COMMAND_AGE] = 100
    one.numbers[USER_FORWARD] = 0.3
    one.step()
    assert one.power == (0.3, 0.3)


def test_user_is_silent_after_so_many_steps_and_wants_nothing() -> None:
    one = One()
    one.flags[TAKEN] = 1
    one.numbers[USER_FORWARD] = 0.3
    found = [(one.step(silence=6), one.power[0]) for _ in range(8)]
    assert [power for _, power in found] == [0.3] * 6 + [0.0] * 2
    assert [code & command.NOW_SILENT for code, _ in found] == [0] * 6 + [command.NOW_SILENT, 0]
    assert one.flags[SILENT, 0] == 1


def test_only_a_real_body_s_pose_goes_stale() -> None:
    one = One()
    assert not any(one.step(staleness=6) & command.NOW_STALE for _ in range(10))
    one = One()
    one.limits[command.REAL] = 1
    assert [one.step(staleness=6) & command.NOW_STALE for _ in range(8)] == [0] * 6 + [command.NOW_STALE, 0]
    assert one.power == (0.0, 0.0)


@pytest.mark.parametrize("row", [HALTED, STALE])
def test_halt_and_a_stale_pose_come_before_everything(row: int) -> None:
    one = One()
    one.flags[TAKEN] = 1
    one.numbers[USER_FORWARD] = 0.3
    one.flags[row] = 1
    one.step()
    assert one.power == (0.0, 0.0)


@pytest.mark.parametrize(
    ("forward", "turn", "expected"),
    [(1.0, 0.0, (1.0, 1.0)), (0.0, 1.0, (-1.0, 1.0)), (1.0, 1.0, (0.0, 1.0)), (-0.5, 0.25, (-0.75, -0.25))],
)
def test_user_power(forward: float, turn: float, expected: tuple[float, float]) -> None:
    assert command.user_power(forward, turn) == expected


def test_ages_count_steps() -> None:
    one = One()
    one.step()
    one.step()
    assert one.flags[[COMMAND_AGE, USER_AGE, POSE_AGE], 0].tolist() == [2, 2, 2]


def test_motor_noise_is_a_factor_with_its_standard_deviation() -> None:
    numbers = np.zeros((NUMBER_ROWS, 1))
    numbers[LEFT_POWER], numbers[RIGHT_POWER] = 0.5, 0.0
    flaws = np.array([[0.1], [0.0]])
    keys = np.array([[int(half.view(np.int64))] for half in noise_key("1", "a", "@motors")], dtype=np.int64)
    power = np.empty((2, 1))
    left = []
    for tick in range(4000):
        command.noisy_powers(numbers, flaws, keys, tick, power)
        left.append(power[0, 0] / 0.5 - 1.0)
        assert power[1, 0] == 0.0
    # Both within four standard errors: sd/sqrt(n) and sd/sqrt(2 n).
    assert np.mean(left) == pytest.approx(0.0, abs=4 * 0.1 / np.sqrt(4000))
    assert np.std(left) == pytest.approx(0.1, abs=4 * 0.1 / np.sqrt(8000))
