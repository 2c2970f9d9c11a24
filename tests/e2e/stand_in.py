"""A stand-in for the hardware of a real chair, as a process, and its faults."""

from __future__ import annotations

import os

from tests.e2e.stage import Stage


class StandIn:
    """A stand-in that runs.

    Attributes:
        child: The name of its process on the stage.
        ready: The values of its line `ready`.
    """

    def __init__(self, stage: Stage, name: str, module: str, *words: str) -> None:
        self._stage = stage
        self._pipe = stage.folder / "ask"
        os.mkfifo(self._pipe)
        self.child = stage.start(name, f"intellwheels_agents.bridge.{module}", "--ask", str(self._pipe), *words)
        self.ready = stage.line(self.child, "ready")

    def command(self, line: str) -> None:
        """Ask for a fault, or for a move of its joystick."""
        with self._pipe.open("w") as pipe:
            pipe.write(line + "\n")

    def line(self, verb: str) -> dict[str, int]:
        """Wait for a line of this verb, and return its values."""
        return {name: int(value) for name, value in self._stage.line(self.child, verb).items()}

    def stops_by_command(self) -> None:
        """Wait until a command stops the motors. On a busy machine the watchdog may have stopped them before."""
        while self.line("stopped")["silence"] != -1:
            pass
