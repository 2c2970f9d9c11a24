"""YAML from anywhere costs no more than it is long."""

from __future__ import annotations

import pytest

from intellwheels_maps.importers.floor_source import FloorSource
from intellwheels_maps.importers.safe_yaml import MAX_YAML_BYTES, read_yaml
from intellwheels_schemas.errors import WireError
from tests.every_case import every_case

LAUGHS = b"a: &a [x, x]\nb: &b [*a, *a]\nc: [*b, *b]\n"


def read(data: bytes) -> object:
    return read_yaml(FloorSource("f.yaml", data, lambda _: b""))


def test_plain_data_is_read() -> None:
    assert read(b"a: 1\nb: [2, {c: d}]\n") == {"a": 1, "b": [2, {"c": "d"}]}


@every_case(
    ("data", "text"),
    [
        (LAUGHS, r"f\.yaml: line 2: expected no aliases, got 'a'"),
        (b"a: " + b"[" * 100_000, r"f\.yaml: line 1: expected"),
        (b"a: " + b"{a: " * 100, r"f\.yaml: line 1: expected at most 40 levels of nesting"),
        (b"a: [1\nb: 2", r"f\.yaml: line \d: expected YAML"),
        (b"a: !!python/object/apply:os.system [x]", r"f\.yaml: line 1: expected YAML"),
        (b"a: 2020-13-45", r"f\.yaml: expected YAML"),
        (b"? [a, b]\n: c", r"f\.yaml.*expected YAML"),
        (b"- 1", r"f\.yaml: expected keys and values, got a list"),
        (b"\x80", r"f\.yaml: expected YAML"),
        (b"a: " + b"x" * MAX_YAML_BYTES, r"f\.yaml: expected at most 16,777,216 bytes"),
        (b"a: [" + b"1," * 300_000 + b"1]", r"f\.yaml: line 1: expected at most 250,000 keys and values"),
    ],
    ids=["laughs", "lists", "maps", "open", "object", "date", "key", "list", "bytes", "long", "many"],
)
def test_what_is_no_plain_data_is_refused_with_its_line(data: bytes, text: str) -> None:
    with pytest.raises(WireError, match=text):
        read(data)
