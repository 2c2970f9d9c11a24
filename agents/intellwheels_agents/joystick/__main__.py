"""`iw-joystick`: drive a chair by hand."""

from __future__ import annotations

import argparse
import sys
import threading
from collections.abc import Sequence
from contextlib import ExitStack

from intellwheels_agents.joystick.input_state import Source
from intellwheels_agents.joystick.joystick_peer import operate
from intellwheels_agents.joystick.pygame_source import (
    DeviceError,
    GamepadSource,
    KeyboardSource,
    MissingPygameError,
    has_display,
    has_gamepad,
)
from intellwheels_agents.joystick.script_source import ScriptError, ScriptSource, read
from intellwheels_agents.joystick.terminal_source import TerminalSource
from intellwheels_agents.joystick.words_source import SpokenWords, WordsSource
from intellwheels_schemas.command_parser import CommandParser, positive_seconds, readable_file, share
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.link import add_link_options, link_of
from intellwheels_schemas.names import check_agent
from intellwheels_schemas.process import add_process_options, stop_on_signals

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
  play a script: on each line seconds, forward, turn, and optionally buttons and a word
      iw-joystick chair1 --source script --script drive.txt

The arrow keys, W A S D and I J K L give 0.6 of --forward and --turn, with shift all of it; space stops.
Use it with worlds at pace realtime. At the paces lockstep and free a run is too fast to steer by hand.
Each message is valid for 0.3 s and is repeated while the input lasts.
Standard output has the lines `ready agent=...`, `taken agent=...`, `released agent=...`, `ended agent=...`.
Exit codes: 0 done, 1 refused or failed, 2 wrong usage.
"""
OF_SOURCES = {
    "clock": ("script",),
    "forward": ("auto", "keyboard", "terminal", "gamepad", "words"),
    "turn": ("auto", "keyboard", "terminal", "gamepad", "words"),
    "hold": ("words",),
}
"""Options that only some sources use, which the others refuse."""


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
        choices=("auto", "keyboard", "terminal", "gamepad", "script", "words"),
        default="auto",
        help="input device. gamepad: its first stick; keyboard: the keys, in a window; terminal: the keys, in this "
        "terminal; words: words on standard input; script: a file; auto: a gamepad if one is connected, else keyboard, "
        "or terminal if there is no display (default: auto)",
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
        help="with --source words: seconds for which a word drives the chair (default: 2)",
    )
    result.add_argument(
        "--retry-for",
        type=positive_seconds,
        metavar="S",
        help="give up after S seconds without a router or simulator (default: never)",
    )
    add_link_options(result)
    add_process_options(result)
    return result


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code: 0 done, 1 refused or failed, 2 wrong usage."""
    command_line = parser()
    options = command_line.parse_args(arguments)
    if (options.source == "script") != (options.script is not None):
        got = "none" if options.script is None else repr(str(options.script))
        command_line.error(f"--script: expected a file with --source script, none with another source, got {got}")
    for name, sources in OF_SOURCES.items():
        if options.source not in sources and getattr(options, name) != command_line.get_default(name):
            command_line.error(f"--{name}: expected with --source {' or '.join(sources)}, got {options.source}")
    # First, because a signal may arrive while the other arguments are read.
    stop = stop_on_signals(options.lifeline)
    try:
        agent, where = check_agent(options.agent, "AGENT"), link_of(options)
        with ExitStack() as stack:
            source = _source(options, stop, stack)
            return operate(where, agent, source, take=options.take, stop=stop, retry_for=options.retry_for)
    except (ScriptError, WireError, MissingPygameError) as error:
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
    if name == "gamepad":
        return GamepadSource(*shares)
    if name == "terminal":
        return stack.enter_context(TerminalSource(*shares, sys.stdin.fileno()))
    return KeyboardSource(f"iw-joystick {options.agent}", *shares)


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
