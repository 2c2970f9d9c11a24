"""Lets only the simulator's own powers through to the motors of a real chair. Pure.

The simulator codes each power with the key that the bridge got in its `Joined`, and numbers it. A power with another
code is a stranger's; one with an old number is a copy.
"""

from __future__ import annotations

from intellwheels_agents.harness_outputs import Payload
from intellwheels_schemas.codec import decode
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Joined, PowerInForce
from intellwheels_schemas.metal_codes import is_genuine, power_line


class PowerGate:
    """The key of one bridge, and the number of the last power.

    Attributes:
        key: The key; None before a join gave one.
    """

    def __init__(self) -> None:
        self.key: str | None = None
        self._session = ""
        self._seq = -1

    def joined(self, joined: Joined) -> None:
        """Take the key of a join. A later reply to the same session has none, and the key stays."""
        if joined.session != self._session:
            self._session, self.key, self._seq = joined.session, joined.key, -1
        elif joined.key is not None:
            self.key = joined.key

    def read(self, payload: Payload) -> PowerInForce | str:
        """Return the power in a message, or why it must not reach the motors, in words."""
        try:
            power = decode(PowerInForce, *payload, strict=False)
        except WireError as error:
            return error.text
        if self.key is None:
            return "the simulator gave no key with the join; start the bridge again"
        if not is_genuine(self.key, power_line(power), power.code):
            got = "none" if power.code is None else "another"
            return f"Power.Code: expected the code that our key makes, got {got}"
        if power.seq is None or power.seq <= self._seq:
            return f"Power.Seq: expected more than {self._seq}, got {power.seq}; this is a copy"
        self._seq = power.seq
        return power
