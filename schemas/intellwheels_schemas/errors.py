"""The two errors that are not ours: their bytes, and their request. Our own bugs crash with their trace."""

from __future__ import annotations

from typing import Final

from intellwheels_schemas.messages import ErrorCode, RefusedCode


class WireError(ValueError):
    """Bytes, or a document, that cannot be read.

    Attributes:
        code: The code an `Error` message carries.
        where: The place in the wire's own names (`Actions.LeftMotor`, `maps/ward.xml:14`), or empty.
        text: The whole sentence, place included.
    """

    def __init__(self, code: ErrorCode, text: str, where: str = "") -> None:
        super().__init__(text)
        self.code: ErrorCode = code
        self.text = text
        self.where = where


class RequestRefusedError(ValueError):
    """A request that was understood and is not granted; its text goes back to who asked.

    Attributes:
        code: The code a `Refused` message carries.
        text: What is wrong, what was expected, what came.
    """

    def __init__(self, code: RefusedCode, text: str) -> None:
        super().__init__(text)
        self.code: RefusedCode = code
        self.text = text


REFUSED_FOR: Final[dict[ErrorCode, RefusedCode]] = {
    "malformed": "value",
    "encoding": "version",
    "version": "version",
    "field": "field",
    "value": "value",
    "too-long": "limit",
    "too-many": "limit",
}
"""The code of the refusal of a join whose bytes were in error."""
