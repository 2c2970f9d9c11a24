"""Finds, checks and cuts the map that a `load` asks for.

This may take long, so a side process does it, and the world goes on meanwhile.
"""

from __future__ import annotations

from typing import Final, NamedTuple, Protocol

from intellwheels_maps import floor, names
from intellwheels_maps.check import check_map
from intellwheels_schemas.codec import Encoding, decode, encode, encoding_of
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import End, Load, Map, ResultCode
from intellwheels_server.service.side_process import Outcome
from intellwheels_server.world.kernels.arrays import Walls
from intellwheels_server.world.map_geometry import walls_of

FINDINGS_SHOWN: Final = 3
"""Faults of a map that the error names."""


class LoadRequest(NamedTuple):
    """The bytes of a `load`, and their encoding as text."""

    data: bytes
    encoding: str


class LoadedFloor(NamedTuple):
    """What a `load` asks for.

    Attributes:
        floor: The map.
        walls: Its walls, cut.
        seed: The seed of the new run, if it gives one.
        end: The end condition of the new run, if it gives one.
    """

    floor: Map
    walls: Walls
    seed: str | None
    end: End | None


class LoadFault(NamedTuple):
    """Why a `load` fails.

    Attributes:
        code: The code of the result.
        text: The words.
        malformed: Whether its bytes are no `Load`.
    """

    code: ResultCode
    text: str
    malformed: bool = False


class PackedFloor(NamedTuple):
    """A loaded floor on its way between processes. Bytes of the contract are faster than pickled objects."""

    floor: bytes
    walls: Walls
    seed: str | None
    end: End | None


class FloorWorker(Protocol):
    """Loads one floor at a time, beside the world."""

    def begin(self, request: LoadRequest, limit: float) -> None:
        """Begin to load a floor, and give up after so many seconds. None may be being loaded."""

    def take(self) -> Outcome[PackedFloor | LoadFault] | None:
        """Return what became of the request, once, or None as long as it is not known."""


def load_floor(request: LoadRequest) -> PackedFloor | LoadFault:
    """Return the floor that a `load` names or contains, or why it fails."""
    try:
        data = request.data or b"{}"
        load = decode(Load, data, encoding_of(request.encoding, data) if request.data else Encoding.JSON)
    except WireError as error:
        return LoadFault("failed", error.text, malformed=True)
    try:
        found = _floor_of(load)
    except WireError as error:
        return LoadFault("not-found" if load.map is None else "failed", error.text)
    try:
        walls = walls_of(found)
    except ValueError as error:
        return LoadFault("failed", f"Load.Map: {error}")
    return PackedFloor(encode(found), walls, load.seed, load.end)


def unpack(packed: PackedFloor) -> LoadedFloor:
    """Return a packed floor as it was."""
    return LoadedFloor(decode(Map, packed.floor, Encoding.JSON), packed.walls, packed.seed, packed.end)


def _floor_of(load: Load) -> Map:
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
