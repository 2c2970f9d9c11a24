"""Reads YAML from anywhere: plain data only, no aliases, bounded depth. Pure."""

from __future__ import annotations

from typing import Any, Final

from intellwheels_maps.importers.floor_source import FloorSource
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.explain import shown

MAX_YAML_BYTES: Final = 16 << 20
"""Longest document, 16 MiB."""

MAX_NODES: Final = 250_000
"""Most lists, maps, keys and values; each takes more memory than text."""

MAX_DEPTH: Final = 40
"""Deepest nesting of lists and maps."""


def read_yaml(source: FloorSource) -> dict[Any, Any]:
    """Return the map of keys at the root of a YAML document.

    Raises:
        WireError: It is no such document, too long or too deep, or it has aliases, by which a few bytes can stand for
            gigabytes.
    """
    import yaml  # noqa: PLC0415 - of an extra

    if len(source.data) > MAX_YAML_BYTES:
        raise source.error("", f"expected at most {MAX_YAML_BYTES:,} bytes, got {len(source.data):,}", "too-long")
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    depth = nodes = 0
    try:
        # The parser is flat, unlike the composer: it finds what is too deep without recursion.
        for event in yaml.parse(source.data, Loader=loader):
            line = f"line {event.start_mark.line + 1}" if event.start_mark is not None else ""
            nodes += isinstance(event, yaml.NodeEvent)
            if nodes > MAX_NODES:
                raise source.error(line, f"expected at most {MAX_NODES:,} keys and values, got more", "too-many")
            if isinstance(event, yaml.AliasEvent):
                raise source.error(line, f"expected no aliases, got {shown(event.anchor)}", "malformed")
            if isinstance(event, yaml.CollectionStartEvent):
                depth += 1
                if depth > MAX_DEPTH:
                    raise source.error(line, f"expected at most {MAX_DEPTH} levels of nesting, got more", "malformed")
            elif isinstance(event, yaml.CollectionEndEvent):
                depth -= 1
        document = yaml.load(source.data, Loader=loader)  # noqa: S506 - a safe loader
    except WireError:
        raise
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = f"line {mark.line + 1}" if mark is not None else ""
        raise source.error(line, f"expected YAML, got {error.problem}", "malformed") from None
    except (yaml.YAMLError, ValueError, TypeError, OverflowError) as error:
        # Dates that do not exist, bytes that are no text, and keys that are lists.
        raise source.error("", f"expected YAML, got {shown(str(error))}", "malformed") from None
    if not isinstance(document, dict):
        raise source.error("", f"expected keys and values, got {shown(document)}", "malformed")
    return document
