"""The defaults that several parts of the project share, each declared once.

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
"""Simulated time of one tick, s."""
SAY_LIMIT: Final = 100
"""Largest number of characters in a message between agents."""
SAY_RANGE: Final = 8.0
"""Largest distance between the sender and a receiver of a message, m."""
SAY_WALLS: Final = False
"""Whether walls and closed doors block messages."""
SAY_LOSS: Final = 0.0
"""Share of messages that a receiver misses, in [0, 1]."""
SAY_DELAY: Final = 0.0
"""Delay of a message in addition to one tick, s."""
COMMAND_TIMEOUT: Final = 0.5
"""Simulated time after which a motor command is no longer valid, s."""
LATE_COMMAND: Final = 0.3
"""Simulated time by which a command may be late and still counts, in runs that do not wait for answers, s."""
GRACE: Final = 15.0
"""Wall time from the loss of an agent's token to its removal, s. A router that restarts takes all tokens with it."""
STRICT_DEADLINE: Final = 10.0
"""Wall time for which strict lockstep waits for an answer, s."""
ELASTIC_DEADLINE: Final = 1.0
"""Wall time for which elastic lockstep waits for an answer, s."""
AGENT_RAYS: Final = 400_000
"""Rays per second that the sensors of one agent may cast in real time."""
WORLD_RAYS: Final = 1_000_000
"""Rays per second that the sensors of all agents may cast in real time."""
LOAD_TIME: Final = 5.0
"""Wall time in which a request to load a map is answered, s."""
