"""The options of `iw-joystick`."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Final, TypeVar

from intellwheels_agents.joystick.key_bindings import DEAD_ZONE
from intellwheels_agents.joystick.lsl_channels import ChannelError, parse_threshold, parse_uses
from intellwheels_agents.joystick.lsl_source import FIND_SECONDS, stream_text
from intellwheels_agents.joystick.scan_keys import DEFAULT_KEYS
from intellwheels_agents.joystick.sip_and_puff import DEFAULT_KEYS as DEFAULT_SIGNALS
from intellwheels_agents.joystick.sip_and_puff import SIGNALS
from intellwheels_agents.joystick.voice_words import RATES
from intellwheels_agents.user_input import WORDS
from intellwheels_schemas.command_parser import CommandParser, number, positive_seconds, readable_file, share, whole
from intellwheels_schemas.explain import shown
from intellwheels_schemas.link import add_link_options
from intellwheels_schemas.process import add_process_options
from intellwheels_schemas.switch_scan import METHODS

T = TypeVar("T")

KEY_NAMES: Final = ("space", "enter", "tab", "up", "down", "left", "right")
"""The keys that have a name."""
EXAMPLES = """\
examples:
  drive an agent whose mind accepts user input, with a gamepad or the keyboard
      iw-agent aided --name chair1 &  iw-joystick chair1
  take a chair from any mind, and give it back at the end
      iw-joystick chair1 --take
  drive by voice, with a recogniser that prints one of forward, back, left, right and stop; any other word is passed to
  the mind
      recogniser | iw-joystick chair1 --source words
  drive over ssh, with the keys of the terminal; releasing them cuts the motors' power within 0.4 s
      iw-joystick chair1 --source terminal
  drive with one switch, which sends space, or with a sip-and-puff switch, which sends keys
      iw-joystick chair1 --source scan --scan-period 1.5
      iw-joystick chair1 --source sip-puff --signals hard-puff=w,hard-sip=s,soft-puff=d,soft-sip=a
  drive by the stream of a brain-computer interface, or of any device for Lab Streaming Layer
      iw-joystick chair1 --source lsl --stream-type EEG --axes forward=0,turn=1*-1 --commands stop=2
  drive by voice, without a network; say forward, left, right, stop, or reverse (back is too easily misheard)
      iw-joystick chair1 --source voice
  play a script: on each line seconds, forward, turn, and optionally buttons and a word
      iw-joystick chair1 --source script --script drive.txt

The arrow keys, W A S D and I J K L give 0.6 of --forward and --turn, and with shift the full value; space stops.
Use it with worlds at pace realtime. At the paces lockstep and free a run is too fast to steer by hand.
Each message is valid for 0.3 s and is repeated while the input lasts. Input of a device that is older than 0.3 s
counts as none.
Standard output has the lines `ready agent=...`, `taken agent=...`, `released agent=...`, `ended agent=...`, and with
--latency `latency agent=...`.
Exit codes: 0 done, 1 refused or failed, 2 wrong usage. A gamepad and keys in a window need the extra `joystick`,
--source lsl the extra `lsl`, and voice the extra `voice`.
"""
SOURCES: Final = (
    "auto", "keyboard", "terminal", "gamepad", "script", "words", "scan", "sip-puff", "lsl", "voice",
)  # fmt: skip
OF_SOURCES: Final = {
    "clock": ("script",),
    "forward": tuple(name for name in SOURCES if name != "script"),
    "turn": tuple(name for name in SOURCES if name != "script"),
    "hold": ("words", "voice", "scan", "sip-puff"),
    "latch": ("scan", "sip-puff"),
    "keys_from": ("scan", "sip-puff"),
    "scan": ("scan",),
    "scan_period": ("scan",),
    "dwell": ("scan",),
    "confirm": ("scan",),
    "switch_keys": ("scan",),
    "signals": ("sip-puff",),
    "stream_name": ("lsl",),
    "stream_type": ("lsl",),
    "axes": ("lsl",),
    "commands": ("lsl",),
    "threshold": ("lsl",),
    "dead_zone": ("lsl",),
    "audio": ("voice",),
    "audio_rate": ("voice",),
}
"""Options that only some sources use, which the others refuse."""
OF_SCANS: Final = {"scan_period": "auto", "dwell": "dwell"}
"""Options that only one method of scanning uses."""


def parser() -> argparse.ArgumentParser:
    """Return the command line."""
    result = CommandParser(
        prog="iw-joystick",
        description="Drive a chair by hand: send a person's input to the Zenoh key user/AGENT.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    result.add_argument("agent", metavar="AGENT", help="the agent to drive")
    result.add_argument(
        "--source",
        choices=SOURCES,
        default="auto",
        help="input device. gamepad: its first stick; keyboard: the keys, in a window; terminal: the keys, in this "
        "terminal; words: words on standard input; script: a file; scan: one or two switches that choose a command; "
        "sip-puff: a sip-and-puff switch that sends keys; lsl: a stream of Lab Streaming Layer; voice: spoken words; "
        "auto: a gamepad if one is connected, else keyboard, or terminal if there is no display (default: auto)",
    )
    result.add_argument("--script", type=readable_file, metavar="FILE", help="with --source script: the file to play")
    result.add_argument(
        "--clock",
        choices=("wall", "simulated"),
        default="wall",
        help="with --source script: clock for the times in the script (default: wall)",
    )
    result.add_argument(
        "--take",
        action="store_true",
        help="drive the chair instead of its mind, until this command ends or loses contact",
    )
    result.add_argument(
        "--forward",
        type=share,
        default=1.0,
        metavar="SHARE",
        help="input sent when the stick is fully forward, in [0, 1]; the mind decides what 1 means (joystick: full "
        "motor power; aided: its option `speed`; with --take: full motor power); not with --source script (default: 1)",
    )
    result.add_argument(
        "--turn",
        type=share,
        default=0.5,
        metavar="SHARE",
        help="input sent when the stick is fully to one side, in [0, 1]; not with --source script (default: 0.5)",
    )
    result.add_argument(
        "--hold",
        type=positive_seconds,
        default=2.0,
        metavar="S",
        help="seconds for which a word drives the chair, and the longest time that a command drives without a held "
        "switch; with --source words, voice, scan or sip-puff (default: 2)",
    )
    result.add_argument(
        "--latency",
        action="store_true",
        help="measure the time in seconds from the device to the motors, and print it at the end",
    )
    result.add_argument(
        "--retry-for",
        type=positive_seconds,
        metavar="S",
        help="give up after S seconds without a router or simulator (default: never), or, with --source lsl, without a "
        f"stream at the start (default: {FIND_SECONDS:g})",
    )
    _add_key_options(result)
    _add_stream_options(result)
    _add_voice_options(result)
    add_link_options(result)
    add_process_options(result)
    return result


def _add_key_options(result: argparse.ArgumentParser) -> None:
    group = result.add_argument_group("switches (--source scan and sip-puff)")
    group.add_argument(
        "--keys-from",
        choices=("auto", "window", "terminal"),
        default="auto",
        help="where keys come from: a window, in which a release is seen, or this terminal, in which a key counts for "
        "0.3 s after its last character; auto: a window if there is a display (default: auto)",
    )
    group.add_argument(
        "--scan",
        choices=METHODS,
        default="auto",
        help="auto: the highlight moves by itself and switch 1 selects; step: switch 1 moves it and switch 2 selects; "
        "dwell: switch 1 moves it and a rest selects (default: auto)",
    )
    group.add_argument(
        "--scan-period", type=number("seconds", 0.2, 60.0), default=1.5, metavar="S",
        help="with --scan auto: seconds for which each command is highlighted, in [0.2, 60] (default: 1.5)",
    )  # fmt: skip
    group.add_argument(
        "--dwell", type=number("seconds", 0.2, 60.0), default=1.0, metavar="S",
        help="with --scan dwell: seconds of rest that select, in [0.2, 60] (default: 1)",
    )  # fmt: skip
    group.add_argument(
        "--confirm", action="store_true", help="with scan: a command drives only when it is selected twice"
    )
    group.add_argument(
        "--latch",
        action="store_true",
        help="a command drives on after its switch is released, until the next press; a hard puff, until a hard sip; "
        "both for at most --hold seconds",
    )
    group.add_argument(
        "--switch-keys", type=_switch_keys, default=DEFAULT_KEYS, metavar="KEY,KEY",
        help="with scan: the keys of switches 1 and 2, or of the only one; each is a character, space, enter, tab, or "
        "the name of an arrow key: up, down, left or right (default: space,enter)",
    )  # fmt: skip
    group.add_argument(
        "--signals", type=_signals, default=DEFAULT_SIGNALS, metavar="SIGNAL=KEY,...",
        help=f"with sip-puff: the keys of {', '.join(DEFAULT_SIGNALS)} (default: "
        + ", ".join(f"{signal}={key}" for signal, key in DEFAULT_SIGNALS.items()) + ")",
    )  # fmt: skip


def _add_stream_options(result: argparse.ArgumentParser) -> None:
    group = result.add_argument_group("streams (--source lsl)")
    group.add_argument(
        "--stream-name", type=_of(stream_text), metavar="STREAM",
        help="name of the stream; this or --stream-type is required",
    )  # fmt: skip
    group.add_argument(
        "--stream-type", type=_of(stream_text), metavar="STREAM",
        help="type of the stream, such as EEG; this or --stream-name is required",
    )  # fmt: skip
    group.add_argument(
        "--axes", type=_of(lambda text: parse_uses(text, "--axes")), default=(), metavar="AXIS=CHANNEL,...",
        help="channels that are axes: forward and turn (positive to the left), each by number, from 0, or by label, "
        "and optionally a factor: forward=0,turn=Fz*-0.5. A value of 1 after the factor is full deflection; this or "
        "--commands is required for a stream of numbers",
    )  # fmt: skip
    group.add_argument(
        "--commands", type=_of(lambda text: parse_uses(text, "--commands")), default=(), metavar="COMMAND=CHANNEL,...",
        help=f"channels that are commands: {', '.join(WORDS)}; this or --axes is required for a stream of numbers",
    )  # fmt: skip
    group.add_argument(
        "--threshold", type=_of(parse_threshold), default=(0.5, 0.5), metavar="ON[,OFF]",
        help="a command is on from the value ON, and off again below the value OFF, which is at most ON (default: 0.5; "
        "OFF equal to ON)",
    )  # fmt: skip
    group.add_argument(
        "--dead-zone", type=number("a share", 0.0, 0.9), default=DEAD_ZONE, metavar="SHARE",
        help=f"share of an axis that counts as centred, in [0, 0.9] (default: {DEAD_ZONE})",
    )  # fmt: skip


def _add_voice_options(result: argparse.ArgumentParser) -> None:
    group = result.add_argument_group("voice (--source voice)")
    group.add_argument(
        "--audio", type=_audio, default="mic", metavar="mic|-|FILE.wav",
        help="sound: mic is the microphone, FILE.wav a recording, - raw signed 16-bit samples of one channel on "
        "standard input (default: mic)",
    )  # fmt: skip
    group.add_argument(
        "--audio-rate", type=whole(*RATES, "samples a second"), default=RATES[0], metavar="HZ",
        help="samples a second of the microphone or of standard input, in "
        f"[{RATES[0]}, {RATES[1]}] (default: {RATES[0]})",
    )  # fmt: skip


def check(command_line: argparse.ArgumentParser, options: argparse.Namespace) -> None:
    """End the command with exit code 2 when options do not go together."""
    source = options.source
    if (source == "script") != (options.script is not None):
        lacking, given_too = "a file with --source script, got none", f"with --source script, got {source}"
        command_line.error(f"--script: expected {lacking if options.script is None else given_too}")
    given = {name: getattr(options, name) != command_line.get_default(name) for name in OF_SOURCES}
    for name, sources in OF_SOURCES.items():
        if source not in sources and given[name]:
            command_line.error(f"--{_dashed(name)}: expected with --source {' or '.join(sources)}, got {source}")
    for name, method in OF_SCANS.items():
        if source == "scan" and options.scan != method and given[name]:
            command_line.error(f"--{_dashed(name)}: expected with --scan {method}, got {options.scan}")
    if source == "scan" and options.scan == "step" and len(options.switch_keys) < 2:
        command_line.error(f"--switch-keys: expected two keys with --scan step, got {options.switch_keys[0]}")
    if source == "lsl" and options.stream_name is None and options.stream_type is None:
        command_line.error("--stream-name, --stream-type: expected at least one with --source lsl, got none")
    if source == "scan" and options.scan == "dwell" and options.latch:
        command_line.error("--latch: expected with --scan auto or step, got dwell, whose commands always drive on")
    if given["hold"] and not options.latch and (source == "sip-puff" or (source == "scan" and options.scan != "dwell")):
        command_line.error(f"--hold: expected with --latch, or with --scan dwell, for --source {source}, got neither")
    for name, needed in (("threshold", "commands"), ("dead_zone", "axes")):
        if given[name] and not getattr(options, needed):
            command_line.error(f"--{_dashed(name)}: expected with --{needed}, got none")
    if source == "voice" and given["audio_rate"] and options.audio not in ("mic", "-"):
        command_line.error(
            f"--audio-rate: expected with --audio mic or -, got the file {options.audio}, which has its own"
        )


def _dashed(name: str) -> str:
    return name.replace("_", "-")


def _of(read: Callable[[str], T]) -> Callable[[str], T]:
    """Return a type of an option from a function that raises `ChannelError`."""

    def convert(text: str) -> T:
        try:
            return read(text)
        except ChannelError as error:
            words = str(error)
            raise argparse.ArgumentTypeError(words.partition(": ")[2] if words.startswith("--") else words) from None

    return convert


def _key(text: str) -> str:
    name = text.strip().lower()
    # A character that a terminal and a window name alike; escape ends, and shift is no key of its own.
    if name not in KEY_NAMES and (len(name) != 1 or not name.isascii() or not name.isprintable()):
        raise argparse.ArgumentTypeError(f"expected a character or one of {', '.join(KEY_NAMES)}, got {shown(text)}")
    return name


def _switch_keys(text: str) -> tuple[str, ...]:
    keys = tuple(_key(part) for part in text.split(","))
    if len(keys) > 2 or len(set(keys)) < len(keys):
        raise argparse.ArgumentTypeError(f"expected one key, or two different ones, got {shown(text)}")
    return keys


def _signals(text: str) -> dict[str, str]:
    keys = dict(DEFAULT_SIGNALS)
    for part in text.split(","):
        signal, equals, key = part.strip().partition("=")
        if not equals or signal not in SIGNALS:
            raise argparse.ArgumentTypeError(f"expected SIGNAL=KEY with one of {', '.join(SIGNALS)}, got {shown(part)}")
        keys[signal] = _key(key)
    if len(set(keys.values())) < len(keys):
        raise argparse.ArgumentTypeError(f"expected a key of its own for each signal, got {shown(text)}")
    return keys


def _audio(text: str) -> str | Path:
    return text if text in ("mic", "-") else readable_file(text)
