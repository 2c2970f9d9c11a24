"""Every kind of sensor, found in the files of this package.

The contract says which kinds there must be: the fields that `Robot` and `Sensors` share.
"""

from __future__ import annotations

import inspect
import pkgutil
import sys
from importlib import import_module
from typing import Final

from intellwheels_schemas.messages import Map, Record
from intellwheels_schemas.rules import SENSOR_RECORDS
from intellwheels_server.world.sensors.kind import Kind

_PACKAGE: Final = __name__.rpartition(".")[0]


def find_kinds() -> dict[type, Kind]:
    """Return the kind that each file of the package defines, by its declaration, in the order of the contract.

    Raises:
        TypeError: Two kinds serve one declaration, or a declaration of the contract has none.
    """
    found: dict[type, Kind] = {}
    for module in pkgutil.iter_modules(sys.modules[_PACKAGE].__path__, f"{_PACKAGE}."):
        if module.name == __name__:
            continue
        loaded = import_module(module.name)
        for value in vars(loaded).values():
            if not (isinstance(value, type) and issubclass(value, Kind)) or inspect.isabstract(value):
                continue
            if value.__module__ != module.name:  # imported from where it is defined
                continue
            if value.declaration in found:
                raise TypeError(f"{value.declaration.__name__}: expected 1 kind, got another in {module.name}")
            found[value.declaration] = value()
    declarations = [records.declaration for records in SENSOR_RECORDS.values()]
    for declaration in declarations:
        if declaration not in found:
            raise TypeError(f"{declaration.__name__}: expected a kind of sensor in a file of {_PACKAGE}, got none")
    return {declaration: found[declaration] for declaration in declarations}


KINDS: Final = find_kinds()
"""The kinds, by their declaration."""


def example_sensors(floor: Map) -> dict[str, tuple[Record, ...]]:
    """Return sensors that together need every kernel of every kind, by their field of `Robot`.

    Args:
        floor: The map that their robot will be on, with at least one named place.
    """
    return {kind.field: kind.examples(floor) for kind in KINDS.values()}
