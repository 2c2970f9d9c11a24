"""`python -m intellwheels_schemas`: generates the files next to the package, or checks a document."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from intellwheels_schemas import elements, generate, rules
from intellwheels_schemas.codec import LIMITS, Encoding, decode, encoding_of
from intellwheels_schemas.command_parser import CommandParser
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.explain import too_long
from intellwheels_schemas.files import read_bytes
from intellwheels_schemas.messages import DOCUMENTS, Map, Record
from intellwheels_schemas.vectors import NAMES, class_of

_SCHEMAS = Path(__file__).resolve().parents[1]


def _parser() -> argparse.ArgumentParser:
    parser = CommandParser(
        prog="python -m intellwheels_schemas",
        usage="%(prog)s [--release] [COMMAND ...]",
        description="Without COMMAND, generate KEYS.md, xsd/, json/ and vectors/ in the folder schemas of a checkout.",
    )
    parser.add_argument(
        "--release",
        action="store_true",
        help="also record the current fields as released in released.json, so that a test keeps them from changing",
    )
    commands = parser.add_subparsers(dest="command", metavar="COMMAND")
    check = commands.add_parser(
        "check",
        prog="python -m intellwheels_schemas check",
        help="check a document, and print the first error and its place",
        description="Check a document, and print the first error and its place. "
        "Exit codes: 0 valid, 1 not valid, 2 wrong usage.",
    )
    check.add_argument("file", metavar="FILE", help="XML or JSON file; - for standard input")
    check.add_argument(
        "--as", dest="cls", metavar="CLASS", choices=sorted(NAMES),
        help="expected class of the document (default: the XML root, or for JSON the file name up to the first - or .)",
    )  # fmt: skip
    return parser


def _generate(release: bool) -> int:
    if _SCHEMAS.name != "schemas":
        print(f"expected to run from a checkout, with the package in schemas/; it is in {_SCHEMAS}", file=sys.stderr)
        return 1
    for name in generate.write(_SCHEMAS):
        print(f"made {name}")
    if release:
        (_SCHEMAS / generate.RELEASED).write_bytes(generate.released_text())
        print(f"made {generate.RELEASED}")
    return 0


def _class(data: bytes, encoding: Encoding, name: str, said: str | None) -> type[Record]:
    """Return the class of a document.

    Raises:
        ValueError: Neither the option nor the file name gives the class.
        WireError: The document is not XML, or has an unknown root.
    """
    if said is not None:
        return NAMES[said]
    if encoding is Encoding.XML:
        root = str(elements.parse(data, "document").tag)
        if root not in DOCUMENTS:
            raise WireError("malformed", f"expected a root of {', '.join(DOCUMENTS)}, got <{root[:40]}>")
        return DOCUMENTS[root][0]
    return class_of(Path(name).name)


def _check(file: str, said: str | None) -> int:
    try:
        data = sys.stdin.buffer.read() if file == "-" else Path(file).read_bytes()
    except OSError as error:
        print(f"FILE: expected a file, got {file!r}: {error.strerror}", file=sys.stderr)
        return 2
    try:
        encoding = encoding_of("", data.lstrip(b" \t\r\n"))
        cls = _class(data, encoding, file, said)
        if encoding is Encoding.XML:
            # A file for people may be longer than a message.
            limit = LIMITS.get(cls)
            if limit is not None and cls is not Map and len(data) > limit:
                raise too_long(file, limit, "bytes", len(data))
            rules.check(read_bytes(cls, data, file)[0])
        else:
            decode(cls, data, encoding)
    except WireError as error:
        text = error.text if error.text.startswith(file) else f"{file}: {error.text}"
        print(f"{text} ({error.code})", file=sys.stderr)
        return 1
    except ValueError as error:
        print(f"{file}: {error}; give the class with --as", file=sys.stderr)
        return 2
    name = next(name for name, one in NAMES.items() if one is cls)
    print(f"{file}: a valid {name}")
    return 0


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; return its exit code."""
    options = _parser().parse_args(arguments)
    if options.command == "check":
        return _check(options.file, options.cls)
    return _generate(options.release)


if __name__ == "__main__":
    sys.exit(main())
