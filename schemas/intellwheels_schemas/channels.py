"""The table of keys: the writer, the messages, the rate and the priority of each key.

Puts never block, since one stuck reader would stop all others. Requests that must not be lost are queries. Periodic
messages are puts.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

from intellwheels_schemas.messages import (
    Actions,
    Body,
    Clock,
    CrewActions,
    CrewError,
    CrewJoin,
    CrewJoined,
    CrewLeave,
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
        key: The key after `iw/v1/<world>/`.
        writer: The process that puts, queries or declares the token.
        kind: A put, a query or a liveliness token.
        often: How often it is written.
        carries: Messages that are put, or sent with the query.
        replies: Messages in the reply to a query or a `get`.
        errors: Messages in the error reply to a query.
        get: Whether a `get` returns the latest put.
        priority, express: How a put is sent. A put that would have to wait is dropped.
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


_CLOCK: Final = (
    "every tick, at most 60 per second; always the last tick before a stop; 2 per second while paused or waiting"
)
_STATE: Final = (
    "every tick, at most 60 per second; always the last tick before a stop; 2 per second while nothing that it shows "
    "changes; in a playback, as often as the clock"
)

CHANNELS: Final[dict[str, Channel]] = {
    "join": Channel("join/<agent>", "agent", "query", "once", (Robot,), (Joined,), (Refused,)),
    "leave": Channel("leave/<agent>", "agent", "query", "once, optional", (Leave,), (Result,), (Result,)),
    "actions": Channel(
        "in/<agent>/actions", "mind of the agent", "put", "every tick", (Actions,), priority="interactive-high"
    ),
    "say": Channel("in/<agent>/say", "agent", "put", "when the agent sends a message", (Say,), priority="data-high"),
    "pose": Channel(
        "in/<agent>/pose", "bridge of a real robot, or the playback of its log", "put", "every tick", (Pose,),
        priority="interactive-high",
    ),
    "token": Channel("in/<agent>/alive/<role>/<instance>", "agent", "token", "while the process runs"),
    "user": Channel(
        "user/<agent>", "operator, joystick, bridge or viewer page", "put", "at least every 0.3 s", (UserInput,),
        priority="interactive-high",
    ),
    "measures": Channel("out/<agent>/measures", "simulator", "put", "every tick", (Measures,), priority="data-high"),
    "power": Channel(
        "out/<agent>/power", "simulator", "put", "every tick, for real robots only", (PowerInForce,),
        priority="interactive-high",
    ),
    "error": Channel("out/<agent>/error", "simulator", "put", "rate-limited", (Error,), priority="data-low"),
    "body": Channel("body/<agent>", "simulator", "put", "on change", (Body,), (Body,), get=True),
    "state": Channel("state/<part>", "simulator", "put", _STATE, (WorldState,), (WorldState,), get=True),
    "map": Channel("map", "simulator", "put", "on change", (MapInfo,), (Map,), get=True),
    "event": Channel("event", "simulator", "put", "at each event", (Event,), (Events,), (Result,), get=True),
    "clock": Channel("clock", "simulator", "put", _CLOCK, (Clock,), (Clock,), get=True, priority="real-time",
                     express=True),
    "crew_token": Channel(
        "in/<agent>/alive/<role>/<instance>/<crew>", "crew", "token", "while the process runs"
    ),
    "crew_join": Channel(
        "crew/<crew>/join", "crew", "query", "once", (CrewJoin,), (CrewJoined,), (Refused,)
    ),
    "crew_leave": Channel(
        "crew/<crew>/leave", "crew", "query", "once, optional", (CrewLeave,), (Result,), (Result,)
    ),
    "crew_actions": Channel(
        "crew/<crew>/actions", "crew", "put", "every tick", (CrewActions,),
        priority="interactive-high",
    ),
    "crew_measures": Channel(
        "crew/<crew>/measures", "simulator", "put", "every tick", (CrewMeasures,), priority="data-high"
    ),
    "crew_error": Channel("crew/<crew>/error", "simulator", "put", "rate-limited", (CrewError,), priority="data-low"),
    "ctl": Channel(
        "ctl/<verb>", "operator", "query", "on demand",
        (Pause, Resume, Step, Reset, Load, Speed, Spawn, OperatorSay, Save, Restore, Seek, Quit),
        (Result,), (Result,),
    ),
    "ctl_agent": Channel(
        "ctl/<verb>/<agent>", "operator", "query", "on demand", (Delete, Teleport, Take), (Result,), (Result,)
    ),
    "alive": Channel("alive", "simulator", "token", "while the process runs"),
    "claim": Channel("alive/<since>/<instance>", "simulator", "token", "while the process runs"),
}  # fmt: skip
"""All keys of a world, by a short name."""

VERB_CLASSES: Final[dict[str, type[Record]]] = {
    "pause": Pause, "resume": Resume, "step": Step, "reset": Reset, "load": Load, "speed": Speed, "spawn": Spawn,
    "delete": Delete, "teleport": Teleport, "take": Take, "say": OperatorSay, "save": Save, "restore": Restore,
    "seek": Seek, "quit": Quit,
}  # fmt: skip
"""The message of each control verb."""
