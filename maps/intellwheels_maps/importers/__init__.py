"""Floors in the formats of other programs: pure functions from the bytes of a file to a `Map`.

Nothing is invented. What a format has and a map cannot have, or what is not certain, is left out and listed with its
place.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final, NamedTuple

from intellwheels_maps.importers.ciber_lab import import_lab, is_lab
from intellwheels_maps.importers.dxf_plan import import_dxf
from intellwheels_maps.importers.floor_source import FloorSource, Imported
from intellwheels_maps.importers.geojson_floor import import_geojson
from intellwheels_maps.importers.ifc_storey import import_ifc
from intellwheels_maps.importers.rmf_building import import_rmf_building
from intellwheels_maps.importers.ros_map import import_ros_map
from intellwheels_schemas.extras import missing_extra

__all__ = ["ENDINGS", "FORMATS", "FloorSource", "Imported", "import_floor", "is_lab"]


class _Format(NamedTuple):
    read: Callable[[FloorSource], Imported]
    extras: tuple[str, ...]


_FORMATS: Final[Mapping[str, _Format]] = {
    ".building.yaml": _Format(import_rmf_building, ("floors",)),
    ".yaml": _Format(import_ros_map, ("floors",)),
    ".dxf": _Format(import_dxf, ("floors",)),
    ".ifc": _Format(import_ifc, ("ifc",)),
    ".geojson": _Format(import_geojson, ("floors",)),
}
"""The formats by the ending of a file's name. The first ending that fits counts."""

ENDINGS: Final = tuple(_FORMATS)
"""What the names of files end in that `import_floor` reads."""

FORMATS: Final = tuple(f"*{ending}" for ending in ENDINGS)
"""The same, for help and errors."""


def import_floor(source: FloorSource) -> Imported:
    """Return the map in a file, and what was left out.

    Raises:
        WireError: The file is invalid, or an extra is not installed.
    """
    found = next((form for ending, form in _FORMATS.items() if source.name.endswith(ending)), None)
    if found is None:
        return import_lab(source)  # the only format whose name ends as that of a map
    lacking = missing_extra(*found.extras)
    if lacking is not None:
        raise source.error("", lacking)
    return found.read(source)
