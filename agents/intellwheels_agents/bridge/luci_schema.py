"""The messages of LUCI's gRPC service `sensors.Sensors` that a bridge needs, as protobuf classes.

The table names each field with its number and type; the protobuf library makes the classes from it. Fields that a
bridge does not read are left out: protobuf skips what it does not know. Enumerations are declared as their numbers.

Source:
    `sensors.proto` of the maker's SDK (github.com/lucimobility/luci-ros2-grpc, Apache 2.0).
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any, Final

from intellwheels_schemas.errors import WireError

if TYPE_CHECKING:
    from google.protobuf.message import Message

SERVICE: Final = "/sensors.Sensors/"
"""What the path of every method begins with."""

TABLE: Final[dict[str, dict[str, tuple[int, str]]]] = {
    "Empty": {},
    "Response": {"reply": (1, "string"), "return_code": (2, "int32")},
    "InputSourceRequest": {"source": (1, "int32")},
    "RemoteJsValues": {"forward_back": (1, "int32"), "left_right": (2, "int32"), "source": (3, "int32")},
    "JoystickData": {"forward_back": (1, "int32"), "left_right": (2, "int32"), "source": (4, "int32")},
    "ActiveScaling": {"joystick": (1, "JoystickData")},
    "EncoderData": {"left_angle": (1, "float"), "right_angle": (2, "float"), "edge_timestamp": (7, "uint32")},
    "Point3D": {"x": (1, "float"), "y": (2, "float"), "z": (3, "float")},
    "UltrasonicDistance": {"distance": (1, "double"), "arc_points": (6, "repeated Point3D")},
    "UltrasonicDistances": {"distances": (1, "repeated UltrasonicDistance")},
    "RadarPoint": {"x": (1, "double"), "y": (2, "double"), "z": (3, "double")},
    "RadarPoints": {"points": (1, "repeated RadarPoint"), "source": (2, "int32")},
    "ImuCtrl": {"imu": (1, "int32")},
    "ImuData": {
        "acceleration_x": (5, "double"), "acceleration_y": (6, "double"), "acceleration_z": (7, "double"),
        "gyro_x": (8, "double"), "gyro_y": (9, "double"), "gyro_z": (10, "double"),
        "gravity_x": (20, "double"), "gravity_y": (21, "double"), "gravity_z": (22, "double"),
        "source": (28, "int32"),
    },
}  # fmt: skip
"""Number and type of each field, by message."""

AUTONOMOUS_REMOTE: Final = 1
"""The input source of a program: the chair's own joystick rests while it is set. `InputSource` in the SDK."""
IMU_MPU: Final = 2
"""The inertial unit in LUCI's processor box; another one sits in the footplate. `Imu` in the SDK."""


def message(name: str, **fields: Any) -> Message:
    """Return a message of the table with some fields set."""
    return _classes()[name](**fields)


def parsed(name: str, data: bytes) -> Any:
    """Return the message in bytes from the chair.

    Raises:
        WireError: `malformed`, when they are not that message; the place is its name.
    """
    from google.protobuf.message import DecodeError  # noqa: PLC0415 - as in `_classes`

    try:
        return _classes()[name].FromString(data)
    except DecodeError:
        text = f"{name}: expected a protobuf message of this kind, got {len(data)} bytes that are none"
        raise WireError("malformed", text, name) from None


@cache
def _classes() -> dict[str, type[Message]]:
    """Return the class of each message of the table."""
    # An optional dependency, which agents do not need.
    from google.protobuf import descriptor_pb2, descriptor_pool, message_factory  # noqa: PLC0415

    file = descriptor_pb2.FileDescriptorProto(name="luci.proto", package="sensors", syntax="proto3")
    kinds = descriptor_pb2.FieldDescriptorProto
    for name, fields in TABLE.items():
        declared = file.message_type.add(name=name)
        for field, (number, kind) in fields.items():
            label = kinds.LABEL_REPEATED if kind.startswith("repeated ") else kinds.LABEL_OPTIONAL
            what = kind.removeprefix("repeated ")
            if what in TABLE:
                declared.field.add(
                    name=field, number=number, label=label, type=kinds.TYPE_MESSAGE, type_name=f".sensors.{what}"
                )
            else:
                scalar = kinds.Type.Value(f"TYPE_{what.upper()}")
                declared.field.add(name=field, number=number, label=label, type=scalar)
    pool = descriptor_pool.DescriptorPool()
    pool.Add(file)
    return {name: message_factory.GetMessageClass(pool.FindMessageTypeByName(f"sensors.{name}")) for name in TABLE}
