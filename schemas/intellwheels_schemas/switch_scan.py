"""Driving with one or two switches, or by resting a pointer. Pure: the time is an argument. For terminals and pages.

The commands `forward`, `left`, `right`, `back` and `stop` are highlighted in turn.

method   the highlight moves                        a command is selected
auto     by itself, every `period`                  by switch 1
step     by switch 1                                by switch 2
dwell    to where the pointer is, or by switch 1    when the highlight has rested on it for `dwell`

A selected command drives while its switch is held or the pointer rests on it. Latched, or selected by dwell with a
switch, it drives until any switch is pressed. In both cases without a held switch it drives for at most `hold`.
Silence stops it: when `update` was not called for `STALE_AFTER`, and the switch must then be released first.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

Method: TypeAlias = Literal["auto", "step", "dwell"]

METHODS: Final[tuple[Method, ...]] = ("auto", "step", "dwell")
COMMANDS: Final[dict[str, tuple[float, float]]] = {
    "forward": (1.0, 0.0),
    "left": (0.0, 1.0),
    "right": (0.0, -1.0),
    "back": (-1.0, 0.0),
    "stop": (0.0, 0.0),
}
"""The signs of forward and turn of each command, in the order in which they are highlighted."""
STALE_AFTER: Final = 0.3
"""Seconds without an update after which the chair stops: the silence that stops a chair everywhere."""
CONFIRM_PERIODS: Final = 2.0
"""Periods for which a selected command waits for its confirmation."""
_ORDER: Final = tuple(COMMANDS)


@dataclass(frozen=True, slots=True, kw_only=True)
class ScanSettings:
    """How to scan.

    Attributes:
        method: How the highlight moves and how a command is selected.
        period: Seconds for which each command is highlighted by the method auto.
        dwell: Seconds of rest that select by the method dwell.
        confirm: Whether a command other than stop must be selected twice before it drives.
        latch: Whether a command drives on after its switch is released, until the next press.
        hold: Longest time in seconds that a command drives without a held switch.
        pause: Seconds for which a switch must have been released before its press confirms. A terminal shows a pause
            within one press, before it repeats the key.
    """

    method: Method = "auto"
    period: float = 1.5
    dwell: float = 1.0
    confirm: bool = False
    latch: bool = False
    hold: float = 2.0
    pause: float = 0.0


@dataclass(frozen=True, slots=True)
class ScanView:
    """What is shown.

    Attributes:
        lit: The highlighted command.
        armed: Whether it waits for its confirmation.
        driving: The command that drives, or None.
        resting: Whether a dwell is being counted on the highlighted command.
    """

    lit: str = _ORDER[0]
    armed: bool = False
    driving: str | None = None
    resting: bool = False


class SwitchScan:
    """The state of a scan.

    Attributes:
        settings: How to scan.
        view: What is shown now.
    """

    def __init__(self, settings: ScanSettings) -> None:
        self.settings = settings
        self.view = ScanView()
        self._updated: float | None = None
        self._since = 0.0
        self._pressed: frozenset[int] = frozenset()
        # When each switch was last seen pressed.
        self._seen: dict[int, float] = {}
        self._over: str | None = None
        # The command that the pointer has driven for as long as it may: the pointer must leave it first.
        self._spent: str | None = None
        # What keeps the selected command driving: a switch, the pointer, or nothing (a latch).
        self._keeper: int | Literal["pointer"] | None = None

    def update(self, now: float, pressed: Collection[int] = (), over: str | None = None) -> tuple[float, float]:
        """Return the signs of forward and turn, each -1, 0 or 1.

        Args:
            now: Seconds of a monotonic clock.
            pressed: The switches that are pressed, 1 and 2.
            over: The command over which a pointer rests, or None.
        """
        over = over if over in COMMANDS else None
        pressed = frozenset(pressed)
        if self._updated is None or now - self._updated > STALE_AFTER:
            # What is held now was pressed at an unknown time: it selects nothing.
            self._pressed = self._pressed | pressed
            self._rest(now)
        self._updated = now
        new, self._pressed = pressed - self._pressed, pressed
        if self.view.armed:
            new = frozenset(switch for switch in new if now - self._seen.get(switch, -math.inf) >= self.settings.pause)
        self._seen.update(dict.fromkeys(pressed, now))
        if over != self._spent:
            self._spent = None
        if self.view.driving is not None:
            if not self._must_stop(now, pressed, new, over):
                return COMMANDS[self.view.driving]
            if self._keeper == "pointer" and over == self.view.driving:
                self._spent = over
            self._rest(now)
            new = frozenset()  # a press that stops does nothing else
        getattr(self, f"_{self.settings.method}")(now, new, over)
        return COMMANDS[self.view.driving or "stop"]

    def lost(self) -> None:
        """Stop at the next update, as after silence: the switches can no longer be seen."""
        self._updated = None

    def _must_stop(self, now: float, pressed: frozenset[int], new: frozenset[int], over: str | None) -> bool:
        if isinstance(self._keeper, int):
            return self._keeper not in pressed
        if self._keeper == "pointer" and over != self.view.driving:
            return True
        return bool(new) or now - self._since >= self.settings.hold

    def _rest(self, now: float) -> None:
        """Stop driving. The highlight stays for a whole period, so that the same command is easily selected again."""
        self.view = ScanView(self.view.lit)
        self._since, self._keeper, self._over = now, None, None

    def _auto(self, now: float, new: frozenset[int], _over: str | None) -> None:
        length = self.settings.period * (CONFIRM_PERIODS if self.view.armed else 1.0)
        if 1 in new:
            self._select(now, None if self.settings.latch else 1)
        elif now - self._since >= length:
            self._light(now, self._next())

    def _step(self, now: float, new: frozenset[int], _over: str | None) -> None:
        if 2 in new:
            self._select(now, None if self.settings.latch else 2)
        elif 1 in new:
            self._light(now, self._next())

    def _dwell(self, now: float, new: frozenset[int], over: str | None) -> None:
        if over is not None and over != self._over:
            self._light(now, over, resting=over != self._spent)
        elif 1 in new:
            self._light(now, self._next(), resting=True)
        elif over is None and self._over is not None:
            self._light(now, self.view.lit)
        elif self.view.resting and now - self._since >= self.settings.dwell:
            self._select(now, "pointer" if over == self.view.lit else None)
        self._over = over

    def _next(self) -> str:
        return _ORDER[(_ORDER.index(self.view.lit) + 1) % len(_ORDER)]

    def _light(self, now: float, command: str, *, resting: bool = False) -> None:
        self.view, self._since = ScanView(command, resting=resting), now

    def _select(self, now: float, keeper: int | Literal["pointer"] | None) -> None:
        lit, self._since = self.view.lit, now
        if self.settings.confirm and lit != "stop" and not self.view.armed:
            self.view = ScanView(lit, armed=True, resting=self.view.resting)
        elif lit == "stop":
            self.view = ScanView(lit)
        else:
            self.view, self._keeper = ScanView(lit, driving=lit), keeper
