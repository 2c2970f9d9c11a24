"""The defaults that several parts of the project share: each number stands here once.

A scene, the world, the command line of the simulator and the tools that start it all take them from here.
"""

from __future__ import annotations

from typing import Final

WORLD: Final = "main"
"""Name of the world."""
ENDPOINT: Final = "tcp/127.0.0.1:7447"
"""Where a simulator listens, and everybody else connects to."""
SEED: Final = "1"
"""Seed of all noise."""
PERIOD: Final = 0.05
"""Simulated time of a tick, s."""
SAY_LIMIT: Final = 100
"""Characters of one message that an agent says."""
SAY_RANGE: Final = 8.0
"""Distance up to which it is heard, m."""
SAY_WALLS: Final = False
"""Whether walls and closed doors keep it from being heard."""
SAY_LOSS: Final = 0.0
"""Share of messages that a listener misses, in [0, 1]."""
SAY_DELAY: Final = 0.0
"""Time a message takes beyond the next tick, s."""
COMMAND_TIMEOUT: Final = 0.5
"""Simulated time after which a command no longer counts, s."""
GRACE: Final = 3.0
"""Wall time until an agent whose token is gone is removed, s."""
STRICT_DEADLINE: Final = 10.0
"""Wall time that strict lockstep waits for an answer, s."""
ELASTIC_DEADLINE: Final = 1.0
"""Wall time that elastic lockstep waits for an answer, s."""
