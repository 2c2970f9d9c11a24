"""Generates files from the message classes."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Final

from intellwheels_schemas.codec import Encoding, decode, encode
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.explain import expected
from intellwheels_schemas.json_schema import json_schemas
from intellwheels_schemas.keys_page import keys_page
from intellwheels_schemas.messages import Record
from intellwheels_schemas.reader_xsd import reader_files
from intellwheels_schemas.schematron import schematron
from intellwheels_schemas.shapes import Member, number_text, shape_of
from intellwheels_schemas.vectors import GROWN, NAMES, REFUSED, VALID, class_of, encoding_of_file, index_of
from intellwheels_schemas.xsd import xsd_files

FOLDERS: Final = ("xsd", "json", "vectors")
"""Folders that contain only generated files. Any other file in them is stale."""

RELEASED: Final = "released.json"

_ENDINGS: Final = {Encoding.JSON: "json", Encoding.XML: "xml"}


def _pretty(data: Any) -> bytes:
    return (json.dumps(data, indent=2, ensure_ascii=True) + "\n").encode()


def _refusal(name: str, data: bytes) -> str:
    try:
        decode(class_of(name), data, encoding_of_file(name))
    except WireError as error:
        return error.text
    raise ValueError(f"{name}: expected a document that is refused, it was accepted")


def generated() -> dict[str, bytes]:
    """Return all generated files by their paths in `schemas/`."""
    files = {f"xsd/writer/{name}": text.encode() for name, text in xsd_files().items()}
    files |= {f"xsd/reader/{name}": text.encode() for name, text in reader_files().items()}
    files["xsd/rules.sch"] = schematron().encode()
    for folder, grows in (("reader", True), ("writer", False)):
        for name, schema in json_schemas(grows=grows).items():
            files[f"json/{folder}/{name}.json"] = _pretty(schema)
    files["KEYS.md"] = keys_page().encode()
    for name, message in VALID.items():
        for encoding, ending in _ENDINGS.items():
            files[f"vectors/{name}.{ending}"] = encode(message, encoding)
    for grown in GROWN:
        files[f"vectors/grown/{grown.name}"] = grown.data.encode()
    for wrong in REFUSED:
        files[f"vectors/refused/{wrong.name}"] = wrong.data
    files["vectors/refused/index.json"] = _pretty([index_of(w, _refusal(w.name, w.data)) for w in REFUSED])
    files["vectors/grown/index.json"] = _pretty([{"File": grown.name, "Same": grown.same} for grown in GROWN])
    return files


def write(folder: Path) -> list[str]:
    """Write the generated files into `schemas/`, remove stale ones, and return the paths of those that changed."""
    changed = stale(folder)
    files = generated()
    for name in changed:
        path = folder / name
        if name in files:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(files[name])
        else:
            path.unlink()
    return changed


def stale(folder: Path) -> list[str]:
    """Return the sorted paths in `schemas/` that differ from the generated files."""
    files = generated()
    there = {
        path.relative_to(folder).as_posix() for name in FOLDERS for path in (folder / name).rglob("*") if path.is_file()
    }
    wrong = {
        name for name, data in files.items() if not (folder / name).is_file() or (folder / name).read_bytes() != data
    }
    return sorted(wrong | (there - files.keys()))


# ---------------------------------------------------------------- released fields


def _signature(member: Member) -> dict[str, Any]:
    kind = member.record.__name__ if member.record is not None else ""
    if member.scalar is not None:
        scalar = member.scalar
        kind = f"{scalar.kind}: {expected(scalar)}"
        if scalar.max_length is not None:
            kind += f", at most {scalar.max_length} characters"
    default = member.default
    if isinstance(default, float):
        default = number_text(default)
    return {
        "Is": kind, "Form": member.form.value, "Unit": member.scalar.unit if member.scalar is not None else "",
        "Required": member.required, "Default": list(default) if isinstance(default, tuple) else default,
        "AtMost": member.max_count,
    }  # fmt: skip


def fields() -> dict[str, dict[str, dict[str, Any]]]:
    """Return the type, bounds, unit and default of all fields of all classes, to compare with the released ones."""
    found: dict[str, dict[str, dict[str, Any]]] = {}

    def add(cls: type[Record]) -> None:
        if cls.__name__ not in found:
            shape = shape_of(cls)
            found[cls.__name__] = {member.wire: _signature(member) for member in shape.members}
            for member in shape.members:
                if member.record is not None:
                    add(member.record)

    for cls in NAMES.values():
        add(cls)
    return dict(sorted(found.items()))


def released_text() -> bytes:
    """Return the text of `released.json` for the current classes."""
    return _pretty(fields())
