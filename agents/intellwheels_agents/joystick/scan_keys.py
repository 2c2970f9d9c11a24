"""Switch scanning with keys: `switch_scan` with a key for each switch. Knows no device."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from intellwheels_agents.joystick.input_state import InputState
from intellwheels_schemas.switch_scan import COMMANDS, ScanSettings, ScanView, SwitchScan

DEFAULT_KEYS = ("space", "enter")
"""What most switch interfaces send for the first and the second switch."""


class ScanKeys:
    """A scan as a `KeyReader`.

    Args:
        settings: How to scan.
        keys: The keys of switch 1 and 2.
        forward: Share of full forward that a command gives, in [0, 1].
        turn: The same share of full turn.
    """

    def __init__(self, settings: ScanSettings, keys: Sequence[str], forward: float, turn: float) -> None:
        self._scan = SwitchScan(settings)
        self._switches = {key: number for number, key in enumerate(keys, 1)}
        self._shares = forward, turn
        uses = {
            "auto": f"{keys[0]} selects the highlighted command",
            "step": f"{keys[0]} moves the highlight, {keys[-1]} selects",
            "dwell": f"{keys[0]} moves the highlight, and a rest of {settings.dwell:g} s selects",
        }
        again = ", again to confirm" if settings.confirm else ""
        self.help = (f"{uses[settings.method]}{again}", "escape ends")

    @property
    def keys(self) -> Collection[str]:
        """The keys of the switches."""
        return self._switches.keys()

    @property
    def caption(self) -> str:
        """The commands, with the highlighted one marked."""
        return caption(self._scan.view)

    def read(self, held: Collection[str], now: float) -> InputState:
        """Return the state that the held switches give."""
        pressed = [number for key, number in self._switches.items() if key in held]
        forward, turn = self._scan.update(now, pressed)
        return InputState(forward * self._shares[0], turn * self._shares[1])

    def lost(self) -> None:
        """Stop a latched command, and a rest that is being counted."""
        self._scan.lost()


def caption(view: ScanView) -> str:
    """Return a line with all commands: `[left]` is highlighted, `?left?` waits to be confirmed, `>LEFT<` drives."""
    words = []
    for command in COMMANDS:
        if command == view.driving:
            words.append(f">{command.upper()}<")
        elif command == view.lit:
            words.append(f"?{command}?" if view.armed else f"[{command}]")
        else:
            words.append(f" {command} ")
    return " ".join(words)
