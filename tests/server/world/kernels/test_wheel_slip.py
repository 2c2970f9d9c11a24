"""Blocked wheels roll on by the share that the robot declares."""

import numpy as np
import pytest

from intellwheels_schemas.messages import Robot
from intellwheels_server.world.kernels.wheel_slip import FLAW_ROWS, SLIP, rolled_while_blocked, slip_figures


@pytest.mark.parametrize(("slip", "rolled"), [(0.0, (0.01, 0.0)), (0.25, (0.0325, 0.05)), (1.0, (0.1, 0.2))])
def test_wheels_roll_on_by_a_share_of_the_motion_denied(slip: float, rolled: tuple[float, float]) -> None:
    flaws = np.zeros((FLAW_ROWS, 1))
    flaws[SLIP:FLAW_ROWS, 0] = slip_figures(Robot(slip=slip), 0.05)
    assert rolled_while_blocked(flaws, 0, 0.1, 0.2, 0.01, 0.0, 7, 0.05) == pytest.approx(rolled, abs=1e-15)
