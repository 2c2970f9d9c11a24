"""What goes into the world at a tick. These records are also the lines of the input log.

Changes act at a tick before its measures are taken, in the order given; actions, poses, user
input and verdicts act on the step from that tick to the next.
"""

from __future__ import annotations

from typing import Literal

import msgspec

from intellwheels_schemas.messages import Actions, End, EventCode, Map, Pose, Position, Robot, UserInput


class Join(msgspec.Struct, frozen=True, kw_only=True, rename="pascal", omit_defaults=True, tag="Join", tag_field="Do"):
    """An agent wants a body, or with role `mind` the mind's place at a body that is there.

    The service has checked name, token and session; the world checks the robot and finds the place.
    """

    agent: str
    robot: Robot


class Depart(
    msgspec.Struct, frozen=True, kw_only=True, rename="pascal", omit_defaults=True, tag="Depart", tag_field="Do"
):
    """An agent's role ends: it left, or its token was lost for longer than the grace time."""

    agent: str
    role: Literal["both", "body", "mind"] = "both"
    lost: bool = False


class SpawnBody(
    msgspec.Struct, frozen=True, kw_only=True, rename="pascal", omit_defaults=True, tag="Spawn", tag_field="Do"
):
    """An operator puts a body without a mind somewhere; `robot.name` names it."""

    robot: Robot
    position: Position | None = None


class DeleteBody(
    msgspec.Struct, frozen=True, kw_only=True, rename="pascal", omit_defaults=True, tag="Delete", tag_field="Do"
):
    """An operator takes a body out."""

    agent: str


class TeleportBody(
    msgspec.Struct, frozen=True, kw_only=True, rename="pascal", omit_defaults=True, tag="Teleport", tag_field="Do"
):
    """An operator puts a body somewhere else; with `force` even where it overlaps something."""

    agent: str
    position: Position
    force: bool = False


class TakeBody(
    msgspec.Struct, frozen=True, kw_only=True, rename="pascal", omit_defaults=True, tag="Take", tag_field="Do"
):
    """The simulator obeys the user's input from now on, or with `on=False` no longer."""

    agent: str
    on: bool = True


class Speech(
    msgspec.Struct, frozen=True, kw_only=True, rename="pascal", omit_defaults=True, tag="Speech", tag_field="Do"
):
    """An operator's words, heard at the next tick by one agent or by all."""

    text: str
    to: str | None = None


class Note(msgspec.Struct, frozen=True, kw_only=True, rename="pascal", omit_defaults=True, tag="Note", tag_field="Do"):
    """Something for the event list that changes no body: paused, resumed, speed, lost, returned."""

    code: EventCode
    agent: str | None = None
    speed: float | None = None
    text: str | None = None


class Restart(
    msgspec.Struct, frozen=True, kw_only=True, rename="pascal", omit_defaults=True, tag="Restart", tag_field="Do"
):
    """Reset, and with a map load: a new run at tick 0 with the same bodies at their starts."""

    run: str
    seed: str
    map: Map | None = None
    end: End | None = None


class SaveState(
    msgspec.Struct, frozen=True, kw_only=True, rename="pascal", omit_defaults=True, tag="Save", tag_field="Do"
):
    """Keep the state as the changes before this one left it."""

    slot: str


class RestoreState(
    msgspec.Struct, frozen=True, kw_only=True, rename="pascal", omit_defaults=True, tag="Restore", tag_field="Do"
):
    """Go back to a state that was kept, at its tick, as a new run."""

    slot: str
    run: str


class GoOn(msgspec.Struct, frozen=True, kw_only=True, rename="pascal", omit_defaults=True, tag="GoOn", tag_field="Do"):
    """Step on after the end: the end condition no longer counts."""


Change = (
    Join
    | Depart
    | SpawnBody
    | DeleteBody
    | TeleportBody
    | TakeBody
    | Speech
    | Note
    | Restart
    | SaveState
    | RestoreState
    | GoOn
)

VerdictCode = Literal["late", "rested", "back", "silent", "stale", "fresh", "halt", "unhalt"]


class Said(msgspec.Struct, frozen=True, kw_only=True, rename="pascal", omit_defaults=True):
    """What an agent said by `in/<agent>/say`."""

    agent: str
    text: str
    seq: int | None = None


class Verdict(msgspec.Struct, frozen=True, kw_only=True, rename="pascal", omit_defaults=True):
    """What the pace keeper, which has a clock, found of an agent.

    `late`: no answer by the deadline. `rested`: put to rest until `back`. `silent`: no user input for
    0.3 s. `stale`: no pose of a real body for too long, until `fresh`. `halt`: motors of a real body get 0
    (paused, or a speed other than 1) until `unhalt`.
    """

    agent: str
    code: VerdictCode


class Inputs(msgspec.Struct, frozen=True, kw_only=True, rename="pascal", omit_defaults=True):
    """Everything that acts on one step."""

    changes: tuple[Change, ...] = ()
    actions: dict[str, Actions] = {}
    says: tuple[Said, ...] = ()
    poses: dict[str, Pose] = {}
    user_input: dict[str, UserInput] = {}
    verdicts: tuple[Verdict, ...] = ()
