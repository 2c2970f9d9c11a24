"""Bodies and states for the tests of the drawings."""

from __future__ import annotations

import json
import struct
from typing import Any

import msgspec

from intellwheels_maps import library
from intellwheels_schemas.messages import Body, Entity, Robot

RUN = "0" * 16


def robot(name: str, **fields: Any) -> Robot:
    return msgspec.structs.replace(library.robot(name), **fields)


def body(name: str, **fields: Any) -> Body:
    return Body(run=RUN, tick=0, robot=robot(name, **fields))


def entity(name: str, x: float = 0.0, y: float = 0.0, heading: float = 0.0, **fields: Any) -> Entity:
    return Entity(name=name, x=x, y=y, heading=heading, **fields)


def triangles(handle: Any) -> int:
    """Return the triangles of one instance of a node, of a simple mesh or of a GLB file."""
    props = handle._impl.props
    if not hasattr(props, "glb_data"):
        return len(props.faces) if hasattr(props, "faces") else 0
    length = struct.unpack_from("<I", props.glb_data, 12)[0]
    tree = json.loads(props.glb_data[20 : 20 + length])
    return sum(tree["accessors"][each["indices"]]["count"] // 3 for each in tree["meshes"][0]["primitives"])


def node(scene: Any, name: str) -> Any:
    """Return viser's handle of a node, None when there is none."""
    return scene._handle_from_node_name.get(name)
