"""`iw-bridge`: puts a real chair into a simulation.

A `Driver` is one end: it reads encoders, sonars, battery and joystick from the chair's electronics and sends them motor
power. `RealChair` is the other end, the body in the simulation: it reports a pose with covariance and time stamp, and
receives `out/<agent>/power`. The pose comes from encoders and position fixes only, never from the true state.

`serial_driver` is the only file that knows pyserial; `luci_driver` knows grpc and `rnet_driver` python-can, as their
stand-ins do. `world_driver` uses a chair in another simulation as hardware.
"""

from __future__ import annotations

from collections.abc import Sequence


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    # Importing the line protocol alone loads neither the command line nor zenoh.
    from intellwheels_agents.bridge.__main__ import main as run  # noqa: PLC0415

    return run(arguments)
