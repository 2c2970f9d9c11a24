"""The time limits of a real chair, all in one place. Every value is in seconds.

The order of the limits is what makes a chair safe: the controller gives up first, then the bridge, then the simulator.
`PROTOCOL.md` states the same numbers for people who write firmware.
"""

from __future__ import annotations

from typing import Final

CONTROLLER_WATCHDOG: Final = 0.2
"""Silence on the line after which a controller stops its motors by itself."""
POWER_TIMEOUT: Final = 0.3
"""Time without a power from the simulator after which the bridge stops the motors: the contract's, for role `body`."""
POSE_TIMEOUT: Final = 0.3
"""Time without a reading after which no pose is reported, at least; see `POSE_TIMEOUT_TICKS`."""
POSE_TIMEOUT_TICKS: Final = 3
"""Ticks without a reading after which no pose is reported. The longer of both limits counts, as in the simulator."""
STICK_TIMEOUT: Final = 0.3
"""Time without a reading of the chair's own joystick after which it counts as released."""
POWER_PERIOD: Final = 0.05
"""Time between two repetitions of the same power on the line."""
POWER_POLL: Final = 0.01
"""Time between two checks for a changed power: the longest that a new power waits."""
REOPEN_PERIOD: Final = 0.2
"""Time between two attempts to open a serial device."""
STREAM_TIMEOUT: Final = 0.5
"""Time without a message of a sensor's stream after which its last value is no longer reported."""
CONNECT_TIMEOUT: Final = 5.0
"""Time for a new network connection to a chair to bring its first reading."""
STATUS_PERIOD: Final = 10.0
"""Time between two lines about the battery and the speed setting of an R-Net chair."""
QUIET_LINE: Final = 1.0
"""Time on an open line without valid telemetry before the bridge says that it waits for the controller."""
INTERRUPTION: Final = 1.0
"""Time without a power after which the contact with the simulator counts as interrupted. A shorter silence stops the
motors too, but the chair drives on by itself: a wireless link loses that much now and then."""
