"""Minds that misbehave, for tests. Each is given to `iw-agent` as a file of its own by `write`."""

from __future__ import annotations

import os
from pathlib import Path

STUCK = '''
"""Drives ahead, and once it did, from tick 20 on, never comes back from its own code."""
from intellwheels_schemas.messages import Actions

class Mind:
    def __init__(self, context): self.drove = False
    def decide(self, measures):
        while self.drove and measures.tick >= 20:
            pass
        self.drove = True
        return Actions(left_motor=0.3, right_motor=0.3)
'''

SLOW_ONCE = '''
"""Drives ahead, and thinks about tick 20 until somebody writes to the pipe beside this file."""
from pathlib import Path
from intellwheels_schemas.messages import Actions

class Mind:
    def __init__(self, context): self.thought = False
    def decide(self, measures):
        if measures.tick >= 20 and not self.thought:
            self.thought = True
            Path(__file__).with_suffix(".pipe").read_bytes()
        return Actions(left_motor=0.1, right_motor=0.1)
'''


def write(folder: Path, name: str, text: str) -> str:
    """Write a mind to a file and return its path; `NAME.pipe` beside it is a named pipe that it may wait for."""
    path = folder / f"{name}.py"
    path.write_text(text)
    os.mkfifo(path.with_suffix(".pipe"))
    return str(path)
