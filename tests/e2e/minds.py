"""Minds that misbehave, for tests. Each is given to `iw-agent` as a file of its own by `write`."""

from __future__ import annotations

from pathlib import Path

STUCK = '''
"""Drives ahead, and from tick 20 on never comes back from its own code."""
from intellwheels_schemas.messages import Actions

class Mind:
    def __init__(self, context): pass
    def decide(self, measures):
        while measures.tick >= 20:
            pass
        return Actions(left_motor=0.3, right_motor=0.3)
'''

SLOW_ONCE = '''
"""Drives ahead, and thinks for 1.5 s about tick 20."""
import time
from intellwheels_schemas.messages import Actions

class Mind:
    def __init__(self, context): self.thought = False
    def decide(self, measures):
        if measures.tick >= 20 and not self.thought:
            self.thought = True
            time.sleep(1.5)
        return Actions(left_motor=0.1, right_motor=0.1)
'''


def write(folder: Path, name: str, text: str) -> str:
    path = folder / f"{name}.py"
    path.write_text(text)
    return str(path)
