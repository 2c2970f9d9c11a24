"""`iw-joystick`: drives a chair by hand, with a gamepad, the keyboard or another input device.

A source gives an `InputState`. What its keys, samples or words mean is pure (`key_bindings`, `scan_keys`,
`sip_and_puff`, `lsl_channels`, `words_source`), and so are `InputTiming`, which decides when a state is sent, and
`LeaseClient`, which keeps the lease of `--take`. `pygame_source` knows pygame, `terminal_source` the terminal,
`lsl_source` pylsl, `voice_words` PocketSphinx, `audio_inputs` the sound, and `joystick_peer` the network. Only this
process repeats the input: when it dies, the simulator hears nothing and cuts the power of the motors after 0.3 s.
"""

from __future__ import annotations

from collections.abc import Sequence


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    # Importing an `InputState` alone loads neither the command line nor zenoh.
    from intellwheels_agents.joystick.__main__ import main as run  # noqa: PLC0415

    return run(arguments)
