"""Reads and writes files for people: maps, robots and scenes. They are XML, with comments and indentation.

No other module of the contract reads files. Errors give the file and the line.
"""

from __future__ import annotations

from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Final, TypeVar

import msgspec
from lxml import etree

from intellwheels_schemas import elements, rules
from intellwheels_schemas.codec import from_plain
from intellwheels_schemas.errors import WireError, got_of
from intellwheels_schemas.explain import root_of, too_long
from intellwheels_schemas.messages import Record

_M = TypeVar("_M", bound=Record)

MAX_FILE_BYTES: Final = 16 << 20
"""Longest file, 16 MiB. For a map that is sent with `load`, the limit of the message applies."""


class Lines:
    """The line number of each element of a file.

    The place of an element is written as in errors: `Map.Wall[3].Corner[0]`, with list items counted from 0.
    """

    def __init__(self, file: str, lines: dict[str, int]) -> None:
        self.file = file
        self._lines = lines

    def at(self, place: str) -> int:
        """Return the line of a place, or of the nearest element around it; at least 1."""
        while place not in self._lines and "." in place:
            place = place.rpartition(".")[0]
        return max(self._lines.get(place, 1), 1)

    def error(self, wrong: WireError) -> WireError:
        """Return the same error with file and line before its text."""
        place = f"{self.file}:{self.at(wrong.where)}"
        return WireError(wrong.code, f"{place}: {wrong.text}", place)


def read_with_lines(cls: type[_M], file: str | Path | Traversable) -> tuple[_M, Lines]:
    """Return a document and the lines of its elements.

    Args:
        cls: The class of the document.
        file: Path, or a resource of a package.

    Raises:
        WireError: The file is missing, too long or invalid; place and text start with file and line.
    """
    path = Path(file) if isinstance(file, str) else file
    try:
        data = path.read_bytes()
    except OSError as error:
        raise WireError("value", f"{path}: expected a file, got {got_of(error)}", str(path)) from None
    if len(data) > MAX_FILE_BYTES:
        raise too_long(str(path), MAX_FILE_BYTES, "bytes", len(data))
    return read_bytes(cls, data, str(path))


def read_bytes(cls: type[_M], data: bytes, name: str) -> tuple[_M, Lines]:
    """Return a document from the bytes of an XML file, and the lines of its elements. Errors give the file as `name`.

    Raises:
        WireError: As for `read_with_lines`.
    """
    root = root_of(cls)
    _check_encoding(data, name)
    try:
        element = elements.parse(data, root)
    except WireError as error:
        line = getattr(error.__cause__, "lineno", None) or 1
        raise Lines(name, {root: line}).error(error) from None
    lines = Lines(name, dict(elements.places(element, cls, root)))
    if element.tag != root:
        wrong = WireError("malformed", f"expected <{root}>, got <{str(element.tag)[:40]}>", root)
        raise lines.error(wrong)
    try:
        plain = elements.to_plain(element, cls, root, strict=True)
        try:
            message = msgspec.convert(plain, cls)
        except msgspec.ValidationError:
            message = from_plain(cls, plain)
        rules.check(message)
    except WireError as error:
        raise lines.error(error) from None
    return message, lines


def _check_encoding(data: bytes, name: str) -> None:
    """Check that a file is UTF-8, whatever encoding it declares."""
    try:
        data.decode()
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        place = f"{name}:{line}"
        text = f"{place}: expected text in UTF-8, got the byte 0x{data[error.start]:02x}; save the file as UTF-8"
        raise WireError("malformed", text, place) from None


def write_file(message: Record) -> str:
    """Return a document as XML for people: one element per line, indented by two, with a line feed at the end."""
    root = etree.fromstring(elements.to_xml(message).encode(), etree.XMLParser(strip_cdata=False))
    etree.indent(root)
    return etree.tostring(root, encoding="unicode") + "\n"
