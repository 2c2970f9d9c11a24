"""Whether a real chair may drive on after its contact with the simulator was interrupted. Pure but for a lock.

A chair that starts by itself when a router or a simulator returns surprises the person beside it. With `confirm` its
motors stay off after an interruption until a person confirms. The first start needs no confirmation.

state    event                              then     printed
open     simulator gone, 1 s without        held     held agent=... reason=...
         power, or joined again
held     a power arrives                    ready    ready agent=...
ready    a person confirms                  open     resumed agent=...
ready    as in state open                   held     held agent=... reason=..., and that an Enter does not count yet
held     a person confirms                  held     not yet, because no power arrives

`--resume auto` is a gate that is always open.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable
from enum import Enum, auto
from typing import Literal

from intellwheels_agents.bridge.timeouts import INTERRUPTION, POWER_TIMEOUT

Reason = Literal["simulator-gone", "silence", "joined-again"]


class _State(Enum):
    OPEN = auto()
    HELD = auto()
    READY = auto()


class ResumeGate:
    """The gate between the simulator's powers and the motors.

    Attributes:
        confirm: Whether a person must confirm after an interruption.
    """

    def __init__(
        self,
        agent: str,
        *,
        confirm: bool,
        tell: Callable[[str], None] = lambda _line: None,
        prompt: Callable[[str], None] = lambda _text: None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Create an open gate.

        Args:
            agent: The name of the chair.
            confirm: Whether a person must confirm after an interruption.
            tell: Receives the lines for scripts.
            prompt: Receives the sentences for people.
            clock: Returns monotonic seconds.
        """
        self.confirm = confirm
        self._agent = agent
        self._tell = tell
        self._prompt = prompt
        self._clock = clock
        self._lock = threading.Lock()
        self._state = _State.OPEN
        self._was_joined = False
        self._power_at: float | None = None
        self._back_at = -math.inf

    @property
    def is_open(self) -> bool:
        """Whether the motors may get power."""
        return self._state is _State.OPEN

    def joined(self) -> None:
        """Note a join; every one after the first follows an interruption.

        The first power may overtake the answer to a join. Within `INTERRUPTION` of it the join is no second one, so
        that a person is asked once.
        """
        if self._was_joined and self._clock() - self._back_at > INTERRUPTION:
            self.interrupted("joined-again")
        self._was_joined = True

    def interrupted(self, reason: Reason) -> None:
        """Close the gate, if the chair has joined and confirmation is on."""
        with self._lock:
            if not self.confirm or not self._was_joined or self._state is _State.HELD:
                return
            was_asked = self._state is _State.READY
            self._state = _State.HELD
        self._tell(f"held agent={self._agent} reason={reason}")
        again = " again" if was_asked else ""
        text = f"{self._agent}: contact with the simulator was interrupted{again} ({reason}); the motors stay off"
        # Whoever has been asked already must not think that one Enter is too many.
        self._prompt(f"{text}. Wait until contact is back, then press Enter" if was_asked else text)

    def power_received(self) -> None:
        """Note the arrival of a power. Call it before the power takes effect."""
        now = self._clock()
        last, self._power_at = self._power_at, now
        if last is not None and now - last > INTERRUPTION:
            self.interrupted("silence")
        with self._lock:
            if self._state is not _State.HELD:
                return
            self._state = _State.READY
            self._back_at = now
        self._tell(f"ready agent={self._agent}")
        self._prompt(f"{self._agent}: contact is back. Press Enter to let the chair drive on")

    def confirmed(self) -> None:
        """Open the gate, because a person confirms. It stays closed while no power arrives."""
        with self._lock:
            has_contact = self._power_at is not None and self._clock() - self._power_at <= POWER_TIMEOUT
            if self._state is _State.OPEN:
                return
            if is_ready := self._state is _State.READY and has_contact:
                self._state = _State.OPEN
        if is_ready:
            self._tell(f"resumed agent={self._agent}")
        else:
            self._prompt(f"{self._agent}: not yet, because no power comes from the simulator")
