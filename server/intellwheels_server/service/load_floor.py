"""Finds the map that a `load` asks for."""

from __future__ import annotations

from intellwheels_maps import floor, names
from intellwheels_maps.check import check_map
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Load, Map

FINDINGS_SHOWN = 3
"""Faults of a map that the error names."""


def load_floor(load: Load) -> Map:
    """Return the map that a `load` names or contains.

    Raises:
        WireError: No map has that name, or the map in the message is wrong.
    """
    if load.map is None:
        known = names("floors")
        if load.name not in known:
            raise WireError("value", f"Load.Name: expected one of the maps ({', '.join(known)}), got '{load.name}'")
        return floor(str(load.name))
    findings = check_map(load.map)
    if findings:
        shown = findings[:FINDINGS_SHOWN]
        raise WireError("value", "; ".join(f"Load.{finding.element}: {finding.text}" for finding in shown))
    return load.map
