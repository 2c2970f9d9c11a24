"""Writes a bag of ROS 2, a folder that `ros2 bag play` takes. One of the few files that know rosbags.

Its `metadata.yaml` is written at the end.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime
from rosbags.rosbag2 import StoragePlugin, Writer, WriterError

from intellwheels_agents.record_gateway.ros_translator import BagEntry, RosTranslator
from intellwheels_agents.ros_gateway.chair_messages import Topic
from intellwheels_agents.ros_gateway.ros_types import encode_message, type_store
from intellwheels_schemas.messages import Map

VERSION: Final = 9
"""Version of `metadata.yaml` since ROS 2 Jazzy."""
_UNSET: Final = QosTime(0, 0)


class BagWriter:
    """An open bag.

    Attributes:
        messages: Messages so far.
    """

    def __init__(self, path: Path, storage: str, translator: RosTranslator) -> None:
        """Create the folder.

        Args:
            path: It; it does not exist.
            storage: `mcap` or `sqlite3`.
            translator: Makes messages of ROS.

        Raises:
            OSError: It cannot be created.
        """
        self.messages = 0
        self._translator = translator
        self._connections: dict[str, Any] = {}
        try:
            self._writer = Writer(path, version=VERSION, storage_plugin=StoragePlugin[storage.upper()])
            self._writer.open()
        except (WriterError, sqlite3.Error) as error:
            raise OSError(f"--ros2: {error}") from None

    def take(self, key: str, data: bytes, encoding: str) -> None:
        """Write what there is to write of a message of the world; for errors see `write`."""
        for entry in self._translator.take(key, data, encoding):
            self.write(entry)

    def take_map(self, document: Map) -> None:
        """Write a map; for errors see `write`."""
        for entry in self._translator.take_map(document):
            self.write(entry)

    def write(self, entry: BagEntry) -> None:
        """Write a message of ROS.

        Raises:
            OSError: The disk is full, or another error of the files.
        """
        topic = entry.topic
        try:
            connection = self._connections.get(topic.name)
            if connection is None:
                connection = self._connections[topic.name] = self._writer.add_connection(
                    topic.name, topic.type, typestore=type_store(), offered_qos_profiles=[_qos(topic)]
                )
            self._writer.write(connection, entry.time, encode_message(entry.message))
        except sqlite3.Error as error:
            raise OSError(f"--ros2: {error}") from None
        self.messages += 1

    @property
    def refused(self) -> Mapping[str, str]:
        """Why chairs are left out, by agent."""
        return self._translator.refused

    def close(self) -> None:
        """End the bag.

        Raises:
            OSError: The disk is full, or another error of the files.
        """
        try:
            self._writer.close()
        except sqlite3.Error as error:
            raise OSError(f"--ros2: {error}") from None


def _qos(topic: Topic) -> Qos:
    of = topic.qos
    return Qos(
        history=QosHistory.KEEP_LAST,
        depth=of.depth,
        reliability=QosReliability.RELIABLE if of.reliable else QosReliability.BEST_EFFORT,
        durability=QosDurability.TRANSIENT_LOCAL if of.transient_local else QosDurability.VOLATILE,
        deadline=_UNSET,
        lifespan=_UNSET,
        liveliness=QosLiveliness.AUTOMATIC,
        liveliness_lease_duration=_UNSET,
        avoid_ros_namespace_conventions=False,
    )
