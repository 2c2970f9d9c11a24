"""`iw-joystick`: drive a chair by hand, in a process of its own."""

from __future__ import annotations

import argparse
import math
import sys
import threading
from collections.abc import Sequence
from pathlib import Path

from intellwheels_agents.joystick.joystick_peer import operate
from intellwheels_agents.joystick.pygame_source import DeviceError, GamepadSource, KeyboardSource, is_gamepad_there
from intellwheels_agents.joystick.script_source import ScriptError, ScriptSource, read
from intellwheels_agents.joystick.wish import Source
from intellwheels_agents.joystick.words_source import Spoken, WordsSource
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.link import add_link_options, link_of
from intellwheels_schemas.names import check_agent
from intellwheels_schemas.process import add_process_options, stop_on_signals

EXAMPLES = """\
examples:
  the gamepad, or else the keyboard, for an agent whose mind takes user input
      iw-agent aided --name chair1 &  iw-joystick chair1
  take the chair from whatever mind it has, and give it back at the end
      iw-joystick chair1 --take
  a voice recogniser that prints words: forward, back, left, right, stop and any other
      recogniser | iw-joystick chair1 --source words
  a script: seconds, forward, turn, and perhaps buttons and a word, a line each
      iw-joystick chair1 --source script --script drive.txt

In real time only: a user counts as silent after 0.3 s, which a run as fast as it can is over in no time.
On standard output: `ready agent=...`, `taken agent=...`, `released agent=...`, `ended agent=...`.
Exit code 0: done; 1: refused or failed; 2: wrong usage.
"""


def parser() -> argparse.ArgumentParser:
    """Return the command line."""
    result = argparse.ArgumentParser(
        prog="iw-joystick",
        description="Write what a person wants to user/AGENT.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    result.add_argument("agent", metavar="AGENT", help="the agent that is driven")
    result.add_argument(
        "--source",
        choices=("auto", "keyboard", "gamepad", "script", "words"),
        default="auto",
        help="what the person uses (default: auto, a gamepad that is there, or the keyboard)",
    )
    result.add_argument("--script", type=Path, metavar="FILE", help="the lines of --source script")
    result.add_argument(
        "--clock", choices=("wall", "simulated"), default="wall", help="whose seconds a script counts (default: wall)"
    )
    result.add_argument(
        "--take", action="store_true", help="take a lease: the simulator itself obeys, whatever the agent's mind wants"
    )
    result.add_argument(
        "--forward", type=_share, default=1.0, metavar="SHARE", help="full forward, of what there is (default: 1)"
    )
    result.add_argument(
        "--turn", type=_share, default=0.5, metavar="SHARE", help="full turn, of what there is (default: 0.5)"
    )
    result.add_argument("--hold", type=_seconds, default=2.0, metavar="S", help="seconds a word drives (default: 2)")
    result.add_argument(
        "--retry-for",
        type=_seconds,
        metavar="S",
        help="give up when nobody answers for so many seconds (default: never)",
    )
    add_link_options(result)
    add_process_options(result)
    return result


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code: 0 done, 1 refused or failed, 2 wrong usage."""
    grammar = parser()
    options = grammar.parse_args(arguments)
    if (options.source == "script") != (options.script is not None):
        grammar.error("--script: expected a file with --source script, and only then")
    # First of all: a signal may come while the rest is still read.
    stop = stop_on_signals(options.lifeline)
    try:
        agent, where = check_agent(options.agent, "AGENT"), link_of(options)
        source = _source(options, stop)
        return operate(where, agent, source, take=options.take, stop=stop, retry_for=options.retry_for)
    except (ScriptError, WireError) as error:
        print(f"iw-joystick: {error}", file=sys.stderr)
        return 2
    except (DeviceError, OSError) as error:
        print(f"iw-joystick: {error}", file=sys.stderr)
        return 1


def _source(options: argparse.Namespace, stop: threading.Event) -> Source:
    name, shares = options.source, (options.forward, options.turn)
    if name == "script":
        return ScriptSource(read(options.script), simulated=options.clock == "simulated", stop=stop)
    if name == "words":
        return WordsSource(Spoken(*shares, options.hold), sys.stdin.fileno())
    if name == "gamepad" or (name == "auto" and is_gamepad_there()):
        return GamepadSource(*shares)
    return KeyboardSource(f"iw-joystick {options.agent}", *shares)


def _share(text: str) -> float:
    value = _number(text)
    if not 0.0 <= value <= 1.0:
        raise argparse.ArgumentTypeError(f"expected a share in [0, 1], got {text!r}")
    return value


def _seconds(text: str) -> float:
    value = _number(text)
    if not 0.0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"expected seconds above 0, got {text!r}")
    return value


def _number(text: str) -> float:
    """Return a number, NaN for what is none: no range has it."""
    try:
        return float(text)
    except ValueError:
        return math.nan


if __name__ == "__main__":
    sys.exit(main())
