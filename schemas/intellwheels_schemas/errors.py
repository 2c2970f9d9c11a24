"""The two kinds of error that other programs cause: wrong bytes, and a request that is refused.

Bugs in this project are not errors of these kinds. They crash with a traceback.
"""

from __future__ import annotations

from intellwheels_schemas.messages import ErrorCode, RefusedCode


class WireError(ValueError):
    """Bytes or a document that cannot be read.

    Attributes:
        code: Code of the `Error` message about it.
        where: Place, as a field or as file and line (`Actions.LeftMotor`, `maps/ward.xml:14`), or empty.
        text: The complete text, with the place.
    """

    def __init__(self, code: ErrorCode, text: str, where: str = "") -> None:
        super().__init__(text)
        self.code: ErrorCode = code
        self.text = text
        self.where = where


class RequestRefusedError(ValueError):
    """A request that is valid but refused; the text is sent to the process that made it.

    Attributes:
        code: Code of the `Refused` message about it.
        text: What is wrong, what was expected and what was received.
    """

    def __init__(self, code: RefusedCode, text: str) -> None:
        super().__init__(text)
        self.code: RefusedCode = code
        self.text = text


def wrong_value(where: str, expected: str, got: object, code: ErrorCode = "value") -> WireError:
    """Return the error for a wrong value of a field: its place, what was expected and what was received."""
    return WireError(code, f"{where}: expected {expected}, got {got}", where)


def got_of(error: OSError) -> str:
    """Return what was there instead of a file that could be read: `none`, or the reason in the system's words."""
    return "none" if isinstance(error, FileNotFoundError) else (error.strerror or str(error)).lower()
