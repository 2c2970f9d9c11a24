"""`iw-joystick`: a person's hand on `user/<agent>`.

What a source (keys, a gamepad, a script, words) makes of itself is a `Wish`; a `Hand` says when a wish is put, a
`Grip` keeps the lease of `--take`. All of that is pure; `window` knows pygame, `network` the link. Nothing repeats a
wish but this process: when it dies, the simulator hears nothing, and after 0.3 s nobody wants anything.
"""

from __future__ import annotations

from collections.abc import Sequence


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    # Who wants a `Wish` alone loads neither the command line nor zenoh.
    from intellwheels_agents.joystick.__main__ import main as run  # noqa: PLC0415

    return run(arguments)
