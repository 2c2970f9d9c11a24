"""The types of ROS messages: names, hashes and bytes (CDR). One of the few files that know rosbags.

A service `pkg/srv/Name` has the types `pkg/srv/Name_Request` and `pkg/srv/Name_Response`. Its hash covers both, and the
event type that every service has.
"""

from __future__ import annotations

from functools import cache
from typing import Any, Final

import numpy as np
from rosbags.interfaces import Nodetype
from rosbags.serde import SerdeError
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from intellwheels_agents.ros_gateway.rmw_wire import RosType
from intellwheels_agents.ros_gateway.simulation_types import MESSAGES, PACKAGE, SERVICES
from intellwheels_schemas.errors import WireError

LONGEST_SEQUENCE: Final = 1 << 20
"""Largest number of items of a list that is read."""
_EVENT_INFO: Final = "service_msgs/msg/ServiceEventInfo"


@cache
def type_store() -> Typestore:
    """Return the types of ROS 2 Kilted and those of `simulation_interfaces`."""
    store = get_typestore(Stores.ROS2_KILTED)
    store.max_sequence_length = LONGEST_SEQUENCE
    constants, fields = store.fielddefs[_EVENT_INFO]
    # In ROS, `char` is another name of `uint8`. To rosbags it is a type of its own, and the hash of a service differs.
    gid: Any = (Nodetype.ARRAY, ((Nodetype.BASE, ("uint8", 0)), 16))
    store.fielddefs[_EVENT_INFO] = constants, [(name, gid if name == "client_gid" else of) for name, of in fields]
    found: Any = {}
    for name, text in MESSAGES.items():
        found.update(_parsed(f"{PACKAGE}/msg/{name}", text))
    for name, (request, response) in SERVICES.items():
        base = f"{PACKAGE}/srv/{name}"
        for part, text in (("Request", request), ("Response", response)):
            found.update(_parsed(f"{base}_{part}", text))
        one = {part: (Nodetype.NAME, f"{base}_{part}") for part in ("Request", "Response", "Event")}
        found[f"{base}_Event"] = (
            [],
            [
                ("info", (Nodetype.NAME, _EVENT_INFO)),
                ("request", (Nodetype.SEQUENCE, (one["Request"], 1))),
                ("response", (Nodetype.SEQUENCE, (one["Response"], 1))),
            ],
        )
        found[base] = [], [(f"{part.lower()}_message", of) for part, of in one.items()]
    store.register(found)
    return store


def _parsed(name: str, text: str) -> Any:
    """Return the definition of a type of `simulation_interfaces`."""
    if not text:
        return {name: ([], [("structure_needs_at_least_one_member", (Nodetype.BASE, ("uint8", 0)))])}
    lines = []
    for line in text.split("; "):
        kind = line.partition(" ")[0].removesuffix("[]")
        lines.append(f"{PACKAGE}/{line}" if kind in MESSAGES else line)
    (definition,) = get_types_from_msg("\n".join(lines) + "\n", f"{PACKAGE}/msg/Any").values()
    return {name: definition}


@cache
def ros_type(name: str) -> RosType:
    """Return a type of a message or a service by its name, such as `sensor_msgs/msg/Imu`."""
    return RosType(name, type_store().hash_rihs01(name))


@cache
def made_of(name: str) -> Any:
    """Return the class of a message by the name of its type."""
    return type_store().types[name]


def encode_message(message: Any) -> bytes:
    """Return a message in CDR, little endian, with its header of four bytes."""
    return bytes(type_store().serialize_cdr(message, message.__msgtype__, little_endian=True))


def decode_message(name: str, data: bytes) -> Any:
    """Return a message.

    Args:
        name: The name of its type.
        data: The bytes, in CDR.

    Raises:
        WireError: The bytes are not such a message.
    """
    try:
        return type_store().deserialize_cdr(data, name)
    except SerdeError as error:
        raise WireError("malformed", f"{name}: expected a message in CDR, got {len(data)} bytes: {error}") from None
    # The code that rosbags generates indexes into the bytes. What it raises on foreign bytes is not documented.
    except Exception as error:
        text = f"{name}: expected a message in CDR, got {len(data)} bytes: {type(error).__name__}"
        raise WireError("malformed", text) from None


def blank(name: str) -> Any:
    """Return a message of a type with zeros, empty texts and empty lists."""
    fields = (field for field in type_store().fielddefs[name][1])
    return made_of(name)(**{field: _blank_value(of) for field, of in fields})


def _blank_value(of: Any) -> Any:
    kind, what = of
    if kind == Nodetype.NAME:
        return blank(what)
    if kind == Nodetype.BASE:
        return {"string": "", "bool": False, "float64": 0.0, "float32": 0.0}.get(what[0], 0)
    (item_kind, item), count = what
    if item_kind == Nodetype.BASE and item[0] != "string":
        return np.zeros(count if kind == Nodetype.ARRAY else 0, dtype=item[0])
    return [blank(item) for _ in range(count)] if kind == Nodetype.ARRAY else []
