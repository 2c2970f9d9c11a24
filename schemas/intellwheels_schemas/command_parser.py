"""The command line of every command: one line for each mistake, and the types of options.

A mistake is one line: the option, what was expected, what came, and where the help is. It ends the command with exit
code 2, before anything starts.
"""

from __future__ import annotations

import argparse
import contextlib
import math
import os
import re
import textwrap
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Final, NoReturn

from msgspec import inspect

from intellwheels_schemas.errors import WireError
from intellwheels_schemas.explain import check_scalar, did_you_mean, expected, fits, shown
from intellwheels_schemas.shapes import scalar_of

LONGEST_WAIT: Final = 1e9
"""Largest number of seconds that an option takes: 30 years."""
_LAST_PORT: Final = 65535


class _Help(argparse.HelpFormatter):
    """Help whose lines break at spaces only, so that a value such as `hard-puff=up` stays whole."""

    def _split_lines(self, text: str, width: int) -> list[str]:
        return textwrap.wrap(" ".join(text.split()), width, break_on_hyphens=False)


class _HelpWithExamples(argparse.RawDescriptionHelpFormatter, _Help):
    """The same, with the lines of the description and the epilog as they are."""


class CommandParser(argparse.ArgumentParser):
    """A parser whose errors are one line each. Parsers of subcommands are of this class too."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        raw = self.formatter_class is argparse.RawDescriptionHelpFormatter
        self.formatter_class = _HelpWithExamples if raw else _Help

    def error(self, message: str) -> NoReturn:
        """Print a mistake as one line, and exit with 2."""
        text = " ".join(_in_words(self, message).split())
        see = " See" if text.endswith("?") else "; see"
        self.exit(2, f"{self.prog}: {text}{see} {self.prog} --help\n")


@contextlib.contextmanager
def naming(option: str) -> Iterator[None]:
    """Put the name of an option before the text of an error that is raised inside.

    Raises:
        WireError: The same one, with the option in its text.
    """
    try:
        yield
    except WireError as error:
        if error.text.startswith(option):
            raise
        raise WireError(error.code, f"{option}: {error.text}", option) from None


# ---------------------------------------------------------------- types


def _interval(low: float, high: float, low_open: bool) -> str:
    if math.isinf(low) and math.isinf(high):
        return ""
    if math.isinf(high):
        return f" above {low:g}" if low_open else f" of at least {low:g}"
    return f" in {'(' if low_open else '['}{low:g}, {high:g}]"


def number(
    noun: str, low: float = -math.inf, high: float = math.inf, *, low_open: bool = False
) -> Callable[[str], float]:
    """Return the type of an option that is a finite number.

    Args:
        noun: What it is: `a number`, `seconds`.
        low: Smallest value.
        high: Largest value.
        low_open: Whether `low` itself is refused.
    """
    wanted = f"{noun}{_interval(low, high, low_open)}"

    def read(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = math.nan  # outside every range
        if not math.isfinite(value) or not low <= value <= high or (low_open and value == low):
            raise argparse.ArgumentTypeError(f"expected {wanted}, got {shown(text)}")
        return value

    return read


def whole(low: int, high: int, noun: str = "a whole number") -> Callable[[str], int]:
    """Return the type of an option that is a whole number in [low, high]."""

    def read(text: str) -> int:
        # More digits than any bound has would also be slow to convert.
        value = int(text) if text.isascii() and text.isdigit() and len(text) <= 20 else None
        if value is None or not low <= value <= high:
            raise argparse.ArgumentTypeError(f"expected {noun} in [{low}, {high}], got {shown(text)}")
        return value

    return read


def like_field(kind: Any) -> Callable[[str], Any]:
    """Return the type of an option with the bounds of a field of the contract, such as `messages.Factor`."""
    scalar = scalar_of(inspect.type_info(kind))
    if scalar is None:
        raise TypeError(f"expected a type of one number or text, got {kind}")

    def read(text: str) -> Any:
        if scalar.kind == "text":
            try:
                check_scalar(scalar, text, "")
            except WireError as error:
                raise argparse.ArgumentTypeError(error.text.removeprefix(": ")) from None
            return text
        try:
            value = float(text)
        except ValueError:
            value = math.nan  # outside every range
        if not fits(scalar, value):
            raise argparse.ArgumentTypeError(f"expected {expected(scalar)}, got {shown(text)}")
        return value

    return read


positive_seconds = number("seconds", 0.0, LONGEST_WAIT, low_open=True)
share = number("a share", 0.0, 1.0)
port = whole(0, _LAST_PORT, "a port")


def open_descriptor(text: str) -> int:
    """Return the number of an open file descriptor, the type of `--lifeline`."""
    value = int(text) if text.isascii() and text.isdigit() and len(text) < 10 else -1
    try:
        os.fstat(value)
    except OSError:
        raise argparse.ArgumentTypeError(f"expected an open file descriptor, got {shown(text)}") from None
    return value


def readable_file(text: str) -> Path:
    """Return the path of a file that can be read, the type of an option for input. The file may also be a pipe."""
    path = Path(text)
    if not text or not path.exists():
        raise argparse.ArgumentTypeError(f"expected a file that exists, got {text!r}")
    if path.is_dir():
        raise argparse.ArgumentTypeError(f"expected a file, got the folder {text}")
    if not os.access(path, os.R_OK):
        raise argparse.ArgumentTypeError(f"expected a file that may be read, got {text}")
    return path


# ---------------------------------------------------------------- argparse's own errors


def _in_words(parser: argparse.ArgumentParser, message: str) -> str:
    """Return an error of argparse as: the option, what was expected, what came."""
    for pattern, say in _ERRORS:
        found = re.fullmatch(pattern, message, re.DOTALL)
        if found is not None:
            return say(parser, *found.groups())
    return message


def _argument(parser: argparse.ArgumentParser, name: str, text: str) -> str:
    action = next((one for one in parser._actions if name in _names(one)), None)
    for pattern, say in _VALUES:
        found = re.fullmatch(pattern, text, re.DOTALL)
        if found is not None:
            return f"{name}: {say(action, *found.groups())}"
    return f"{name}: {text}"


def _names(action: argparse.Action) -> tuple[object, ...]:
    """Return the names that argparse's errors give to an option or argument."""
    return "/".join(action.option_strings), action.metavar, action.dest


def _no_value(action: argparse.Action | None) -> str:
    metavar = action.metavar if action is not None else None
    if action is not None and metavar is None and action.choices is not None:
        return f"expected one of {', '.join(map(str, action.choices))}, got none"
    return f"expected {metavar or 'a value'}, got none"


def _wrong_choice(action: argparse.Action | None, got: str, listed: str) -> str:
    if action is None or action.choices is None:
        return f"expected one of {listed}, got {got}"
    known = [str(choice) for choice in action.choices]
    return f"expected one of {', '.join(known)}, got {got}{did_you_mean(got.strip(chr(39)), known)}"


def _unknown(parser: argparse.ArgumentParser, words: str) -> str:
    first = words.split(" ", maxsplit=1)[0]
    if not first.startswith("-"):
        return f"expected no further argument, got {shown(words)}"
    name = first.partition("=")[0]
    known = [text for action in parser._actions for text in action.option_strings]
    return f"{name}: expected an option of {parser.prog}, got {name!r}{did_you_mean(name, known)}"


_VALUES: Final[tuple[tuple[str, Callable[..., str]], ...]] = (
    (r"expected (?:one|at least one) argument", _no_value),
    (r"invalid choice: (.*) \(choose from (.*)\)", _wrong_choice),
    (r"ignored explicit argument (.*)", lambda _, got: f"expected no value, got {got}"),
    (r"invalid (?:float) value: (.*)", lambda _, got: f"expected a number, got {got}"),
    (r"invalid (?:int) value: (.*)", lambda _, got: f"expected a whole number, got {got}"),
)
_ERRORS: Final[tuple[tuple[str, Callable[..., str]], ...]] = (
    (r"argument ([^:]+): (.*)", _argument),
    (r"the following arguments are required: (.*)", lambda _, names: f"{names}: expected a value, got none"),
    (r"ambiguous option: (\S+) could match (.*)", lambda _, got, names: f"{got}: expected one of {names}, got {got!r}"),
    (r"unrecognized arguments: (.*)", _unknown),
)


def add_retry_option(parser: argparse.ArgumentParser, what: str = "a router or simulator") -> None:
    """Add `--retry-for`, which is `retry_for` in the result: seconds, or infinity, after which the command gives up.

    Args:
        parser: The command's parser.
        what: What the command waits for, for its help.
    """
    parser.add_argument(
        "--retry-for", type=positive_seconds, default=math.inf, metavar="S",
        help=f"give up after S seconds without {what} (default: never)",
    )  # fmt: skip
