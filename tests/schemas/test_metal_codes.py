from __future__ import annotations

import hashlib
import hmac
from pathlib import Path

import msgspec

from intellwheels_schemas.messages import Pose, PowerInForce
from intellwheels_schemas.metal_codes import code_of, is_genuine, new_key, pose_line, power_line
from intellwheels_schemas.vectors import KEY, RUN, VALID


def test_line_of_the_vectors_is_as_the_protocol_says() -> None:
    power, pose = VALID["Power-coded"], VALID["Pose-coded"]
    assert isinstance(power, PowerInForce)
    assert isinstance(pose, Pose)
    assert power_line(power) == f"power {RUN} 41 7 3fe0000000000000 bfd0000000000000 drive"
    assert pose_line(pose) == (f"pose {RUN} 41 41 3ff4000000000000 c000000000000000 3fb999999999999a 41dad27480200000")
    for message, line in ((power, power_line(power)), (pose, pose_line(pose))):
        full = hmac.digest(bytes(range(32)), line.encode(), hashlib.sha256).hex()
        assert message.code == full[:32] == code_of(KEY, line)
        assert is_genuine(KEY, line, message.code)


def test_page_of_the_protocol_has_the_lines_and_codes_of_the_vectors() -> None:
    page = (Path(__file__).parents[2] / "agents/intellwheels_agents/bridge/PROTOCOL.md").read_text(encoding="utf-8")
    power, pose = VALID["Power-coded"], VALID["Pose-coded"]
    assert isinstance(power, PowerInForce)
    assert isinstance(pose, Pose)
    assert f"{power_line(power)}\n{power.code}\n{pose_line(pose)}\n{pose.code}\n" in page
    assert KEY in page


def test_absent_fields_are_dashes() -> None:
    assert pose_line(Pose(x=0.0, y=0.0, heading=0.0)) == f"pose - - - {'0' * 16} {'0' * 16} {'0' * 16} -"


def test_without_a_key_or_a_code_nothing_is_genuine() -> None:
    assert not is_genuine(None, "power", code_of(KEY, "power"))
    assert not is_genuine(KEY, "power", None)
    assert not is_genuine(new_key(), "power", code_of(KEY, "power"))


def test_every_value_is_covered() -> None:
    pose = VALID["Pose-coded"]
    assert isinstance(pose, Pose)
    for field, value in {
        "run": "0" * 16,
        "tick": 1,
        "seq": 1,
        "x": 9.0,
        "y": 9.0,
        "heading": 1.0,
        "stamp": 1.0,
    }.items():
        assert pose_line(msgspec.structs.replace(pose, **{field: value})) != pose_line(pose)
