"""The mind that drives exactly as its user wants."""

from __future__ import annotations

from intellwheels_agents.minds.joystick import Mind, equip
from intellwheels_agents.options import Options
from intellwheels_maps import robot
from intellwheels_schemas.messages import Measures, UserInput
from tests.agents.arena import Arena
from tests.agents.kinematics import RUN, context


def powers(user: UserInput | None, **options: str) -> tuple[float | None, float | None]:
    actions = Mind(context(robot("rear-wheel"), None, **options)).decide(
        Measures(run=RUN, tick=0, time=0.0, user_input=user)
    )
    return actions.left_motor, actions.right_motor


def test_powers_follow_the_user_and_are_0_without_one() -> None:
    assert powers(UserInput(forward=0.5, turn=0.25)) == (0.25, 0.75)
    assert powers(UserInput(forward=1.0, turn=-1.0)) == (1.0, 0.0)
    assert powers(None) == (0.0, 0.0)
    assert powers(UserInput()) == (0.0, 0.0)


def test_options_scale_the_powers() -> None:
    assert powers(UserInput(forward=1.0, turn=1.0), speed="0.5", turn="0.25") == (0.25, 0.75)
    assert powers(UserInput(word="back"), words="0.2") == (-0.2, -0.2)


def test_robot_declares_user_input() -> None:
    assert equip(robot("rear-wheel"), Options()).user_input == ("drive", "words")


def test_chair_of_a_silent_user_stops() -> None:
    arena = Arena("corridor15m")
    arena.join("chair1", "joystick", "rear-wheel", "start", {"AccelerationCurve": "0"})
    arena.users["chair1"] = UserInput(forward=0.5)
    arena.run(1.0)
    assert arena.speed("chair1") == 0.5
    del arena.users["chair1"]
    assert arena.run(2.0, until=lambda arena: arena.speed("chair1") == 0.0) <= 0.3 + 0.05 + 1e-9
