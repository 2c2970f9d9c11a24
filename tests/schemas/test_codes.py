from __future__ import annotations

from typing import get_args

from intellwheels_schemas import codes
from intellwheels_schemas.channels import CHANNELS, VERB_CLASSES
from intellwheels_schemas.messages import ERROR_CODES, EVENT_CODES, REFUSED_CODES, RESULT_CODES, MotorState


def test_every_code_has_a_meaning() -> None:
    assert tuple(codes.REFUSED) == REFUSED_CODES
    assert tuple(codes.ERROR) == ERROR_CODES
    assert tuple(codes.EVENT) == EVENT_CODES
    assert tuple(codes.RESULT) == RESULT_CODES
    assert tuple(codes.MOTOR_STATE) == get_args(MotorState)
    assert codes.ROS_RESULT.keys() == codes.RESULT.keys()


def test_every_verb_says_what_it_is_in_ros() -> None:
    assert codes.ROS_VERB.keys() == VERB_CLASSES.keys()
    assert codes.ROS_KEY.keys() <= CHANNELS.keys()
