"""Who writes what, where, how often and how urgently: the table of the contract, as data.

Nothing that fans out may block: one stuck reader would stop everybody. What must not be lost is
a query, what is periodic is a put.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

from intellwheels_schemas.messages import (
    Actions,
    Body,
    Clock,
    CrewActions,
    CrewMeasures,
    Delete,
    Error,
    Event,
    Events,
    Joined,
    Leave,
    Load,
    Map,
    MapInfo,
    Measures,
    OperatorSay,
    Pause,
    Pose,
    PowerInForce,
    Quit,
    Record,
    Refused,
    Reset,
    Restore,
    Result,
    Resume,
    Robot,
    Save,
    Say,
    Seek,
    Spawn,
    Speed,
    Step,
    Take,
    Teleport,
    UserInput,
    WorldState,
)

PriorityName = Literal["real-time", "interactive-high", "data-high", "data", "data-low"]


@dataclass(frozen=True, slots=True)
class Channel:
    """A key of the contract.

    Attributes:
        key: After `iw/v1/<world>/`.
        writer: Who puts, asks or holds the token.
        kind: A put, a query or a liveliness token; `get`: whether a put can be asked for too.
        carries: What is put, or asked with.
        replies: What a query, or a `get`, is answered with.
        errors: What a query is refused with.
        priority, express: How a put is sent; all are dropped rather than waited for.
        often: How often it is written.
    """

    key: str
    writer: str
    kind: Literal["put", "query", "token"]
    often: str
    carries: tuple[type[Record], ...] = ()
    replies: tuple[type[Record], ...] = ()
    errors: tuple[type[Record], ...] = ()
    get: bool = False
    priority: PriorityName = "data"
    express: bool = False


_STATE: Final = "every tick, at most 60 a second, 2 a second while nothing moves, always the last before a stop"

CHANNELS: Final[dict[str, Channel]] = {
    "join": Channel("join/<agent>", "agent", "query", "once", (Robot,), (Joined,), (Refused,)),
    "leave": Channel("leave/<agent>", "agent", "query", "once, optional", (Leave,), (Result,), (Refused,)),
    "actions": Channel(
        "in/<agent>/actions", "mind of the agent", "put", "every tick", (Actions,), priority="interactive-high"
    ),
    "say": Channel("in/<agent>/say", "agent", "put", "when it speaks", (Say,), priority="data-high"),
    "pose": Channel(
        "in/<agent>/pose", "bridge of a real chair, player of its log", "put", "every tick", (Pose,),
        priority="interactive-high",
    ),
    "token": Channel("in/<agent>/alive/<role>/<instance>", "agent", "token", "while it lives"),
    "user": Channel(
        "user/<agent>", "operator, joystick, page", "put", "at least every 0.3 s", (UserInput,),
        priority="interactive-high",
    ),
    "measures": Channel("out/<agent>/measures", "simulator", "put", "every tick", (Measures,), priority="data-high"),
    "power": Channel(
        "out/<agent>/power", "simulator", "put", "every tick, real chairs only", (PowerInForce,),
        priority="interactive-high",
    ),
    "error": Channel("out/<agent>/error", "simulator", "put", "rate-limited", (Error,), priority="data-low"),
    "body": Channel("body/<agent>", "simulator", "put", "on change", (Body,), (Body,), get=True),
    "state": Channel("state/<part>", "simulator", "put", _STATE, (WorldState,), (WorldState,), get=True),
    "map": Channel("map", "simulator", "put", "on change", (MapInfo,), (Map,), get=True),
    "event": Channel("event", "simulator", "put", "as it happens", (Event,), (Events,), get=True),
    "clock": Channel("clock", "simulator", "put", _STATE, (Clock,), (Clock,), get=True, priority="real-time",
                     express=True),
    "crew_actions": Channel(
        "crew/<crew>/actions", "process of many bodies", "put", "every tick", (CrewActions,),
        priority="interactive-high",
    ),
    "crew_measures": Channel(
        "crew/<crew>/measures", "simulator", "put", "every tick", (CrewMeasures,), priority="data-high"
    ),
    "ctl": Channel(
        "ctl/<verb>", "operator", "query", "on demand",
        (Pause, Resume, Step, Reset, Load, Speed, Spawn, Delete, Teleport, Take, OperatorSay, Save, Restore, Seek,
         Quit),
        (Result,), (Result,),
    ),
    "alive": Channel("alive", "simulator", "token", "while it lives"),
}  # fmt: skip
"""Every key of a world by a short name."""

VERB_CLASSES: Final[dict[str, type[Record]]] = {
    "pause": Pause, "resume": Resume, "step": Step, "reset": Reset, "load": Load, "speed": Speed, "spawn": Spawn,
    "delete": Delete, "teleport": Teleport, "take": Take, "say": OperatorSay, "save": Save, "restore": Restore,
    "seek": Seek, "quit": Quit,
}  # fmt: skip
"""What each control verb carries."""
