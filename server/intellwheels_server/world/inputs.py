"""The inputs of the world at a tick. These records are also the lines of the input log.

Changes act at a tick, in the order given, before the measures of that tick. Actions, poses, user input and verdicts act
on the step from that tick to the next.
"""

from __future__ import annotations

from typing import Literal

import msgspec

from intellwheels_schemas.messages import Actions, End, EventCode, Map, Pose, Position, Robot, UserInput


class Join(msgspec.Struct, frozen=True, kw_only=True, rename="pascal", omit_defaults=True, tag="Join", tag_field="Do"):
    """An agent joins with a body or, with role `mind`, as the mind of a body that is here.

    The service has checked name, token and session; the world checks the robot and finds its place.
    """

    agent: str
    robot: Robot


class Depart(
    msgspec.Struct, frozen=True, kw_only=True, rename="pascal", omit_defaults=True, tag="Depart", tag_field="Do"
):
    """A role of an agent ends: it left, or its token was gone for longer than the grace time."""

    agent: str
    role: Literal["both", "body", "mind"] = "both"
    lost: bool = False


class SpawnBody(
    msgspec.Struct, frozen=True, kw_only=True, rename="pascal", omit_defaults=True, tag="Spawn", tag_field="Do"
):
    """An operator adds a body without a mind; `robot.name` is its name."""

    robot: Robot
    position: Position | None = None


class DeleteBody(
    msgspec.Struct, frozen=True, kw_only=True, rename="pascal", omit_defaults=True, tag="Delete", tag_field="Do"
):
    """An operator removes a body."""

    agent: str


class TeleportBody(
    msgspec.Struct, frozen=True, kw_only=True, rename="pascal", omit_defaults=True, tag="Teleport", tag_field="Do"
):
    """An operator moves a body to another pose; with `force`, even where it overlaps something."""

    agent: str
    position: Position
    force: bool = False


class TakeBody(
    msgspec.Struct, frozen=True, kw_only=True, rename="pascal", omit_defaults=True, tag="Take", tag_field="Do"
):
    """From now on the simulator obeys the user of a body instead of its mind; with `on=False`, no longer."""

    agent: str
    on: bool = True


class Speech(
    msgspec.Struct, frozen=True, kw_only=True, rename="pascal", omit_defaults=True, tag="Speech", tag_field="Do"
):
    """An operator says something, which one agent or all agents hear at the next tick."""

    text: str
    to: str | None = None


class Note(msgspec.Struct, frozen=True, kw_only=True, rename="pascal", omit_defaults=True, tag="Note", tag_field="Do"):
    """An event that changes no body: paused, resumed, speed, lost, returned."""

    code: EventCode
    agent: str | None = None
    speed: float | None = None
    text: str | None = None


class Restart(
    msgspec.Struct, frozen=True, kw_only=True, rename="pascal", omit_defaults=True, tag="Restart", tag_field="Do"
):
    """A reset or, with a map, a load: a new run at tick 0 with the same bodies where they started."""

    run: str
    seed: str
    map: Map | None = None
    end: End | None = None


class SaveState(
    msgspec.Struct, frozen=True, kw_only=True, rename="pascal", omit_defaults=True, tag="Save", tag_field="Do"
):
    """Save the state that the changes before this one led to."""

    slot: str


class RestoreState(
    msgspec.Struct, frozen=True, kw_only=True, rename="pascal", omit_defaults=True, tag="Restore", tag_field="Do"
):
    """Return to a saved state and its tick, as a new run."""

    slot: str
    run: str


class GoOn(msgspec.Struct, frozen=True, kw_only=True, rename="pascal", omit_defaults=True, tag="GoOn", tag_field="Do"):
    """Continue after the end: the end condition no longer counts."""


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
    """What an agent said with `in/<agent>/say`."""

    agent: str
    text: str
    seq: int | None = None


class Verdict(msgspec.Struct, frozen=True, kw_only=True, rename="pascal", omit_defaults=True):
    """What the service, which has a clock, found out about an agent.

    `late`: no answer by the deadline. `rested`: put to rest, until `back`. `silent`: no user input for 0.3 s. `stale`:
    no pose of a real body for too long, until `fresh`. `halt`: the motors of a real body get 0, as the run is paused
    or its speed is not 1, until `unhalt`.
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
