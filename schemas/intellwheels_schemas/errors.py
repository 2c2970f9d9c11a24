"""The two kinds of error that others cause: wrong bytes, and a request that is refused.

Bugs of our own are no error of these kinds: they crash with their traceback.
"""

from __future__ import annotations

from intellwheels_schemas.messages import ErrorCode, RefusedCode


class WireError(ValueError):
    """Bytes or a document that cannot be read.

    Attributes:
        code: Code of the `Error` message about it.
        where: Place, in the names of the wire or as file and line (`Actions.LeftMotor`, `maps/ward.xml:14`), or empty.
        text: The whole sentence, with the place.
    """

    def __init__(self, code: ErrorCode, text: str, where: str = "") -> None:
        super().__init__(text)
        self.code: ErrorCode = code
        self.text = text
        self.where = where


class RequestRefusedError(ValueError):
    """A request that was understood but is refused; the text is sent back to whoever made it.

    Attributes:
        code: Code of the `Refused` message about it.
        text: What is wrong, what was expected and what came.
    """

    def __init__(self, code: RefusedCode, text: str) -> None:
        super().__init__(text)
        self.code: RefusedCode = code
        self.text = text


def wrong_value(where: str, expected: str, got: object, code: ErrorCode = "value") -> WireError:
    """Return the error of a field: where it is in the wire's names, what was expected and what came."""
    return WireError(code, f"{where}: expected {expected}, got {got}", where)
