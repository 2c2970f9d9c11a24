"""The mistakes of a mind, named by file and line.

A mind is its author's program. Whatever it raises or returns must not end in a traceback through the harness.
"""

from __future__ import annotations

import inspect
import sysconfig
import traceback
from pathlib import Path
from types import FrameType
from typing import Any, Final

from intellwheels_agents.options import OptionError
from intellwheels_schemas.errors import WireError

USER_ERRORS: Final = (OptionError, WireError, ConnectionError)
"""Errors that a mind passes on: a wrong option, a map without a place, no simulator. They are the user's to mend."""


_LIBRARIES: Final = (
    str(Path(__file__).parent), *(sysconfig.get_path(name) for name in ("stdlib", "purelib", "platlib")), "<",
)  # fmt: skip
"""Where the files of libraries and of this package are, and how the names of code without a file begin."""


class MindError(RuntimeError):
    """A mind failed or returned something wrong; the text says where, what was expected and what came."""


def failed(mind: object, error: BaseException) -> MindError:
    """Return the error for an exception that a mind raised.

    Args:
        mind: The mind, or its class while it is made, or its file while it is read.
        error: The exception. The line is the innermost one in the mind's own file, or else the innermost one.
    """
    file = _file_of(mind)
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if file is not None and frame.filename == file]
    place = own[-1] if own else frames[-1] if frames else None
    where = "a mind" if place is None else f"{_short(place.filename)}:{place.lineno}: {place.name}"
    return MindError(f"{where}: {type(error).__name__}: {error}")


def wrong_answer(mind: object, expected: str, got: object) -> MindError:
    """Return the error for a wrong answer of a mind; the place is its method `decide`."""
    where = "decide"
    decide = getattr(type(mind), "decide", None)
    code = getattr(decide, "__code__", None)
    if code is not None:
        where = f"{_short(code.co_filename)}:{code.co_firstlineno}: decide"
    return MindError(f"{where}: expected {expected}, got {_shown(got)}")


def place_in(frame: FrameType | None) -> str:
    """Return where a thread is, as file and line: the innermost line outside of libraries, or else the innermost."""
    places = [] if frame is None else [(one.f_code.co_filename, line) for one, line in traceback.walk_stack(frame)]
    own = [place for place in places if not place[0].startswith(_LIBRARIES)]
    for filename, line in (*own, *places):
        return f"{_short(filename)}:{line}"
    return "an unknown place"


def _shown(got: object) -> str:
    if got is None:
        return "None; is a `return` missing?"
    return f"{repr(got)[:80]} ({type(got).__name__})"


def _file_of(mind: object) -> str | None:
    if isinstance(mind, Path):
        return str(mind)
    kind: Any = mind if inspect.isclass(mind) else type(mind)
    try:
        return inspect.getfile(kind)
    except (OSError, TypeError):
        return None


def _short(filename: str) -> str:
    """Return a file's path, from the working directory if it is below."""
    path = Path(filename)
    return str(path.relative_to(Path.cwd())) if path.is_relative_to(Path.cwd()) else filename
