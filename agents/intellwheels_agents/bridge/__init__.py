"""`iw-bridge`: a real chair as a body of the simulation.

Two ends. A `Driver` is the chair's electronics: encoders, sonars, battery and joystick come from it, motor power goes
to it. `RealChair` is the body in the simulation: pose with covariance and stamp up, `out/<agent>/power` down, motors at
rest after 0.3 s of silence. Nothing of the truth passes: a pose is what the encoders, and fixes if there are any, say.
`port` knows pyserial; `laboratory` drives a chair of another world through the harness, as any agent does.
"""

from __future__ import annotations

from collections.abc import Sequence


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    # Who wants the line protocol alone loads neither the command line nor zenoh.
    from intellwheels_agents.bridge.__main__ import main as run  # noqa: PLC0415

    return run(arguments)
