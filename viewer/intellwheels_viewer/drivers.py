"""Who drives a body, in plain words, and whether its chair is real. Pure.

All of it follows from what the simulator publishes: the document and the roles of a body, its state, the input of its
user in its measures. The name of a mind is not published.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Literal

from intellwheels_schemas.rules import has_motors, is_mobile

if TYPE_CHECKING:
    from intellwheels_schemas.messages import Body, Entity, Measures, Robot

Reality = Literal["real", "stand-in", "simulated"]

OF_A_PERSON: Final = frozenset(("drive", "words"))
"""Inputs by which a person steers; a goal is given to a program, which steers."""


def reality_of(robot: Robot) -> Reality:
    """Return what moves a body: a real robot, a real robot's bridge on simulated hardware, or the simulator."""
    if robot.type != "real":
        return "simulated"
    return "stand-in" if robot.hardware == "simulated" else "real"


def reality_words(robot: Robot) -> str:
    """Return what moves a body, in words; empty if it is simulated, as most are."""
    return {"real": f"real {_noun(robot)}", "stand-in": f"stand-in for a real {_noun(robot)}", "simulated": ""}[
        reality_of(robot)
    ]


def driver_of(entity: Entity, body: Body, measures: Measures | None = None, *, here: bool = False) -> str:
    """Return who drives a body, such as "driven by a program".

    Args:
        entity: Its state.
        body: Its document.
        measures: Its newest measures, if they are subscribed: they tell whether a person's input arrives.
        here: Whether the page that asks drives it.
    """
    robot = body.robot
    drives = robot.kind != "person" and (is_mobile(robot) or not has_motors(robot))
    verb = "driven" if drives else "moved"
    if here:
        return f"{verb} by you, in this page"
    if entity.state == "taken":
        return f"{verb} by an operator who took it over"
    if not has_motors(robot) or not (_has_mind(body) or entity.mode):
        return "nobody drives it" if drives else "nobody moves it"
    program = f"{verb} by a program"
    if not OF_A_PERSON.intersection(robot.user_input):
        return program
    if measures is not None and measures.user_input is None:
        return "waits for a person at a joystick"
    return f"{verb} by a person at a joystick"


def _has_mind(body: Body) -> bool:
    """Return whether a program has joined that commands the body.

    A playback does not name a mind of its own process; it is known by what it says that it does.
    """
    if body.roles:
        return any(role in ("mind", "both") for role in body.roles)
    return body.robot.instance is not None and body.robot.role != "body"


def _noun(robot: Robot) -> str:
    return "chair" if robot.kind == "wheelchair" else "robot"
