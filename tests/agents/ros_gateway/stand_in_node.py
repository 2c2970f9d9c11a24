"""A node of ROS 2 as rmw_zenoh_cpp puts one on Zenoh, with nothing of the gateway between: a peer that gossips.

Messages come from rosbags alone. Keys, tokens, attachments and hashes are written here a second time, from what a real
node of ROS 2 Kilted put on the wire.
"""

from __future__ import annotations

import json
import struct
import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Any, Self

import numpy as np
import zenoh
import zenoh.ext
from rosbags.typesys import Stores, get_typestore

STORE = get_typestore(Stores.ROS2_KILTED)

HASHES = {
    "nav_msgs/msg/Odometry": "3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0",
    "sensor_msgs/msg/LaserScan": "64c191398013af96509d518dac71d5164f9382553fce5c1f8cca5be7924bd828",
    "sensor_msgs/msg/Range": "b42b62562e93cbfe9d42b82fe5994dfa3d63d7d5c90a317981703f7388adff3a",
    "sensor_msgs/msg/Imu": "7d9a00ff131080897a5ec7e26e315954b8eae3353c3f995c55faf71574000b5b",
    "sensor_msgs/msg/JointState": "a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e",
    "geometry_msgs/msg/Twist": "9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a",
    "geometry_msgs/msg/TwistStamped": "5f0fcd4f81d5d06ad9b4c4c63e3ea51b82d6ae4d0558f1d475229b1121db6f64",
    "geometry_msgs/msg/PoseStamped": "10f3786d7d40fd2b54367835614bff85d4ad3b5dab62bf8bca0cc232d73b4cd8",
    "rosgraph_msgs/msg/Clock": "692f7a66e93a3c83e71765d033b60349ba68023a8c689a79e48078bcb5c58564",
    "nav_msgs/msg/OccupancyGrid": "8d348150c12913a31ee0ec170fbf25089e4745d17035792a1ba94d6f0bc0cfc7",
    "tf2_msgs/msg/TFMessage": "e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087",
    "diagnostic_msgs/msg/DiagnosticArray": None,
}
"""The hashes of the real node, where it had the type."""


class Heard(deque[Any]):
    """What a subscription heard, newest last, as (seconds of the clock, message)."""

    def __init__(self) -> None:
        super().__init__(maxlen=5000)
        self.attachments: deque[bytes] = deque(maxlen=5000)


class StandInNode:
    """A node `/stand_in` in the domain 0."""

    def __init__(self, endpoint: str, deadline: float = 30.0) -> None:
        config = zenoh.Config()
        for name, value in (
            ("mode", "peer"), ("connect/endpoints", [endpoint]), ("listen/endpoints", ["tcp/127.0.0.1:0"]),
            ("scouting/multicast/enabled", False), ("scouting/gossip/enabled", True),
            ("timestamping/enabled", True),
        ):  # fmt: skip
            config.insert_json5(name, json.dumps(value))
        self.session = zenoh.open(config)
        self.deadline = deadline
        self._some = threading.Condition()
        self._numbers = iter(range(1, 10_000))
        self._sequence = 0
        self._open: list[Any] = []
        self.graph: set[str] = set()
        self._node = f"@ros2_lv/0/{self.session.info.zid()}/0"
        self._declare(f"{self._node}/0/NN/%/%/stand_in")
        self._open.append(self.session.liveliness().declare_subscriber("@ros2_lv/0/**", self._on_token, history=True))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for one in reversed(self._open):
            one.undeclare()
        self.session.close()  # type: ignore[no-untyped-call]

    # ------------------------------------------------------------ the graph

    def _declare(self, token: str) -> None:
        self._open.append(self.session.liveliness().declare_token(token))

    def _on_token(self, sample: zenoh.Sample) -> None:
        with self._some:
            change = self.graph.add if sample.kind == zenoh.SampleKind.PUT else self.graph.discard
            change(str(sample.key_expr))
            self._some.notify_all()

    def wait(self, found: Callable[[], Any], what: str) -> Any:
        """Wait until `found` returns something, and return that."""
        end = time.monotonic() + self.deadline
        while not (value := found()):
            left = end - time.monotonic()
            assert left > 0, f"expected {what} within {self.deadline:g} s; the graph is {sorted(self.graph)}"
            with self._some:
                self._some.wait(min(left, 0.05))
        return value

    def entities(self, kind: str) -> dict[str, tuple[str, ...]]:
        """Return topics or services of the graph: node, type, hash and quality of service by name."""
        found = {}
        for token in list(self.graph):
            chunks = token.split("/")
            if len(chunks) == 13 and chunks[5] == kind:
                found[chunks[9].replace("%", "/")] = (f"{chunks[7]}/{chunks[8]}", *chunks[10:])
        return found

    # ------------------------------------------------------------ topics

    @staticmethod
    def key(topic: str, kind: str, type_hash: str | None = None) -> str:
        package, folder, name = kind.split("/")
        known = HASHES[kind]
        digest = type_hash or (f"RIHS01_{known}" if known else "*")
        return f"0/{topic[1:]}/{package}::{folder}::dds_::{name}_/{digest}"

    def hear(self, topic: str, kind: str, *, latched: bool = False) -> Heard:
        """Subscribe to a topic."""
        heard = Heard()

        def store(sample: zenoh.Sample) -> None:
            message = STORE.deserialize_cdr(sample.payload.to_bytes(), kind)
            assert sample.attachment is not None
            with self._some:
                heard.append(message)
                heard.attachments.append(sample.attachment.to_bytes())
                self._some.notify_all()

        key = self.key(topic, kind)
        if latched:
            subscriber: Any = zenoh.ext.declare_advanced_subscriber(
                self.session, key, store,
                history=zenoh.ext.HistoryConfig(detect_late_publishers=True, max_samples=1),
                recovery=zenoh.ext.RecoveryConfig(periodic_queries=None, heartbeat=True),
            )  # fmt: skip
        else:
            subscriber = self.session.declare_subscriber(key, store)
        self._open.append(subscriber)
        return heard

    def attachment(self) -> bytes:
        self._sequence += 1
        return struct.pack("<qqB16s", self._sequence, time.time_ns(), 16, b"stand-in-node-id")

    def put(self, topic: str, kind: str, message: Any) -> None:
        """Publish a message."""
        data = bytes(STORE.serialize_cdr(message, kind))
        self.session.put(self.key(topic, kind), data, attachment=self.attachment())

    def raw(self, key: str, data: bytes, attachment: bytes | None) -> None:
        """Publish bytes."""
        self.session.put(key, data, attachment=attachment)

    # ------------------------------------------------------------ services

    def call(self, service: str, data: bytes, attachment: bytes | None = None, timeout: float = 20.0) -> bytes | None:
        """Call a service of the graph with a request in CDR, and return the response, or None without one."""
        _, dds, digest, _ = self.wait(lambda: self.entities("SS").get(service), f"the service {service}")
        sent = self.attachment() if attachment is None else attachment
        replies = self.session.get(
            f"0/{service[1:]}/{dds}/{digest}", payload=data, attachment=sent or None, timeout=timeout,
            target=zenoh.QueryTarget.ALL_COMPLETE, consolidation=zenoh.ConsolidationMode.NONE,
        )  # fmt: skip
        for reply in replies:
            assert reply.ok is not None
            returned = reply.ok.attachment
            assert returned is not None
            # The sequence and the id are those of the request.
            assert returned.to_bytes()[:8] == sent[:8]
            assert returned.to_bytes()[16:] == sent[16:]
            return bytes(reply.ok.payload.to_bytes())
        return None


def twist(speed: float, turn_rate: float) -> Any:
    """Return a `geometry_msgs/Twist`."""
    vector = STORE.types["geometry_msgs/msg/Vector3"]
    return STORE.types["geometry_msgs/msg/Twist"](
        linear=vector(x=speed, y=0.0, z=0.0), angular=vector(x=0.0, y=0.0, z=turn_rate)
    )


def header(frame: str, seconds: float) -> Any:
    """Return a `std_msgs/Header`."""
    stamp = STORE.types["builtin_interfaces/msg/Time"](sec=int(seconds), nanosec=round(seconds % 1.0 * 1e9))
    return STORE.types["std_msgs/msg/Header"](stamp=stamp, frame_id=frame)


def twist_stamped(speed: float, turn_rate: float, seconds: float, frame: str = "") -> Any:
    """Return a `geometry_msgs/TwistStamped`."""
    return STORE.types["geometry_msgs/msg/TwistStamped"](header=header(frame, seconds), twist=twist(speed, turn_rate))


def pose_stamped(x: float, y: float, heading: float, frame: str = "map") -> Any:
    """Return a `geometry_msgs/PoseStamped`."""
    types = STORE.types
    turn = types["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=np.sin(heading / 2), w=np.cos(heading / 2))
    pose = types["geometry_msgs/msg/Pose"](position=types["geometry_msgs/msg/Point"](x=x, y=y, z=0.0), orientation=turn)
    return types["geometry_msgs/msg/PoseStamped"](header=header(frame, 0.0), pose=pose)


def seconds_of(stamp: Any) -> float:
    """Return a `builtin_interfaces/Time` in seconds."""
    return float(stamp.sec + stamp.nanosec * 1e-9)
