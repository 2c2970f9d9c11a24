"""Reads a message of Foxglove with protobuf and the schema that a recording carries, not with the library itself."""

from __future__ import annotations

from typing import Any

from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.descriptor_pool import DescriptorPool
from google.protobuf.message_factory import GetMessageClass


def decoded(message: Any) -> Any:
    """Return a message as protobuf reads it."""
    schema = message.get_schema()
    pool = DescriptorPool()
    for file in FileDescriptorSet.FromString(schema.data).file:
        pool.Add(file)
    return GetMessageClass(pool.FindMessageTypeByName(schema.name)).FromString(message.encode())
