from __future__ import annotations

import msgspec
import pytest

from intellwheels_agents.harness_outputs import Log, Reappear, RequestJoin
from intellwheels_agents.join_request import KEY_TRIES, JoinRequest
from intellwheels_schemas.codec import Encoding, decode
from intellwheels_schemas.messages import Robot

CHAIR = Robot(name="real1", kind="wheelchair", length=1.0, width=0.6, type="real", role="body", instance="1" * 16)


def test_bridge_without_a_key_joins_as_a_new_process_and_not_for_ever() -> None:
    request = JoinRequest(CHAIR, Encoding.JSON)
    assert request.again("0f" * 32) == []
    assert "already-here" not in request.transient
    seen = {CHAIR.instance}
    for _ in range(KEY_TRIES):
        said, token, join = request.again(None)
        assert isinstance(said, Log)
        assert isinstance(token, Reappear)
        assert isinstance(join, RequestJoin)
        assert decode(Robot, join.payload, Encoding.JSON) == msgspec.structs.replace(CHAIR, instance=token.instance)
        assert token.instance not in seen
        seen.add(token.instance)
        assert request.output == join
    assert request.again(None) == [], "a simulator that gives no keys"
    assert "already-here" in request.transient


@pytest.mark.parametrize("changes", [{"type": "simulated"}, {"role": "mind"}])
def test_who_has_no_motors_of_metal_needs_no_key(changes: dict[str, str]) -> None:
    robot = msgspec.structs.replace(CHAIR, **changes)
    assert JoinRequest(robot, Encoding.JSON).again(None) == []
