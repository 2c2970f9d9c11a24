"""`iw-joystick`: drives a chair by hand, through `user/<agent>`.

A source (keyboard, terminal, gamepad, script, words) gives an `InputState`. `InputTiming` decides when it is sent,
`LeaseClient` keeps the lease of `--take`. These are pure; `pygame_source` knows pygame, `terminal_source` the terminal
and `joystick_peer` the network. Only this process repeats the input: when it dies, the simulator hears nothing and
cuts the power of the motors after 0.3 s.
"""

from __future__ import annotations

from collections.abc import Sequence


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    # Importing an `InputState` alone loads neither the command line nor zenoh.
    from intellwheels_agents.joystick.__main__ import main as run  # noqa: PLC0415

    return run(arguments)
