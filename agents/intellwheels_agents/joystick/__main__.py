"""`iw-joystick`: drive a chair by hand."""

from __future__ import annotations

import argparse
import sys
import threading
from collections.abc import Sequence
from contextlib import ExitStack, closing

from intellwheels_agents.joystick.audio_inputs import AudioInput, Microphone, PipeInput, WavInput
from intellwheels_agents.joystick.input_state import KeyReader, Source
from intellwheels_agents.joystick.joystick_options import check, parser
from intellwheels_agents.joystick.joystick_peer import operate
from intellwheels_agents.joystick.key_bindings import DrivingKeys
from intellwheels_agents.joystick.lsl_channels import ChannelError, ChannelMap
from intellwheels_agents.joystick.lsl_source import FIND_SECONDS, LslSource, MissingPylslError
from intellwheels_agents.joystick.pygame_source import (
    DeviceError,
    GamepadSource,
    KeyboardSource,
    MissingPygameError,
    has_display,
    has_gamepad,
)
from intellwheels_agents.joystick.scan_keys import ScanKeys
from intellwheels_agents.joystick.script_source import ScriptError, ScriptSource, read
from intellwheels_agents.joystick.sip_and_puff import SipAndPuff
from intellwheels_agents.joystick.terminal_source import REPEAT_PAUSE, TerminalSource
from intellwheels_agents.joystick.voice_source import VoiceSource
from intellwheels_agents.joystick.voice_words import MissingPocketsphinxError, WordRecogniser
from intellwheels_agents.joystick.words_source import SpokenWords, WordsSource
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.extras import missing_extra
from intellwheels_schemas.link import link_of
from intellwheels_schemas.names import check_agent
from intellwheels_schemas.process import stop_on_signals
from intellwheels_schemas.switch_scan import ScanSettings


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code: 0 done, 1 refused or failed, 2 wrong usage."""
    command_line = parser()
    options = command_line.parse_args(arguments)
    check(command_line, options)
    # First, because a signal may arrive while the other arguments are read.
    stop = stop_on_signals(options.lifeline)
    try:
        agent, where = check_agent(options.agent, "AGENT"), link_of(options)
        with ExitStack() as stack:
            source = _source(options, stop, stack)
            return operate(
                where, agent, source, take=options.take, stop=stop, retry_for=options.retry_for,
                latency=options.latency,
                before_line=source.leave_caption if isinstance(source, TerminalSource) else None,
            )  # fmt: skip
    except (
        ScriptError, ChannelError, WireError, MissingPygameError, MissingPylslError, MissingPocketsphinxError
    ) as error:  # fmt: skip
        print(f"iw-joystick: {error}", file=sys.stderr)
        return 2
    except (DeviceError, OSError) as error:
        print(f"iw-joystick: {error}", file=sys.stderr)
        return 1


def _source(options: argparse.Namespace, stop: threading.Event, stack: ExitStack) -> Source:
    name, shares = options.source, (options.forward, options.turn)
    if name == "auto":
        name = _automatic()
    if name == "script":
        return ScriptSource(read(options.script), simulated=options.clock == "simulated", stop=stop)
    if name == "words":
        return WordsSource(SpokenWords(*shares, options.hold), sys.stdin.fileno())
    if name == "voice":
        audio = _audio(options, stop, stack)
        return VoiceSource(WordRecogniser(audio.rate), audio, SpokenWords(*shares, options.hold))
    if name == "lsl":
        channels = ChannelMap(
            axes=options.axes, commands=options.commands, dead_zone=options.dead_zone,
            on=options.threshold[0], off=options.threshold[1], forward=shares[0], turn=shares[1],
        )  # fmt: skip
        return LslSource(options.stream_name, options.stream_type, channels, stop, options.retry_for or FIND_SECONDS)
    if name == "gamepad":
        return GamepadSource(*shares)
    in_terminal = name == "terminal" or options.keys_from == "terminal"
    if name in ("scan", "sip-puff") and options.keys_from == "auto":
        in_terminal = not has_display() or missing_extra("joystick") is not None
    reader = _reader(options, pause=REPEAT_PAUSE if in_terminal else 0.0)
    if in_terminal:
        return stack.enter_context(TerminalSource(reader, sys.stdin.fileno()))
    return KeyboardSource(f"iw-joystick {options.agent}", reader)


def _reader(options: argparse.Namespace, *, pause: float) -> KeyReader:
    """Return the meaning of the keys, which may seem released for some seconds while they are held."""
    shares = options.forward, options.turn
    if options.source == "scan":
        settings = ScanSettings(
            method=options.scan, period=options.scan_period, dwell=options.dwell, confirm=options.confirm,
            latch=options.latch, hold=options.hold, pause=pause,
        )  # fmt: skip
        return ScanKeys(settings, options.switch_keys, *shares)
    if options.source == "sip-puff":
        return SipAndPuff(options.signals, *shares, latch=options.latch, hold=options.hold)
    return DrivingKeys(*shares)


def _audio(options: argparse.Namespace, stop: threading.Event, stack: ExitStack) -> AudioInput:
    if options.audio == "-":
        return PipeInput(sys.stdin.fileno(), options.audio_rate)
    if options.audio == "mic":
        lacking = missing_extra("voice")
        if lacking is not None:
            raise MissingPocketsphinxError(f"--source voice: {lacking}")
        return stack.enter_context(closing(Microphone(options.audio_rate)))
    return WavInput(options.audio, stop)


def _automatic() -> str:
    """Return the best source: a gamepad, a window or the terminal. Without any, return one whose error says why."""
    has_terminal = sys.stdin.isatty()
    try:
        if has_gamepad():
            return "gamepad"
    except DeviceError:
        return "terminal" if has_terminal else "keyboard"
    return "terminal" if has_terminal and not has_display() else "keyboard"


if __name__ == "__main__":
    sys.exit(main())
