"""The inputs of the world at a tick: the records of the input log, which the contract declares in `file_records`."""

from __future__ import annotations

from intellwheels_schemas.file_records import (
    Change,
    DeleteBody,
    Depart,
    GoOn,
    Inputs,
    Join,
    Note,
    Restart,
    RestoreState,
    Said,
    SaveState,
    SpawnBody,
    Speech,
    TakeBody,
    TeleportBody,
    Verdict,
    VerdictCode,
)

__all__ = [
    "Change",
    "DeleteBody",
    "Depart",
    "GoOn",
    "Inputs",
    "Join",
    "Note",
    "Restart",
    "RestoreState",
    "Said",
    "SaveState",
    "SpawnBody",
    "Speech",
    "TakeBody",
    "TeleportBody",
    "Verdict",
    "VerdictCode",
]
