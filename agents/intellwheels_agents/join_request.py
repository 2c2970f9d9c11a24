"""The document that an agent joins with. Pure."""

from __future__ import annotations

from typing import Final

import msgspec

from intellwheels_agents.harness_outputs import Log, Output, Reappear, RequestJoin
from intellwheels_schemas.codec import Encoding, encode
from intellwheels_schemas.messages import Robot
from intellwheels_schemas.names import new_hex

KEY_TRIES: Final = 3
"""Joins as a new process for want of a key. After that the simulator is one that gives none."""


class JoinRequest:
    """What to send to join, and with which instance.

    Attributes:
        transient: Codes of refusals after which a later try can succeed.
    """

    def __init__(self, robot: Robot, encoding: Encoding) -> None:
        self.transient = {"no-body", "no-token"}
        self._robot, self._encoding, self._tries = robot, encoding, 0

    @property
    def output(self) -> RequestJoin:
        """The request."""
        return RequestJoin(encode(self._robot, self._encoding))

    def again(self, key: str | None) -> list[Output]:
        """Return a join as a new process if a real body got no key; else nothing.

        The simulator gives a key once. If that reply was lost, no power can reach the motors any more.
        """
        lacks = self._robot.type == "real" and self._robot.role != "mind" and key is None
        if not lacks or self._tries == KEY_TRIES:
            return []
        self._tries += 1
        self._robot = msgspec.structs.replace(self._robot, instance=new_hex())
        # Until the simulator hears that the old token is gone, it takes us for another process.
        self.transient.add("already-here")
        why = "the reply with the key was lost; joining as a new process"
        return [Log(f"rejoining why={why!r}"), Reappear(self._robot.instance or ""), self.output]
